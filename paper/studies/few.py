"""How often the errors hold that fits quote from few observed events, 300 and 2 000: the benchmark has 100 000."""

from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.api.inference import infer
from avobench.bench.cells.streams import stream
from avobench.bench.plugins import registry
from avobench.methods import Method
from avobench.tasks import Task
from avobench.tasks.function import task
from paper.experiments import BUDGET
from paper.studies.contamination import gaussian_of_a_width
from paper.studies.files import StudyFile

FILE = StudyFile("few")
METHODS = ("avo", "rank-moments", "smm")
EVENTS = (300, 2000)
"""Observed events of a fit."""
NUM_FITS = 12
"""Fits of each case, each at other parameters of the prior."""


def tasks() -> list[Task]:
    """A Gaussian of a mean and a width, whose mean does not tell the width, and two tasks of the paper."""
    of_gaussian = {"prior": {"mean": (-2, 2), "log_width": (-1, 1)}, "features": ["x"], "name": "gaussian"}
    return [
        task(gaussian_of_a_width, **of_gaussian),
        *(registry.build("task", name, {}) for name in ("poisson", "carl")),
    ]


def made(path: Path, seed: int = 0, num_fits: int = NUM_FITS, budget: int = BUDGET) -> dict[str, Any]:
    """The record of the study at `path`, of which each fit that is lacking is made and written at once.

    `fits` holds for each the `task`, `events`, `fit`, `method` and its `version`, `off`: the difference of each
    parameter that the events determine from the truth, in quoted errors, and `doubt`. Raises StoreError for a damaged
    file.
    """
    methods = [registry.build("method", name, {}) for name in METHODS]
    wanted = [
        (
            {"task": of.name, "events": events, "fit": fit, "method": method.name, "version": method.version},
            partial(one, of, events, fit, method, seed, budget),
        )
        for fit, of, events, method in product(range(num_fits), tasks(), EVENTS, methods)
    ]
    return FILE.completed(path, "fits", wanted, seed=seed, budget=budget)


def one(of: Task, num_events: int, fit: int, method: Method, seed: int, budget: int) -> dict[str, Any]:
    """A fit of events that are the same for each method."""
    rng = stream(seed, "few", of.name, str(num_events), str(fit))
    theta = of.prior.sample(1, rng)
    x = of.simulate(np.tile(theta, (num_events, 1)), rng)
    found = infer(of, x, method, budget=budget, seed=fit, progress=False)
    off = (list(found.theta.values()) - theta[0]) / list(found.std.values())
    return {"off": off.tolist(), "doubt": found.estimate.doubt}


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task, number of events and method: differences in quoted errors, of all fits and parameters.

    `rms` is 1, and the shares are 68 and 95 %, where errors hold; `bias` is the mean difference. `silent` counts the
    fits with a parameter that is more than three errors off, and no doubt.
    """
    rows = []
    for key, fits in pd.DataFrame(records[0]["fits"]).groupby(["task", "events", "method"]):
        off = np.stack(fits["off"])
        row = dict(zip(("task", "events", "method"), key, strict=True)) | {"fits": len(fits)}
        row |= {"rms": np.sqrt((off**2).mean()), "bias": off.mean()}
        row |= {f"within {share} %": f"{(np.abs(off) < z).mean():.0%}" for share, z in ((68, 1), (95, 1.96))}
        row |= {"silent": int(((np.abs(off).max(axis=1) > 3) & (fits["doubt"] == "")).sum())}
        rows.append(row | {"doubted": int((fits["doubt"] != "").sum())})
    return pd.DataFrame(rows)
