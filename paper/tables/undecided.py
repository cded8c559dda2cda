"""Could the data have told? `python -m paper.tables.undecided RECORDS ...`, of challenges with one feature.

Of each effect that was hidden in a foreign shape and taken for another: by how much the expected log likelihood of as
many events is less under the model that was named, at the parameters that were quoted, than under the truth. Below
about 3 nobody could tell the two apart, whatever he knew of both; a model that was fitted to the events is wrong by
half its number of parameters anyway. "-" is where nothing was named, or a shape that
is read off the data. Both are simulated with NUM_SIMULATED events.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.bench.plugins import registry
from avobench.challenge.case import Case
from avobench.challenge.hide import NUM_REFERENCE
from avobench.challenge.records import read_records
from avobench.challenge.shapes import SERIES, Injection, Place, kind_of_events
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks import Task
from avobench.tasks.contract import stable_hash

NUM_SIMULATED = 2_000_000
"""Of each of the two; the noise that they add to the difference is taken out on average."""
BINS = 100
"""Of a cosine."""
NOBODY = 3.0
"""Difference of log likelihood below which nobody can tell: odds of twenty."""


def misses(case: Case, head: dict[str, Any], number: int) -> float:
    """By how much the model that was named misses the truth, in expected log likelihood; at most by chance below 0."""
    rng = np.random.default_rng(number)
    task, n = case.task, NUM_SIMULATED
    theta = np.array(case.answer["theta"])
    true = injection(case, head, number).measure(task.simulate, np.tile(theta, (n, 1)), rng)
    if (found := named(case)) is None:
        return np.nan
    model, params = found
    other = model.simulate(np.tile(params, (n, 1)), rng)
    cosine = np.linspace(-1, 1, BINS + 1)
    edges = np.arange(-0.5, max(true.max(), other.max()) + 1) if kind_of_events(task) == "counts" else cosine
    p, q = (np.histogram(x, edges)[0] for x in (true, other))
    some = p > 0
    missed = p[some] @ (np.log(p[some]) - np.log(np.maximum(q[some], 0.5))) / n
    return head["num_events"] * (missed - (some.sum() - 1) / n)  # of two samples of one distribution: K - 1 over n


def injection(case: Case, head: dict[str, Any], number: int) -> Injection:
    """What was hidden, with its scales from the same reference events as when the challenge was made."""
    root = np.random.SeedSequence([stable_hash("challenge", case.task.name), head["seed"]])
    root.spawn(1)
    rng = np.random.default_rng(root.spawn(head["cases"])[number])
    theta = case.task.prior.sample(1, rng)
    reference = case.task.simulate(np.tile(theta, (NUM_REFERENCE, 1)), rng)
    (answer,) = case.answer["effects"]
    shapes = SERIES[answer["series"]][kind_of_events(case.task)]
    shape = next(each for each in shapes if each.__name__ == answer["shape"])
    feature = None if answer["feature"] is None else 0
    return shape(Place(case.task, feature, reference), **answer["settings"])


def named(case: Case) -> tuple[Model, NDArray[np.float64]] | None:
    """The model that was named, and its parameters as they were quoted (P,); None of a shape read off the data."""
    theta, effects = case.diagnosis["theta_after"], case.diagnosis["effects"]
    entries = catalogue(case.task)
    params = [theta[name]["value"] for name in case.task.parameter_names]
    found = []
    for told in effects:
        shapes = (shape for entry in entries if entry.name == told["name"] for shape in entry.shapes())
        if (shape := next((shape for shape in shapes if shape.shape == told["shape"]), None)) is None:
            return None
        found.append(shape)
        params += [told["parameters"][parameter.name]["value"] for parameter in found[-1].parameters]
    return Model(case.task, tuple(found)), np.array(params)


def rows(path: Path) -> Iterator[dict[str, Any]]:
    """A row a case that was seen, and taken for something else."""
    head, *records = read_records(path)
    task: Task = registry.build("task", registry.named_in(str(path), "task", head["task"], trust=False), {})
    for row in records:
        if row["error"] is not None or row["kind"] != "foreign":
            continue
        case = Case(task, row, row["diagnosis"])
        if not case.detected or case.first():
            continue
        (answer,) = row["effects"]
        yield {
            "task": task.name,
            "case": row["case"],
            "hidden": f"{answer['name']} ({answer['shape']})",
            "taken for": " + ".join(f"{each['name']} ({each['shape']})" for each in row["diagnosis"]["effects"]) or "-",
            "missed": misses(case, head, int(row["case"])) if case.named else np.nan,
        }


def main(paths: list[Path]) -> None:
    """Print the tables."""
    found = pd.DataFrame([row for path in paths for row in rows(path)])
    print(found.to_string(index=False, na_rep="-", float_format="{:.1f}".format))
    for task, own in found.groupby("task", sort=False):
        nobody = (own["missed"] < NOBODY).sum()
        print(f"{task}: of {len(own)} that were seen and taken for something else, {nobody} nobody could tell")


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
