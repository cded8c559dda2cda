"""The project's targets for the scores of a challenge, beside the scores."""

from collections.abc import Callable
from typing import Any

import pandas as pd

from avobench.challenge.score import ALL, score
from avobench.challenge.table import classes, number

COVERS = "covers {:.0%} or below"
WANTED: tuple[tuple[str, tuple[str, ...], str, float], ...] = (
    ("no effect: false alarms", ("none", "false_alarms"), COVERS, 0.05),
    ("no effect: theta within 2 errors", ("none", "theta_within_2"), "at least", 0.9),
    *(
        row
        for each, first, tie, size in (("own", 0.95, 0.98, 1.4), ("foreign", 0.85, 0.95, 1.6))
        for row in (
            (f"{each} shapes: right name first", ("one", each, "right_first"), "at least", first),
            (f"{each} shapes: truth in the tie set", ("one", each, "in_tie_set"), "at least", tie),
            (f"{each} shapes: mean size of the tie set", ("one", each, "tie_size"), "at most", size),
            (f"{each} shapes: chi2/ndf after, median", ("one", each, "gap_after"), "at most", 1.15),
            (f"{each} shapes: theta within 2 errors", ("one", each, "theta_within_2"), "at least", 0.9),
        )
    ),
    ("withheld: falsely explained", ("withheld", ALL, "falsely_explained"), "at most", 0.1),
    ("two effects: both named", ("two", ALL, "both"), "at least", 0.7),
    ("two effects: at least one named", ("two", ALL, "at_least_one"), "at least", 0.95),
    ("two effects, both visible: both named", ("two", ALL, "visible_both"), "at least", 0.7),
    ("two effects, both visible: at least one named", ("two", ALL, "visible_at_least_one"), "at least", 0.95),
)
"""What is wanted: a quantity, where it stands in a score, and its bound."""


def targets(*challenges: list[dict[str, Any]], trust: bool = False) -> str:
    """What is wanted of challenges beside what they gave, one column per task, and whether all pooled are as wanted."""
    tasks = list(dict.fromkeys(lines[0]["task"] for lines in challenges))
    scores = {task: score(*(lines for lines in challenges if lines[0]["task"] == task), trust=trust) for task in tasks}
    scores["all"] = score(*challenges, trust=trust)
    rows = []
    for name, path, how, bound in WANTED:
        got = {task: _at(result, path) for task, result in scores.items()}
        cells = {task: _short(value) for task, value in got.items()}
        wanted = (
            how.format(bound)
            if how == COVERS
            else f"{how} {bound:.0%}"
            if isinstance(got["all"], dict)
            else f"{how} {bound:g}"
        )
        rows.append({"quantity": name, **cells, "wanted": wanted, "verdict": _verdict(got["all"], how, bound)})
    one, withheld = scores["all"]["one"], scores["all"]["withheld"][ALL]
    by_gap = {f"{each} shapes, right name first": one[each]["right_first_by_gap"] for each in one}
    by_gap["withheld, falsely explained"] = withheld["falsely_explained_by_gap"]
    lines = [f"{name}, by chi2/ndf before: {classes(parts)}" for name, parts in by_gap.items()]
    others = ", ".join(f"{each} shapes {_short(one[each]['another_would_do'])}" for each in one)
    lines.append(f"not withheld, and yet another effect named or tied: {others}")
    missed = _short(scores["all"]["two"][ALL]["visible_missed_explained"])
    lines.append(f"two effects, both visible, not both named, what was named describes the events: {missed}")
    return "\n".join([pd.DataFrame(rows).to_string(index=False), *lines])


def _at(result: dict[str, Any], path: tuple[str, ...]) -> Any:
    for name in path:
        result = result[name]
    return result


def _short(value: dict[str, Any] | float | None) -> str:
    if isinstance(value, dict):
        return f"{value['count']}/{value['of']} = {value['share']:.0%}" if value["of"] else "-"
    return number(value)


def _verdict(value: dict[str, Any] | float | None, how: str, bound: float) -> str:
    if isinstance(value, dict):
        value = value["low"] if how == COVERS else value["share"]
    if value is None:
        return "-"
    met: Callable[[float], bool] = {"at least": lambda v: v >= bound}.get(how, lambda v: v <= bound)
    return "met" if met(value) else "not met"
