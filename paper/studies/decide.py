"""Does what a diagnosis says would decide, decide? `python -m paper.studies.decide`; `paper.tables.decide` says.

An effect is hidden in events of a task, in a shape of the catalogue (own) or another (foreign), and these are diagnosed
with one effect at most. Where the 95 % set has the hidden family beside another one, as many events as are said to tell
them apart are made anew and diagnosed with these two families alone. One JSON line per data set is added to the file;
those that it has are left alone.
"""

import time
from functools import partial
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from avobench.bench.plugins import registry
from avobench.challenge.hide import MOST_DISTANCE, OwnShape
from avobench.challenge.shape import Injection, Place
from avobench.challenge.visibility import visibility
from avobench.diagnosis import Diagnosis, diagnose
from avobench.diagnosis.schema import Decision, Named
from avobench.effects.catalogue import catalogue
from avobench.tasks import Task
from avobench.tasks.contract import stable_hash
from paper.studies.files import add_lines
from shapes import SEEN

FILE = Path("results/studies/decide.jsonl")
EVENTS = {"poisson": 2000, "weinberg": 2000, "carl": 1500}
"""Measured events of a data set, so few that sets often have several models."""
SETS = {"poisson": 12, "weinberg": 12, "carl": 3}
"""Data sets of each kind of shape."""
MOST = {"poisson": 150_000, "weinberg": 150_000, "carl": 20_000}
"""Events that are made anew at most: more take minutes."""
VISIBLE = 0.95
"""Power with which the best test sees a hidden effect, at least: what is not detected leaves nothing to decide."""


def hidden(task: Task, kind: str, num_events: int, rng: np.random.Generator) -> tuple[NDArray, Injection | OwnShape]:
    """A theta (p,) of the prior, and a random effect that is visible in so many events at it."""
    theta = task.prior.sample(1, rng)[0]
    at = np.tile(theta, (2 * num_events, 1))
    reference = task.simulate(at, rng)
    entries = catalogue(task, reference)
    foreign = [
        (shape, place)
        for feature in dict.fromkeys(effect.feature for effect in entries)
        for shape in SEEN
        if shape.suits(place := Place(task, feature, reference))
    ]
    while True:
        if kind == "own":
            injection: Injection | OwnShape = OwnShape.draw([entries[rng.integers(len(entries))]], rng)
        else:
            shape, place = foreign[rng.integers(len(foreign))]
            injection = shape.draw(place, rng)
        seen = visibility(task, injection.measure(task.simulate, at, rng), theta, num_events, rng)
        if seen.power >= VISIBLE and seen.distance <= MOST_DISTANCE:
            return theta, injection


def made(name: str, kind: str, number: int) -> dict[str, Any]:
    """What a diagnosis of one data set says would decide, and what came of it."""
    began, task = time.process_time(), registry.build("task", name, {})
    rng = np.random.default_rng([stable_hash("decide", name, kind), number])
    n = EVENTS[name]
    theta, injection = hidden(task, kind, n, rng)

    def measured(num_events: int) -> NDArray:
        return injection.measure(task.simulate, np.tile(theta, (num_events, 1)), rng)

    first = diagnose(task, measured(n), seed=number, max_effects=1).diagnosis
    row = {"task": name, "kind": kind, "number": number, "truth": injection.name, "num_events": n, "asked": []}
    row |= {"verdict": first.verdict.value, "models": [names(model.effects) for model in first.models]}
    for decision in askable(first, injection.name):
        asked = {"true": names(decision.true), "rival": names(decision.rival)}
        asked |= {
            "chi_squared": round(decision.chi_squared, 1),
            "events": decision.events,
            "low": decision.low,
            "high": decision.high,
        }
        if decision.events and n + decision.events <= MOST[name] and not any("named" in each for each in row["asked"]):
            tried = [each for each in catalogue(task) if each.name in asked["true"] + asked["rival"]]
            again = diagnose(task, measured(n + decision.events), seed=number, effects=tried, max_effects=1).diagnosis
            best = sorted(again.candidates, key=lambda each: each.score)
            asked |= {"named": names(again.effects), "best": names(best[:1])}
            asked["models"] = [names(model.effects) for model in again.models]
        row["asked"].append(asked)
    return row | {"seconds": round(time.process_time() - began, 1)}


def askable(diagnosis: Diagnosis, truth: str) -> list[Decision]:
    """What would decide between a model with the hidden family alone and one other effect."""
    pairs = [(each, names(each.true), names(each.rival)) for each in diagnosis.decisions]
    return [each for each, a, b in pairs if len(a) == len(b) == 1 and a != b and [truth] in (a, b)]


def names(effects: list[Named]) -> list[str]:
    """The families, on whatever feature."""
    return sorted(effect.name for effect in effects)


@click.command()
@click.option("--out", type=click.Path(path_type=Path), default=FILE, show_default=True, help="File of JSON lines.")
@click.option("--task", "tasks", multiple=True, default=tuple(EVENTS), help="Tasks. Repeatable.")
def study(out: Path, tasks: tuple[str, ...]) -> None:
    """Carry out what the file lacks."""
    of_task = [[(name, kind, number) for number in range(SETS[name]) for kind in ("own", "foreign")] for name in tasks]
    cases = filter(None, chain.from_iterable(zip_longest(*of_task)))
    key = ("task", "kind", "number")
    add_lines(out, ((dict(zip(key, case, strict=True)), partial(made, *case)) for case in cases))


if __name__ == "__main__":
    study()
