"""How good the diagnoses of a challenge are: the answers are opened here, and only here."""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.stats import binomtest

from avobench.bench import registry
from avobench.challenge.make import SETS
from avobench.challenge.solve import RESULTS, read_json, read_manifest
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

RECORDS = {"schema": "avobench-challenge-records", "version": 1}
KEPT = ("verdict", "alpha", "p_value_before", "p_value_after", "gates", "gap_before", "gap_after", "theta_before")
KEPT += ("theta_after", "identified_before", "identified_after", "effects", "num_simulations", "seed", "versions")
"""Of a diagnosis, in records: without what is long and not scored, as the candidates are."""
NOTHING, NAMED = "no significant disagreement", "missing effect named"
POWERS = (0.2, 0.5, 0.9, 0.99)
"""Borders of classes of visibility: the power of the best test of binned events, see `visibility`."""
GAPS = (1.5, 3.0, 10.0)
"""Borders of classes of what a user sees: chi2/ndf of held-out events before an effect is added."""
INVISIBLE = 0.2
"""A hidden effect of lower power that is not detected counts as undetectable: theta absorbs it, or it is too weak."""
VISIBLE = 0.9
ALL = "all"
NEAR = 2.0
"""Theta is right within so many of its quoted errors."""

DERIVATIVE_STEP = 1e-4
"""Of the prior's width: small against what bends, large against rounding."""


@dataclass(frozen=True)
class Case:
    """A case with its answer and its diagnosis, as they stand in their files."""

    task: Task
    answer: dict[str, Any]
    diagnosis: dict[str, Any]

    @property
    def detected(self) -> bool:
        return self.diagnosis["verdict"] != NOTHING

    @property
    def undetectable(self) -> bool:
        return not self.detected and self.power < INVISIBLE

    @property
    def power(self) -> float:
        """Of the best test, for the least visible of the hidden effects."""
        return min(effect["power"] for effect in self.answer["effects"])

    @property
    def both_visible(self) -> bool:
        """Whether the best test sees each of two hidden effects beside the other; no where older records do not say."""
        beside = [effect.get("beside") for effect in self.answer["effects"]]
        return None not in beside and min(beside) >= VISIBLE

    @property
    def hidden(self) -> list[tuple[str, str | None]]:
        return [self._key(effect) for effect in self.answer["effects"]]

    @property
    def named(self) -> list[tuple[str, str | None]]:
        """In the order in which they were added."""
        return [self._key(effect) for effect in self.diagnosis["effects"]]

    @property
    def ties(self) -> list[set[tuple[str, str | None]]]:
        """For each named effect, itself and its rivals."""
        effects = self.diagnosis["effects"]
        return [{self._key(effect), *map(self._key, effect["tied_with"])} for effect in effects]

    def _key(self, effect: dict[str, Any]) -> tuple[str, str | None]:
        """What names an effect; the feature counts where there is one to choose."""
        choose = self.task.num_features > 1 and not self.task.event_shape
        return effect["name"], effect["feature"] if choose else None

    def bias(self, when: str) -> float | None:
        """How far what the events determine of theta is from the truth, mean over its parts. `when`: theta_...

        In widths of the prior, or in what else a task tells it in.
        """
        estimate = self._theta(when)
        if estimate is None:
            return None
        known, true = self.task.identifiable(np.stack([estimate, self.answer["theta"]]))
        return float((np.abs(known - true) / self.task.identifiable_scale).mean())

    def pull(self, when: str) -> float | None:
        """How far theta is from the truth, in quoted errors, at most; None where the data determine nothing of it.

        `when`: before or after. Of the combinations of theta that the diagnosis says are determined; where the events
        determine fewer quantities than theta has, of those, which need be no straight lines, with the errors that the
        combinations give them.
        """
        known, estimate, truth = (
            self.diagnosis[f"identified_{when}"],
            self._theta(f"theta_{when}"),
            self.answer["theta"],
        )
        if not known:
            return None
        names = self.task.parameter_names
        rows = np.array([[each["coefficients"][name] for name in names] for each in known])
        std = np.array([each["std"] for each in known])
        step = DERIVATIVE_STEP * self.task.prior.width
        at = np.stack([estimate, truth, *(estimate + change for change in np.diag(step))])
        quantities = self.task.identifiable(at)
        if quantities.shape[1] == len(names):
            return float(np.abs(rows @ (estimate - truth) / std).max())
        found, true, *moved = quantities
        # A combination moves theta along its own coefficients, in units of the range, by its error.
        width = np.subtract(self.task.support.high, self.task.support.low)
        slopes = [(rows * width) @ (change / step * width) for change in (np.array(moved) - found).T]
        errors = [np.sqrt((slope**2) @ std**2) for slope in slopes]
        return float(np.max(np.abs(found - true) / errors))

    def _theta(self, when: str) -> np.ndarray | None:
        theta = self.diagnosis[when]
        return np.array([theta[name]["value"] for name in self.task.parameter_names]) if theta else None


