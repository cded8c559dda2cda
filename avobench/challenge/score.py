"""How good the diagnoses of a challenge are."""

import json
from collections.abc import Callable, Iterable
from itertools import pairwise
from statistics import median
from typing import Any

import numpy as np
from scipy.stats import binomtest

from avobench.bench.plugins import registry
from avobench.challenge.case import VISIBLE, Case
from avobench.challenge.hide import SETS
from avobench.tasks.errors import UsageError, raised

POWERS = (0.2, 0.5, 0.9, 0.99)
"""Borders of classes of visibility: the power of the best test of binned events, see `visibility`."""
GAPS = (1.5, 3.0, 10.0)
"""Borders of classes of what a user sees: chi2/ndf of held-out events before an effect is added."""
ALL = "all"
"""Both sets of shapes together."""
NEAR = 2.0
"""Theta is right within so many of its quoted errors."""


def score(*challenges: list[dict[str, Any]], trust: bool = False) -> dict[str, Any]:
    """How often the diagnoses were right, from the `records` of challenges, pooled.

    Raises UsageError where the records are not sound, or name code and the user does not `trust` them.
    """
    try:
        result = _score(challenges, trust)
        json.dumps(result, allow_nan=False)  # a number in the records that is none goes on into the result
        return result
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        what = raised(error)
        raise UsageError(f"the records of the challenge do not hold what is to be scored ({what})") from error


def _score(challenges: tuple[list[dict[str, Any]], ...], trust: bool) -> dict[str, Any]:
    heads = [lines[0] for lines in challenges]
    rows = [(head, row) for head, *rest in challenges for row in rest]
    specs = {head["task"]: registry.named_in("the challenge", "task", head["task"], trust) for head in heads}
    tasks = {name: registry.build("task", spec, {}) for name, spec in specs.items()}
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


def rate(hits: Iterable[bool]) -> dict[str, Any]:
    """How many of how many, and the exact (Clopper-Pearson) 95 % interval of the share."""
    hits = list(hits)
    if not hits:
        return {"count": 0, "of": 0, "share": None, "low": None, "high": None}
    count, n = sum(hits), len(hits)
    interval = binomtest(count, n).proportion_ci()
    return {"count": count, "of": n, "share": count / n, "low": float(interval.low), "high": float(interval.high)}


def _of_set(cases: list[Case], each: str) -> list[Case]:
    return [case for case in cases if each in (ALL, case.answer["set"])]


def _one(cases: list[Case]) -> dict[str, Any]:
    """One hidden effect, which the catalogue has. Names are judged where something was detected."""
    detected = [case for case in cases if case.detected]
    visible = [case for case in cases if case.power >= VISIBLE]
    explained = [case for case in detected if case.explained]
    sizes = [len(case.ties[0]) for case in detected if case.ties]
    borders = (0, *POWERS, np.inf)
    return {
        "cases": len(cases),
        "undetectable": sum(case.undetectable for case in cases),
        "power": [
            {"from": low, "to": min(high, 1), **rate(c.detected for c in cases if low <= c.power < high)}
            for low, high in pairwise(borders)
        ],
        "right_first": rate(case.first() for case in detected),
        "right_first_by_gap": _by_gap(detected, Case.first),
        "right_first_whatever_feature": rate(case.first(feature=False) for case in detected),
        "in_tie_set": rate(case.in_first_tie for case in detected),
        "tie_size": float(np.mean(sizes)) if sizes else None,
        "another_would_do": rate(bool(case.ties and case.ties[0] - {case.hidden[0]}) for case in detected),
        "more_named": rate(len(case.named) > 1 for case in detected),
        "visible_right_first": rate(case.first() for case in visible),
        "visible_in_tie_set": rate(case.in_first_tie for case in visible),
        "explained": rate(case.explained for case in detected),
        **_before_and_after(detected),
        "theta_within_2": rate(_near(explained, "after")),
        "mistaken": _mistaken(detected),
    }


def _withheld(cases: list[Case]) -> dict[str, Any]:
    detected = [case for case in cases if case.detected]
    return {
        "cases": len(cases),
        "undetectable": sum(case.undetectable for case in cases),
        "detected": rate(case.detected for case in cases),
        "falsely_explained": rate(case.explained for case in detected),
        "falsely_explained_by_gap": _by_gap(detected, lambda case: case.explained),
        "mistaken": _mistaken([case for case in detected if case.explained]),
    }


def _two(cases: list[Case]) -> dict[str, Any]:
    detected = [case for case in cases if case.detected]
    visible = [case for case in cases if case.both_visible]
    missed = [case for case in visible if not case.both]
    return {
        "cases": len(cases),
        "detected": rate(case.detected for case in cases),
        "visible_both": rate(case.both for case in visible),
        "visible_missed_explained": rate(case.explained for case in missed),
        "visible_at_least_one": rate(bool(set(case.hidden) & set(case.named)) for case in visible),
        "both": rate(case.both for case in detected),
        "at_least_one": rate(bool(set(case.hidden) & set(case.named)) for case in detected),
        "both_with_ties": rate(set(case.hidden) <= set().union(*case.ties) for case in detected),
        **_before_and_after(detected),
        "mistaken": _mistaken(detected),
    }


def _spread(values: list[float]) -> dict[str, float] | None:
    return {"median": median(values), "max": max(values)} if values else None


def _by_gap(cases: list[Case], hit: Callable[[Case], bool]) -> list[dict[str, Any]]:
    return [
        {
            "from": low,
            "to": high if high < np.inf else None,
            **rate(hit(case) for case in cases if low <= case.diagnosis["gap_before"]["value"] < high),
        }
        for low, high in pairwise((0, *GAPS, np.inf))
    ]


def _near(cases: list[Case], when: str) -> list[bool]:
    return [pull <= NEAR for case in cases if (pull := case.pull(when)) is not None]


def _before_and_after(cases: list[Case]) -> dict[str, Any]:
    medians: dict[str, Any] = {}
    for when in ("before", "after"):
        gaps = [gap["value"] for case in cases if (gap := case.diagnosis[f"gap_{when}"])]
        biases = [bias for case in cases if (bias := case.bias(f"theta_{when}")) is not None]
        medians |= {f"gap_{when}": median(gaps) if gaps else None, f"bias_{when}": median(biases) if biases else None}
    return medians


def _mistaken(cases: list[Case]) -> list[str]:
    return [case.mistaken for case in cases if case.mistaken]
