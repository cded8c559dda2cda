"""The search by evidence beside the former one, by rules, on the same data: `python -m avobench.reports.former`.

A column a task and search, over the data sets that both have. Those of the third series are the ones whose family the
former catalogue had; of the others the search by evidence has the larger catalogue of today, hence more rivals. Where
an effect was withheld, it had the families that the former search had.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench import registry
from avobench.challenge.case import Case
from avobench.challenge.records import read_records

RESULTS = Path("results/challenge")
FORMER = Path("results/former")
"""What the former search said of the same data sets."""
SEARCHES = ("by rules", "by evidence")


def table(former: Path = FORMER, results: Path = RESULTS) -> pd.DataFrame:
    """Quantities (rows) of every task of which there are records of both searches, and of all tasks together."""
    columns: dict[tuple[str, str], list[tuple[Case, float]]] = {}
    for path in sorted(former.glob("*.jsonl")):
        if not (results / path.name).exists() or _made(results / path.name) != _made(path):
            continue  # these data sets the search by evidence has not diagnosed
        old, new = _cases(path), _cases(results / path.name)
        common = [name for name in old if name in new]
        for search, cases in zip(SEARCHES, (old, new), strict=True):
            for task in (path.name.partition("-")[0], "all"):
                columns.setdefault((task, search), []).extend(cases[name] for name in common)
    tasks = sorted({task for task, _ in columns} - {"all"})
    return pd.DataFrame(
        {(task, search): _quantities(columns[task, search]) for task in (*tasks, "all") for search in SEARCHES}
    )


def _made(path: Path) -> tuple[int, int]:
    """By what data sets differ of challenges with one name: their seed and number of events."""
    head, *_ = read_records(path)
    return head["seed"], head["num_events"]


def _cases(path: Path) -> dict[str, tuple[Case, float]]:
    """By the name of a data set: the case, and the seconds of a processor that it took."""
    head, *rows = read_records(path)
    task = registry.build("task", registry.named_in(str(path), "task", head["task"], trust=False), {})
    return {
        row["case"]: (Case(task, row, row["diagnosis"]), row["cpu_seconds"]) for row in rows if row["error"] is None
    }


def _quantities(cases: list[tuple[Case, float]]) -> dict[str, Any]:
    """How often it was right: names of one effect where a disagreement was seen, of two where both are visible."""
    seconds = [seconds for case, seconds in cases if case.answer["kind"] != "none"]
    of: dict[str, list[Case]] = {}
    for case, _ in cases:
        of.setdefault(case.answer["kind"], []).append(case)
    found = {kind: [case for case in own if case.detected] for kind, own in of.items()}
    foreign = {
        f"series {k}": [case for case in found.get("foreign", []) if case.answer["effects"][0]["series"] == k]
        for k in (1, 2, 3)
    }
    one = [*found.get("own", []), *found.get("foreign", [])]
    pairs = [case for case in found.get("two", []) if case.both_visible]
    firsts = {"own shapes": found.get("own", []), **foreign}
    return {
        **{f"{name}: right first": _share(case.first() for case in group) for name, group in firsts.items()},
        "one effect: truth in the tie set": _share(case.in_first_tie for case in one),
        "one effect: size of the set": _mean(len(case.ties[0]) for case in one if case.ties),
        "one effect: a further one named": _share(len(case.named) > 1 for case in one),
        "two, both visible: both named": _share(case.both for case in pairs),
        "withheld: falsely explained": _share(case.explained for case in found.get("withheld", [])),
        "nothing hidden: false alarms": _share(case.detected for case in of.get("none", [])),
        "something hidden: processor seconds, median": f"{np.median(seconds):.1f}",
        "something hidden: processor seconds, at most": f"{max(seconds):.0f}",
    }


def _share(hits: Iterable[bool]) -> str:
    hits = list(hits)
    return f"{sum(hits)}/{len(hits)}" if hits else "-"


def _mean(values: Iterable[float]) -> str:
    values = list(values)
    return f"{np.mean(values):.2f}" if values else "-"


if __name__ == "__main__":
    print(table().to_string())