def rate(hits: Iterable[bool]) -> dict[str, Any]:
    """How many of how many, and the exact (Clopper-Pearson) 95 % interval of the share."""
    hits = list(hits)
    if not hits:
        return {"count": 0, "of": 0, "share": None, "low": None, "high": None}
    interval = binomtest(sum(hits), len(hits)).proportion_ci()
    return {
        "count": sum(hits),
        "of": len(hits),
        "share": sum(hits) / len(hits),
        "low": float(interval.low),
        "high": float(interval.high),
    }


def records(folder: Path) -> list[dict[str, Any]]:
    """All that scoring needs, a dictionary a line: the challenge as a whole, then its solved cases with their answers.

    Raises UsageError while there is nothing to compare.
    """
    manifest, path = read_manifest(folder), folder / "answers.json"
    if not path.is_file():
        raise UsageError(f"there are no answers in {folder}: {path} is missing")
    results = [read_json(file) for file in sorted((folder / RESULTS).glob("*.json"))]
    if not results:
        raise UsageError(f"nothing is solved in {folder}; `avobench challenge solve {folder}` does it")
    answers = read_json(path)
    of_case = {answer["case"]: answer for answer in answers["cases"]}
    head = {**RECORDS, **{name: answers[name] for name in ("task", "num_events", "seed", "kinds")}}
    head |= {"cases": len(manifest["cases"]), "options": results[0]["options"]}
    rows = []
    for result in results:
        row = {**of_case[result["case"]], "error": result.get("error")}
        row |= {name: result[name] for name in ("seconds", "cpu_seconds")}
        if row["error"] is None:
            row["diagnosis"] = {name: result["diagnosis"][name] for name in KEPT}
        rows.append(row)
    return [head, *rows]


def read_records(path: Path) -> list[dict[str, Any]]:
    """What `records` gave, from a file of it. Raises UsageError for another file."""
    try:
        lines = [json.loads(line) for line in path.read_text().splitlines()]
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read as records of a challenge: {error}") from error
    if not lines or {name: lines[0].get(name) for name in RECORDS} != RECORDS:
        raise UsageError(f"{path} does not hold records of a challenge")
    return lines


def score(*challenges: list[dict[str, Any]]) -> dict[str, Any]:
    """How often the diagnoses were right, from the `records` of one challenge, or of several pooled."""
    heads = [lines[0] for lines in challenges]
    rows = [(head, row) for head, *rest in challenges for row in rest]
    tasks = {head["task"]: registry.build("task", head["task"], {}) for head in heads}
    solved = [(head, row) for head, row in rows if row["error"] is None]
    cases = [Case(tasks[head["task"]], row, row["diagnosis"]) for head, row in solved]
    of = {kind: [case for case in cases if case.answer["kind"] == kind] for kind in ("none", "two", "withheld")}
    return {
        "task": " + ".join(tasks),
        "num_events": sorted({head["num_events"] for head in heads}),
        "seeds": [head["seed"] for head in heads],
        "options": [head["options"] for head in heads],
        "cases": sum(head["cases"] for head in heads),
        "solved": len(cases),
        "failed": {f"{head['task']} {row['case']}": row["error"] for head, row in rows if row["error"] is not None},
        "none": {
            "false_alarms": rate(case.detected for case in of["none"]),
            "theta_within_2": rate(_near(of["none"], "before")),
        },
        "one": {each: _one([case for case in cases if case.answer["kind"] == each]) for each in SETS},
        "withheld": {each: _withheld(_of_set(of["withheld"], each)) for each in (*SETS, ALL)},
        "two": {each: _two(_of_set(of["two"], each)) for each in (*SETS, ALL)},
        **{name: _spread([row[name] for _, row in solved]) for name in ("seconds", "cpu_seconds")},
    }


def _of_set(cases: list[Case], each: str) -> list[Case]:
    return [case for case in cases if each in (ALL, case.answer["set"])]


