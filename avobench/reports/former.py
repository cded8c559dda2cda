"""The search by evidence beside the former one, by rules, on the same data: `python -m avobench.reports.former`.

A row a task and search, over the cases of the third series that both have: those whose family the former catalogue had.
What was hidden nobody saw who developed either.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench import registry
from avobench.challenge.case import Case
from avobench.challenge.records import read_records

RESULTS = Path("results/challenge")
FORMER = Path("results/former")
"""What the former search said of some of the same data sets."""


def table(former: Path = FORMER, results: Path = RESULTS) -> pd.DataFrame:
    """The rows of every task of which there are records of both."""
    rows = []
    for path in sorted(former.glob("*.jsonl")):
        old, new = _cases(path), _cases(results / path.name)
        common = [name for name in old if name in new]
        for search, cases in (("by evidence", new), ("by rules", old)):
            rows.append({"task": path.name.partition("-")[0], "search": search, **_row([cases[n] for n in common])})
    return pd.DataFrame(rows)


def _cases(path: Path) -> dict[str, tuple[Case, float]]:
    """By the name of a data set: the case, and the seconds of a processor that it took."""
    head, *rows = read_records(path)
    task = registry.build("task", registry.named_in(str(path), "task", head["task"], trust=False), {})
    return {
        row["case"]: (Case(task, row, row["diagnosis"]), row["cpu_seconds"]) for row in rows if row["error"] is None
    }


def _row(cases: list[tuple[Case, float]]) -> dict[str, Any]:
    """How often the names were right, of cases in which a disagreement was seen."""
    found = [case for case, _ in cases if case.detected]
    seconds = [seconds for _, seconds in cases]
    return {
        "cases": len(cases),
        "detected": len(found),
        "right first": sum(case.first() for case in found),
        "truth in the tie set": sum(case.in_first_tie for case in found),
        "size of the set": np.mean(list(_sizes(found))),
        "a further one named": sum(len(case.named) > 1 for case in found),
        "processor seconds": np.median(seconds),
        "at most": max(seconds),
    }


def _sizes(cases: list[Case]) -> Iterator[int]:
    yield from (len(case.ties[0]) for case in cases if case.ties)


if __name__ == "__main__":
    print(table().to_string(index=False, float_format=lambda value: f"{value:.1f}"))
