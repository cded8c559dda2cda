"""Do the probabilities of a diagnosis hold? `python -m paper.tables.reliability RECORDS ...`.

Of effects to which a diagnosis gives 70 %, seven in ten should be those that were hidden. Each row is one kind of
hidden effect, and the last row is all of them together. Two effects count where each is visible beside the other.
"""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.plugins import registry
from avobench.challenge.case import Case
from avobench.challenge.records import read_records

OUTSIDE = ("outside the catalogue", None)
LEAST = 0.01
"""Probability from which a name is one that was told: of most names it is all but certain that they are not it."""
ALPHA = 0.05
"""p-value above which the events agree with what was named."""
BINS = 10
"""Bins of the probability, with equal numbers of names."""
DRAWS = 300
"""Random draws for the range that chance allows."""


def names(case: Case) -> dict[tuple[str, str | None], float]:
    """The probability of each name to be in the model, and of what is missing to be outside the catalogue."""
    probabilities = {case.key(each): each["probability"] for each in case.diagnosis["probabilities"]}
    return {**probabilities, OUTSIDE: case.diagnosis["outside"]}


def truth(case: Case) -> set[tuple[str, str | None]]:
    """What should have the probability 1: what was hidden, or, if that was withheld, that it is outside."""
    return {OUTSIDE} if case.answer["kind"] == "withheld" else set(case.hidden)


def of_truth(case: Case) -> float:
    """The probability of what was hidden; of two effects, of the less probable."""
    return min(names(case).get(key, 0.0) for key in truth(case))


def table(cases: Iterable[tuple[str, Case]]) -> pd.DataFrame:
    """The table of the cases with a detected disagreement, by what was hidden."""
    rows = []
    groups: dict[str, list[Case]] = {}
    for name, case in cases:
        if case.detected and case.diagnosis.get("probabilities"):
            for each in (name, "all"):
                groups.setdefault(each, []).append(case)
    groups["all"] = groups.pop("all", [])
    for name, group in groups.items():
        told = [(share, key in truth(case)) for case in group for key, share in names(case).items() if share >= LEAST]
        stated, hit = np.array(told).T
        row = {"hidden": name, "cases": len(group), **pd.DataFrame(map(scores, group)).mean()}
        row |= {"calibration error": calibration_error(stated, hit), "if they held": by_chance(stated)}
        rows.append(row)
    return pd.DataFrame(rows)


def scores(case: Case) -> dict[str, float]:
    """How good the probabilities of a case are, by columns of the table, which has the means."""
    shares, true, diagnosis = names(case), truth(case), case.diagnosis
    right = set(sorted(shares, key=shares.get)[-len(true) :]) == true
    models = [{case.key(each) for each in model["effects"]} for model in diagnosis["models"]]
    enough = sum(model["probability"] for model in diagnosis["models"]) + shares[OUTSIDE]
    if shares[OUTSIDE] > 0.05 or enough < 0.95:
        models.append({OUTSIDE})
    return {
        "most probable right": right,
        "wrong, yet agrees": not right and (diagnosis.get("p_value_after") or 0) >= ALPHA,
        "in the 95 % set": true in models,
        "size": len(models),
        "P(truth)": of_truth(case),
        "P(outside)": shares[OUTSIDE],
        "P(first name)": max((share for key, share in shares.items() if key != OUTSIDE), default=0),
        "Brier": sum((share - (key in true)) ** 2 for key, share in shares.items()),
        "log score": np.log(max(of_truth(case), 1e-6)),
    }


def calibration_error(stated: np.ndarray, hit: np.ndarray) -> float:
    """Expected calibration error of probabilities (n,) and what came true (n,): their mean distance, in equal bins."""
    parts = np.array_split(np.argsort(stated, kind="stable"), min(BINS, len(stated)))
    return float(sum(len(part) * abs(stated[part].mean() - hit[part].mean()) for part in parts) / len(stated))


def by_chance(stated: np.ndarray) -> float:
    """The calibration error to be expected where each of the probabilities (n,) holds: of few cases none has 0."""
    rng = np.random.default_rng(0)
    return float(np.mean([calibration_error(stated, rng.random(len(stated)) < stated) for _ in range(DRAWS)]))


def cases_of(paths: Iterable[Path]) -> list[tuple[str, Case]]:
    """The cases of files of records with hidden effects that can be seen, each with what it is of."""
    cases = []
    for path in paths:
        head, *rows = read_records(path)
        task = registry.build("task", registry.named_in(str(path), "task", head["task"], trust=False), {})
        for row in rows:
            case = Case(task, row, row["diagnosis"])
            pair = row["kind"] == "two" and case.both_visible
            if row["error"] is None and (pair or row["kind"] in ("own", "foreign", "withheld")):
                cases.append((_name(row), case))
    return sorted(cases, key=lambda each: each[0])


def _name(row: dict[str, Any]) -> str:
    shapes = f"{row['set']} shapes"
    return shapes if row["kind"] in ("own", "foreign") else f"{row['kind']}, {shapes}"


if __name__ == "__main__":
    print(table(cases_of(map(Path, sys.argv[1:]))).to_string(index=False, float_format=lambda value: f"{value:.2f}"))
