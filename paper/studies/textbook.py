"""Whether errors of summary fits hold, on textbook distributions of which the smallest possible error is known."""

from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import polygamma

import avobench
from avobench.bench.cells.streams import stream
from avobench.diagnosis.settings import TEST
from avobench.tasks import Task
from paper.studies.files import StudyFile

FILE = StudyFile("textbook")
NUM_FITS = 12
"""Data sets of each distribution, the same for each way of fitting."""
BUDGET = 200_000
"""Simulated events of a fit; a diagnosis has no limit."""
EULER = np.euler_gamma


class Textbook(NamedTuple):
    """A distribution with parameters, and the Fisher information that one of its events has on them."""

    prior: dict[str, tuple[float, float]]
    truth: tuple[float, ...]
    num_events: int
    draw: Callable[[NDArray[np.float64], np.random.Generator], NDArray]
    """Events of the columns of parameters (p, n)."""
    information: list[list[float]]


OF_SHAPE = {"shape": (0.3, 8), "scale": (0.2, 5)}
DISTRIBUTIONS = {
    "gamma": Textbook(
        *(OF_SHAPE, (2, 1), 1000, lambda theta, rng: rng.gamma(*theta)),
        [[polygamma(1, 2.0), 1], [1, 2]],
    ),
    "Weibull": Textbook(
        *(OF_SHAPE, (1.5, 1), 2000, lambda theta, rng: theta[1] * rng.weibull(theta[0])),
        [[((1 - EULER) ** 2 + np.pi**2 / 6) / 1.5**2, EULER - 1], [EULER - 1, 1.5**2]],
    ),
    "Gaussian": Textbook(
        *({"mean": (-5, 5), "width": (0.1, 5)}, (1, 1), 2000, lambda theta, rng: rng.normal(*theta)),
        [[1, 0], [0, 2]],
    ),
    "lognormal": Textbook(
        *({"mean": (-3, 3), "width": (0.1, 2)}, (0.5, 0.7), 1200, lambda theta, rng: rng.lognormal(*theta)),
        [[1 / 0.7**2, 0], [0, 2 / 0.7**2]],
    ),
    "exponential": Textbook(
        *({"mean": (0.1, 10)}, (2,), 3000, lambda theta, rng: rng.exponential(theta[0])),
        [[1 / 2**2]],
    ),
    "Poisson": Textbook(
        *({"rate": (0.5, 60)}, (7,), 2000, lambda theta, rng: rng.poisson(theta[0]).astype(float)),
        [[1 / 7]],
    ),
}


def task_of(name: str) -> Task:
    of = DISTRIBUTIONS[name]
    return avobench.task(lambda theta, rng: of.draw(theta.T, rng), prior=of.prior, features=["x"], name=name)


def diagnosed(task: Task, x: NDArray, seed: int) -> tuple[list[float], list[float], str]:
    found = avobench.diagnose(task, x, seed=seed, max_effects=0, progress=False).diagnosis
    values = list(found.theta_before.values())
    alarm = found.p_value_before < found.alpha
    return [each.value for each in values], [each.std for each in values], "rejected" * alarm


def joint(task: Task, x: NDArray, seed: int) -> tuple[list[float], list[float], str]:
    halves = {"first": (task, x[::2]), "second": (task, x[1::2])}
    return told(avobench.infer(avobench.joint(halves), budget=BUDGET, seed=seed, progress=False))


def table_of(task: Task, x: NDArray, seed: int) -> tuple[list[float], list[float], str]:
    edges = np.unique(np.quantile(x, np.linspace(0, 1, 31)))
    if (x == np.round(x)).all():
        edges = np.arange(x.min() - 0.5, x.max() + 1)
    edges[0], edges[-1] = -np.inf, np.inf
    table = avobench.Table(edges, np.histogram(x, edges)[0], feature="x")
    return told(avobench.infer(task, table, budget=BUDGET, seed=seed, progress=False))


def from_bank(task: Task, x: NDArray, seed: int) -> tuple[list[float], list[float], str]:
    with TemporaryDirectory() as folder:
        return told(avobench.infer(task, x, budget=BUDGET, seed=seed, progress=False, bank=folder))


def told(found: "avobench.Inference") -> tuple[list[float], list[float], str]:
    return list(found.theta.values()), list(found.std.values()), found.estimate.doubt


WAYS = {"diagnose": diagnosed, "joint": joint, "a table": table_of, "bank=": from_bank}
"""How the events are fitted, by what the table calls it."""


def made(path: Path, seed: int = 0, num_fits: int = NUM_FITS) -> dict[str, Any]:
    """The record of the study at `path`, of which each fit that is lacking is made and written at once.

    `fits` holds for each the `distribution`, `way` and `fit`, the `off` of each parameter from the truth and its
    quoted `error`, both in units of the smallest possible error from as many events, and a `doubt`. Raises StoreError
    for a damaged file.
    """
    wanted = [
        ({"distribution": name, "way": way, "fit": fit}, partial(one, name, way, fit, seed))
        for fit, name, way in product(range(num_fits), DISTRIBUTIONS, WAYS)
    ]
    return FILE.completed(path, "fits", wanted, seed=seed, budget=BUDGET)


def one(name: str, way: str, fit: int, seed: int) -> dict[str, Any]:
    """A fit of events that are the same for each way."""
    of, task = DISTRIBUTIONS[name], task_of(name)
    x = task.simulate(np.tile(of.truth, (of.num_events, 1)), stream(seed, "textbook", name, str(fit)))
    least = np.sqrt(np.diag(np.linalg.inv(of.information)) / of.num_events)
    theta, error, doubt = WAYS[way](task, x, fit)
    return {"off": ((theta - np.array(of.truth)) / least).tolist(), "error": (error / least).tolist(), "doubt": doubt}


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a distribution and way, of all its fits and parameters.

    `error` is the median of quoted errors and `off` the root mean square of differences from the truth, in smallest
    possible errors; of a diagnosis that is of the events that it does not keep aside. `rms pull` is that of differences
    in quoted errors, 1 where these hold. `silent` counts the fits with a parameter that is more than three quoted
    errors off, and no doubt, and `doubted` those that are doubted or rejected.
    """
    rows = []
    for (name, way), fits in pd.DataFrame(records[0]["fits"]).groupby(["distribution", "way"], sort=False):
        share = 1 - TEST.held_out_share if way == "diagnose" else 1.0
        off, error = np.sqrt(share) * np.stack(fits["off"]), np.sqrt(share) * np.stack(fits["error"])
        pull, doubted = np.abs(off / error), (fits["doubt"] != "").to_numpy()
        row = {"distribution": name, "way": way, "fits": len(fits), "error": np.median(error)}
        row |= {"off": np.sqrt((off**2).mean()), "rms pull": np.sqrt((pull**2).mean())}
        rows.append(row | {"silent": int(((pull.max(axis=1) > 3) & ~doubted).sum()), "doubted": int(doubted.sum())})
    return pd.DataFrame(rows)
