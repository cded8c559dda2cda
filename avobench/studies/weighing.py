"""What each constant of the score does: `python -m avobench.studies.weighing FOLDER ...`, of solved challenges.

Every data set with one hidden effect is searched once, as a diagnosis does. Then what was fitted is weighed again, with
one thing switched off at a time: fits stay, so that nothing but the score differs. What moves is printed by `python -m
avobench.reports.weighing`, from the records in `results/weighing`.
"""

import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.atomic import write_atomically
from avobench.bench.events import check_events, read_events
from avobench.challenge.shapes import ONE_FAMILY, kind_of_events
from avobench.challenge.solve import read_json, read_manifest
from avobench.diagnosis.answer.quoted import models, probabilities
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.gates.held_out import SHARE
from avobench.diagnosis.loop import begun
from avobench.diagnosis.progress import Telling
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search import evidence, posterior
from avobench.diagnosis.search.candidates import Weighed
from avobench.diagnosis.search.evidence import Unknown
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.search.search import Search
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue, domain
from avobench.tasks import Task
from avobench.tasks.meter import Meter

RESULTS = Path("results/weighing")
ALPHA = 0.05
"""The level of a diagnosis unless another is asked for."""
AS_IT_IS = "as it is"


def by_fits_alone(opinions: dict[posterior.Names, tuple[float, float]]) -> dict[posterior.Names, float]:
    """Log weights of sets of effects without what the events look like."""
    return {names: fitted for names, (fitted, _) in opinions.items()}


OFF: dict[str, list[tuple[Any, str, Any]]] = {
    AS_IT_IS: [],
    "no experience": [(posterior, "pooled", by_fits_alone)],
    "experience and fits count as independent": [(posterior, "OPINION", 1.0)],
    "nothing is outside": [(posterior, "UNKNOWN", 1e-300), (posterior, "IMITATED", 0.0)],
    "nothing outside looks like the catalogue": [(posterior, "IMITATED", 0.0)],
    "strengths uniform from a tenth": [(evidence, "WEAKEST", 0.1)],
    "two effects as probable as one": [(posterior, "NUMBER", (0.1, 0.6, 0.6, 0.6))],
    "one temperature for all": [(posterior, "COARSE", 0.0)],
    "temperature 1 for all": [(posterior, "COARSE", 0.0), (posterior, "TEMPERATURE", 1.0)],
}
"""What is switched off, by what is then the case."""


def searched(task: Task, x: NDArray, effects: list[Effect], seed: int) -> tuple[Posterior, Target] | None:
    """All models that a diagnosis of events x (N, d) with this seed weighs; None where it sees no disagreement."""
    rng = np.random.default_rng(seed)
    seen = x[rng.permutation(len(x))[: len(x) - int(SHARE * len(x))]]
    effort, telling, meter = effort_for(task, domain(task), None, len(seen)), Telling(None, 0), Meter()
    before, target, _ = begun(task, seen, "surrogate", ALPHA, rng, effort, telling, meter)
    if before.p_value >= ALPHA:
        return None
    return Search(target, seen, effects, 3, rng, effort, jobs=1).posterior(before.fit), target


def weighed_again(found: Posterior, target: Target, effects: list[Effect]) -> Iterator[tuple[str, Posterior]]:
    """The probabilities of the same fits with each thing of OFF switched off."""
    fits = [one for fits in found.shapes.values() for one in fits]
    null = next(one.fit for one in fits if not one.fit.model.effects)
    for name, changes in OFF.items():
        with ExitStack() as stack:
            for owner, constant, value in changes:
                stack.enter_context(patch.object(owner, constant, value))
            again = [replace(Weighed.of(one.fit), resemblance=one.resemblance) for one in fits]
            yield name, Posterior.of(again, Unknown(target).evidence(null), effects)


def record(case: dict[str, Any], name: str, found: Posterior, task: Task) -> dict[str, Any]:
    """A line of the records: what was hidden, what was switched off, and what a diagnosis would then say."""
    diagnosis = {
        "verdict": Verdict.UNEXPLAINED if found.named is None else Verdict.NAMED,
        "probabilities": [each.model_dump() for each in probabilities(found, task.labels)],
        "outside": found.outside,
        "models": [each.model_dump() for each in models(found, task.labels)],
    }
    return {**case, "off": name, "diagnosis": diagnosis}


def study(folder: Path) -> Path:
    """Search and weigh the data sets of a challenge; the path of its records."""
    manifest = read_manifest(folder)
    spec = registry.named_in(folder / "manifest.json", "task", manifest["task"], trust=False)
    task = registry.build("task", spec, {})
    answers = {each["case"]: each for each in read_json(folder / "answers.json")["cases"]}
    lines = [{"task": manifest["task"]}]
    for number, case in enumerate(manifest["cases"]):
        answer = answers[case["case"]]
        if len(answer["effects"]) != 1:
            continue
        for effect in answer["effects"]:  # of a challenge that was made when families were more
            effect["name"] = ONE_FAMILY.get((kind_of_events(task), effect["name"]), effect["name"])
        x, _ = check_events(task, read_events(str(folder / "data" / f"{case['case']}.npz")))
        adapted = [e for e in catalogue(task) if case["effects"] is None or e.name in case["effects"]]
        if (found := searched(task, x, adapted, number)) is not None:
            effects = [effect.adapted(x) for effect in adapted]
            lines += [record(answer, name, again, task) for name, again in weighed_again(*found, effects)]
        print(f"[{number + 1}/{len(manifest['cases'])}] {case['case']}", file=sys.stderr, flush=True)
    path = RESULTS / f"{folder.name}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, "".join(json.dumps(line) + "\n" for line in lines).encode())
    return path


if __name__ == "__main__":
    for given in sys.argv[1:]:
        print(study(Path(given)))
