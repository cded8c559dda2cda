"""Fits by `avobench.infer` where the mean of an event hardly tells the parameters, and of simulators of others.

The records tell which of the fits were doubted.
"""

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
from paper.experiments import BUDGET
from paper.hard_tasks import HARD, Informed
from paper.sbibm_tasks import SBIBM
from paper.studies.files import StudyFile

FILE = StudyFile("hard")
NUM_EVENTS = 10_000
"""Observed events of a fit."""
NUM_TARGETS = 15
"""The first targets of each task. All fits of one take two minutes of a processor."""
DEVELOPMENT_TARGETS = 10
"""The first of these, which were seen before `avo` became what it is; five of them are those of `rank-moments` too."""
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "avo": ("avo", {}),
    "smm": ("smm", {}),
    "rank-moments": ("rank-moments", {}),
    "avo, values": ("avo", {"inputs": "values"}),
    "avo, three rounds": ("avo", {"refine": False}),
    "npe": ("npe", {}),
    "nre": ("nre", {}),
    "nle": ("nle", {}),
}
"""The method and its settings behind each row; `smm` is the simplest that could do the job."""
SLOW, OF_SLOW = ("npe", "nre", "nle"), 2
"""Rows of which a fit takes up to minutes, and of how many unseen targets they are made alone."""
OF_OTHERS = 4
"""The first targets of each task of others. No method was developed on these tasks."""
FAR = 5.0
"""Squared error over the floor from which a fit should be doubted. Chance alone takes one parameter in 40 beyond it."""
WRONG = 3.0
"""Quoted errors from which an error that is quoted is wrong."""


def made(
    path: Path,
    seed: int = 0,
    tasks: tuple[type[Informed], ...] = (*HARD, *SBIBM),
    num_targets: int = NUM_TARGETS,
    num_events: int = NUM_EVENTS,
    budget: int = BUDGET,
) -> dict[str, Any]:
    """The record of the study at `path`, of which each fit that is lacking is made and written at once.

    `fits` holds for each the `task`, `target`, `method` (a row of METHODS) and its `version`; its `theta`, the `floors`
    of its parameters, `estimate`, `error`, `doubt` and `seconds`. Raises StoreError for a damaged file.
    """
    methods = {label: registry.build("method", *how) for label, how in METHODS.items()}
    wanted = []
    for target, task, (label, method) in product(range(num_targets), tasks, methods.items()):
        key = {"task": task.name, "target": target, "method": label, "version": method.version}
        unseen = range(DEVELOPMENT_TARGETS, DEVELOPMENT_TARGETS + OF_SLOW)
        due = target < OF_OTHERS if task in SBIBM else label not in SLOW or target in unseen
        if due:
            wanted.append((key, partial(one, task(), target, method, seed, num_events, budget)))
    return FILE.completed(path, "fits", wanted, seed=seed, num_observations=num_events, budget=budget)


def one(task: Informed, target: int, method: Method, seed: int, num_events: int, budget: int) -> dict[str, Any]:
    """A fit of the events of a target, which are the same for each method.

    What is told of parameters is of what the events determine: where signs are open, of absolute values.
    """
    theta = task.targets()[target]
    x = task.simulate(np.tile(theta, (num_events, 1)), stream(seed, "observed", task.name, str(target)))
    found = infer(task, x, method, budget=budget, seed=seed, progress=False)
    known, error = task.identifiable, np.array(list(found.std.values()))
    if type(task).identifiable is not Task.identifiable:
        error = known(found.samples().to_numpy()).std(axis=0)
    return {
        "theta": known(theta[None])[0].tolist(),
        "floors": task.floors(theta, num_events, budget).tolist(),
        "estimate": known(found.estimate.theta[None])[0].tolist(),
        "error": error.tolist(),
        "doubt": found.estimate.doubt,
        "seconds": found.seconds,
    }


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task and method, of the one record of the study: of the targets first that were used in development.

    `error / floor` is of each target the largest squared error of a parameter over its floor, with a D where the fit
    was doubted; `median` is theirs. `rms pull` is the root mean square of the errors in quoted ones, of all parameters
    and targets. `far` counts the fits above FAR, and `undoubted` those of them without a doubt. `silent` counts the
    fits, far or not, that are more than WRONG quoted errors off without a doubt.
    """
    rows, frame = [], _fits(records)
    for (targets, task, method), fits in frame.groupby(["targets", "task", "method"], observed=True):
        pull, ratio = np.stack(fits["pull"]), fits["ratio"].to_numpy()
        doubted = (fits["doubt"] != "").to_numpy()
        each = [f"{value:.2g}{' D' if told else ''}" for value, told in zip(ratio, doubted, strict=True)]
        row = {"targets": targets, "task": task, "method": method}
        row |= {"error / floor": ", ".join(each), "median": np.median(ratio)}
        row |= {"rms pull": np.sqrt((pull**2).mean()), "far": int((ratio > FAR).sum())}
        row |= {"undoubted": int(((ratio > FAR) & ~doubted).sum())}
        row |= {"silent": int(((pull.max(axis=1) > WRONG) & ~doubted).sum())}
        rows.append({**row, "seconds": fits["seconds"].mean()})
    return pd.DataFrame(rows)


def _fits(records: list[dict[str, Any]]) -> pd.DataFrame:
    """The fits with their `ratio` and `pull`, and the kind of their targets; tasks and methods as in the record."""
    frame = pd.DataFrame(records[0]["fits"])
    frame["targets"] = np.where(frame["target"] < DEVELOPMENT_TARGETS, "seen", "unseen")
    frame.loc[frame["task"].isin([task.name for task in SBIBM]), "targets"] = "of others"
    off = [np.subtract(*pair) for pair in zip(frame["estimate"], frame["theta"], strict=True)]
    frame["ratio"] = [np.max(each**2 / floors) for each, floors in zip(off, frame["floors"], strict=True)]
    frame["pull"] = [np.abs(each / error) for each, error in zip(off, frame["error"], strict=True)]
    for name, order in {"task": [task.name for task in (*HARD, *SBIBM)], "method": list(METHODS)}.items():
        frame[name] = pd.Categorical(frame[name], order)
    return frame