def _one(cases: list[Case]) -> dict[str, Any]:
    """One hidden effect, which the catalogue has. Names are judged where something was detected."""
    found = [case for case in cases if case.detected]
    visible = [case for case in cases if case.power >= VISIBLE]
    second = [case for case in found if case.answer["effects"][0].get("series") == 2]
    explained = [case for case in found if _explained(case)]
    sizes = [len(case.ties[0]) for case in found if case.ties]
    borders = (0, *POWERS, np.inf)
    return {
        "cases": len(cases),
        "undetectable": sum(case.undetectable for case in cases),
        "power": [
            {"from": low, "to": min(high, 1), **rate(c.detected for c in cases if low <= c.power < high)}
            for low, high in pairwise(borders)
        ],
        "right_first": rate(_first(case) for case in found),
        "right_first_by_gap": _by_gap(found, _first),
        "right_first_whatever_feature": rate(_first(case, feature=False) for case in found),
        "in_tie_set": rate(_in_first_tie(case) for case in found),
        "tie_size": float(np.mean(sizes)) if sizes else None,
        "another_would_do": rate(bool(case.ties and case.ties[0] - {case.hidden[0]}) for case in found),
        "more_named": rate(len(case.named) > 1 for case in found),
        "visible_right_first": rate(_first(case) for case in visible),
        "second_series": {
            "right_first": rate(_first(case) for case in second),
            "in_tie_set": rate(_in_first_tie(case) for case in second),
        },
        "explained": rate(map(_explained, found)),
        **_before_and_after(found),
        "theta_within_2": rate(_near(explained, "after")),
        "mistaken": _mistaken(found),
    }


def _withheld(cases: list[Case]) -> dict[str, Any]:
    found = [case for case in cases if case.detected]
    return {
        "cases": len(cases),
        "undetectable": sum(case.undetectable for case in cases),
        "detected": rate(case.detected for case in cases),
        "falsely_explained": rate(map(_explained, found)),
        "falsely_explained_by_gap": _by_gap(found, _explained),
        "mistaken": _mistaken([case for case in found if _explained(case)]),
    }


def _two(cases: list[Case]) -> dict[str, Any]:
    found = [case for case in cases if case.detected]
    visible = [case for case in found if case.both_visible]
    missed = [case for case in visible if not _both(case)]
    return {
        "cases": len(cases),
        "detected": rate(case.detected for case in cases),
        "visible_both": rate(map(_both, visible)),
        "visible_missed_explained": rate(map(_explained, missed)),
        "visible_at_least_one": rate(bool(set(case.hidden) & set(case.named)) for case in visible),
        "both": rate(map(_both, found)),
        "at_least_one": rate(bool(set(case.hidden) & set(case.named)) for case in found),
        "both_with_ties": rate(set(case.hidden) <= set().union(*case.ties) for case in found),
        **_before_and_after(found),
        "mistaken": _mistaken(found),
    }


def _spread(values: list[float]) -> dict[str, float] | None:
    return {"median": median(values), "max": max(values)} if values else None


def _by_gap(cases: list[Case], hit: Callable[[Case], bool]) -> list[dict[str, Any]]:
    """How often, by classes of chi2/ndf before; the last has no upper border."""
    return [
        {
            "from": low,
            "to": high if high < np.inf else None,
            **rate(hit(case) for case in cases if low <= case.diagnosis["gap_before"]["value"] < high),
        }
        for low, high in pairwise((0, *GAPS, np.inf))
    ]


def _explained(case: Case) -> bool:
    return case.diagnosis["verdict"] == NAMED


def _first(case: Case, *, feature: bool = True) -> bool:
    if not case.named:
        return False
    return case.named[0] == case.hidden[0] if feature else case.named[0][0] == case.hidden[0][0]


def _in_first_tie(case: Case) -> bool:
    return bool(case.ties) and case.hidden[0] in case.ties[0]


def _both(case: Case) -> bool:
    return set(case.hidden) <= set(case.named)


def _near(cases: list[Case], when: str) -> list[bool]:
    return [pull <= NEAR for case in cases if (pull := case.pull(when)) is not None]


def _before_and_after(cases: list[Case]) -> dict[str, Any]:
    """Medians over the cases: chi2/ndf of held-out events, and the bias of theta."""
    medians: dict[str, Any] = {}
    for when in ("before", "after"):
        gaps = [gap["value"] for case in cases if (gap := case.diagnosis[f"gap_{when}"])]
        biases = [bias for case in cases if (bias := case.bias(f"theta_{when}")) is not None]
        medians |= {f"gap_{when}": median(gaps) if gaps else None, f"bias_{when}": median(biases) if biases else None}
    return medians


def _mistaken(cases: list[Case]) -> list[str]:
    """A line for each case that does not name all that was hidden, in any order, and only that, first."""
    return [
        f"{case.task.name} {case.answer['case']}: "
        f"{' + '.join(_words(each) for each in case.answer['effects'])} taken for "
        f"{' + '.join(_words(each) for each in case.diagnosis['effects']) or 'nothing'} ({case.diagnosis['verdict']})"
        for case in cases
        if set(case.named[: len(case.hidden)]) != set(case.hidden)
    ]


def _words(effect: dict[str, Any]) -> str:
    shape = f" ({effect['shape']})" if effect.get("shape") else ""
    return effect["name"] + (f" of {effect['feature']}" if effect["feature"] else "") + shape
