"""Names by the search beside names by a classifier that fits nothing: `python -m avobench.reports.recognised NAME ...`.

From the records of `avobench.studies.recognised` and those of the challenges themselves, all or those of these names:
of single effects in foreign shapes that were detected, how many each names, and the mean logarithm of the probability
that each gives to the truth. Each series was diagnosed by the search as it was then, and classified by what the series
before it had taught.
"""

import json
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from avobench.bench import registry
from avobench.challenge.case import Case
from avobench.challenge.records import read_records
from avobench.challenge.shapes import ONE_FAMILY, kind_of_events
from avobench.studies.recognised import RESULTS

CHALLENGES = Path("results/challenge")
LEAST = 0.01
"""Added to each probability, so that no name is excluded for good."""


def searched(case: Case) -> dict[str, float]:
    """Probabilities of families by the search."""
    found: dict[str, float] = {}
    for each in case.diagnosis["probabilities"]:
        name = ONE_FAMILY.get((kind_of_events(case.task), each["name"]), each["name"])
        found[name] = found.get(name, 0.0) + each["probability"]
    return found


def rows(path: Path) -> Iterator[dict[str, Any]]:
    """A row for each detected effect of a challenge: whether each is right, and the logarithm it gives to the truth."""
    head, *lines = map(json.loads, path.read_text().splitlines())
    told = {line["case"]: line for line in lines}
    _, *results = read_records(CHALLENGES / path.name)
    task = registry.build("task", head["task"], {})
    for result in results:
        if result["kind"] != "foreign" or result["error"] is not None:
            continue
        case, line = Case(task, result, result["diagnosis"]), told[result["case"]]
        if not case.detected:
            continue
        search, other = searched(case), line["probabilities"]
        row = {"task": task.name, "series": head["series"], "cases": 1}
        first = case.named[0][0] if case.named else None
        named = ONE_FAMILY.get((kind_of_events(task), first), first)
        for who, given in (("search", search), ("classifier", other)):
            best = named if who == "search" else max(given, key=given.get)
            row[who] = best == line["hidden"]
            row[f"log score: {who}"] = np.log(given.get(line["hidden"], 0) + LEAST)
        yield row


def every(names: Iterable[str]) -> pd.DataFrame:
    """A row for each data set of all challenges of these names, as `rows` gives them."""
    return pd.DataFrame([row for name in names for row in rows(RESULTS / f"{name}.jsonl")])


def disagree(known: pd.DataFrame) -> str:
    """How often one of the two is right and the other is not, and how probable so uneven a split is by chance."""
    first, second = known["search"].astype(bool), known["classifier"].astype(bool)
    alone, other = int((first & ~second).sum()), int((second & ~first).sum())
    p = binomtest(alone, max(alone + other, 1)).pvalue
    return (
        f"the classifier alone is right in {other} cases, the search alone in {alone}: p = {p:.2g} (exact, two-sided)"
    )


def table(known: pd.DataFrame) -> pd.DataFrame:
    """A row for each task and series, and one for all: numbers of names that are right, and mean log scores."""
    how = {column: "mean" if column.startswith("log") else "sum" for column in known.columns[2:]}
    each = known.groupby(["task", "series"]).agg(how).reset_index()
    whole = known.agg(how).to_frame().T.assign(task="all", series="")
    return pd.concat([each, whole], ignore_index=True).astype(dict.fromkeys(["cases", "search", "classifier"], int))


if __name__ == "__main__":
    known = sorted(path.stem for path in RESULTS.glob("*.jsonl"))
    if unknown := [name for name in sys.argv[1:] if name not in known]:
        sys.exit(f"there are no records of {unknown[0]} in {RESULTS}; there are those of {', '.join(known)}")
    found = every(sys.argv[1:] or known)
    print(table(found).to_string(index=False, float_format=lambda value: f"{value:.2f}"))
    print(disagree(found))
