"""The score of a challenge as a page of text, and beside the project's targets."""

from functools import reduce
from operator import getitem
from typing import Any

import pandas as pd

from avobench.challenge.case import VISIBLE
from avobench.challenge.score import ALL, score
from avobench.diagnosis.schema import Verdict

KINDS = {"none": "no effect", "one": "one effect", "withheld": "withheld effect", "two": "two effects"}
"""What is hidden, by its name in a score."""
ALL_SHAPES = f"{ALL} shapes"
LABELS = {
    "power": "detected, power of the best test",
    "right_first": "right name first",
    "right_first_by_gap": "right name first, chi2/ndf before",
    "right_first_whatever_feature": "right name first, whatever the feature",
    "in_tie_set": "truth in the tie set",
    "tie_size": "mean size of the tie set",
    "another_would_do": "another effect named or tied",
    "more_named": "a further effect named, though none was hidden",
    "visible_right_first": f"right name first, of all with a power of {VISIBLE:.0%} or more",
    "visible_in_tie_set": f"truth in the tie set, of all with a power of {VISIBLE:.0%} or more",
    "explained": f'"{Verdict.NAMED}"',
    "falsely_explained_by_gap": "falsely explained, chi2/ndf before",
    "both": "both named",
    "at_least_one": "at least one named",
    "both_with_ties": "both named, with ties",
    "visible_both": "both named, of those with both visible",
    "visible_at_least_one": "at least one named, of those with both visible",
    "visible_missed_explained": "of these not both named, but what was named describes the events",
    "theta_within_2": "theta within 2 errors",
    "gap_before": "chi2/ndf before, median",
    "gap_after": "chi2/ndf after, median",
    "bias_before": "bias of theta before, median",
    "bias_after": "bias of theta after, median",
}
"""Names of quantities that need more words than in a score."""
LEAST, MOST, COVERS = "at least", "at most", "covers at most"
WANTED: dict[tuple[str, ...], tuple[str, float]] = {
    ("none", "false_alarms"): (COVERS, 0.05),
    ("none", "theta_within_2"): (LEAST, 0.9),
    ("one", "own", "right_first"): (LEAST, 0.95),
    ("one", "own", "in_tie_set"): (LEAST, 0.98),
    ("one", "own", "tie_size"): (MOST, 1.4),
    ("one", "own", "gap_after"): (MOST, 1.15),
    ("one", "own", "theta_within_2"): (LEAST, 0.9),
    ("one", "foreign", "right_first"): (LEAST, 0.85),
    ("one", "foreign", "in_tie_set"): (LEAST, 0.95),
    ("one", "foreign", "tie_size"): (MOST, 1.6),
    ("one", "foreign", "gap_after"): (MOST, 1.15),
    ("one", "foreign", "theta_within_2"): (LEAST, 0.9),
    ("withheld", ALL, "falsely_explained"): (MOST, 0.1),
    ("two", ALL, "both"): (LEAST, 0.7),
    ("two", ALL, "at_least_one"): (LEAST, 0.95),
    ("two", ALL, "visible_both"): (LEAST, 0.7),
    ("two", ALL, "visible_at_least_one"): (LEAST, 0.95),
}
"""The bound of a quantity, by where it stands in a score. An interval covers what lies above its low end."""


def as_text(result: dict[str, Any]) -> str:
    """All of a score: a table for each kind with a column for each set of shapes, and every mistake below it."""
    lines = [
        f"{result['task']}: {result['solved']} of {result['cases']} cases solved, {len(result['failed'])} failed, "
        f"{' or '.join(map(str, result['num_events']))} events each",
        *(f"  failed {name}: {error}" for name, error in result["failed"].items()),
    ]
    for kind, title in KINDS.items():
        parts = _parts(result, kind)
        if parts:
            table = pd.DataFrame({name: _rows(part) for name, part in parts.items()})
            lines += ["", table.rename_axis(title, axis=1).to_string()]
            lines += [f"  {line}" for name in parts if name != ALL_SHAPES for line in parts[name].get("mistaken", [])]
    if result["seconds"]:
        lines.append(
            "seconds a data set: "
            f"of a processor median {result['cpu_seconds']['median']:.1f}, max {result['cpu_seconds']['max']:.1f}; "
            f"on the clock median {result['seconds']['median']:.1f}, max {result['seconds']['max']:.1f}"
        )
    return "\n".join(lines)


def _parts(result: dict[str, Any], kind: str) -> dict[str, dict[str, Any]]:
    """What a score says of a kind, by the set of shapes; of all only where they are of more than one set."""
    if kind == "none":
        return {"": result[kind]} if result[kind]["false_alarms"]["of"] else {}
    parts = {f"{each} shapes": part for each, part in result[kind].items() if part["cases"]}
    return parts if len(parts) > 2 else {name: part for name, part in parts.items() if name != ALL_SHAPES}


def _rows(part: dict[str, Any]) -> dict[str, str]:
    """The quantities in words: shares with their 95 % intervals, and those by classes with a row for each class."""
    rows = {}
    for name, value in part.items():
        if isinstance(value, dict) and value["of"]:
            rows[_label(name)] = f"{_number(value)} ({value['low']:.0%} to {value['high']:.0%})"
        elif not isinstance(value, list):
            rows[_label(name)] = _number(value)
        elif name != "mistaken":
            ends = [f"above {each['from']:g}" if each["to"] is None else f"to {each['to']:g}" for each in value]
            rows |= {f"{_label(name)} {end}": _number(each) for end, each in zip(ends, value, strict=True)}
    return rows


def targets(*challenges: list[dict[str, Any]], trust: bool = False) -> str:
    """What is wanted of challenges beside what they gave, one column per task, and whether all pooled are as wanted."""
    tasks = list(dict.fromkeys(lines[0]["task"] for lines in challenges))
    scores = {task: score(*(lines for lines in challenges if lines[0]["task"] == task), trust=trust) for task in tasks}
    scores["all"] = score(*challenges, trust=trust)
    rows = []
    for path, (how, bound) in WANTED.items():
        got = {task: reduce(getitem, path, result) for task, result in scores.items()}
        wanted = f"{how} {bound:.0%}" if isinstance(got["all"], dict) else f"{how} {bound:g}"
        cells = {task: _number(value) for task, value in got.items()}
        rows.append({"quantity": _title(path), **cells, "wanted": wanted, "verdict": _verdict(got["all"], how, bound)})
    return pd.DataFrame(rows).to_string(index=False)


def _title(path: tuple[str, ...]) -> str:
    kind, *each, name = path
    where = f"{KINDS[kind]}, {each[0]} shapes" if each else "no effect"
    return f"{where}: {_label(name)}"


def _label(name: str) -> str:
    return LABELS.get(name, name.replace("_", " "))


def _number(value: dict[str, Any] | float | None) -> str:
    if isinstance(value, dict):
        return f"{value['count']}/{value['of']} = {value['share']:.0%}" if value["of"] else "-"
    return "-" if value is None else f"{value:.3g}"


def _verdict(value: dict[str, Any] | float | None, how: str, bound: float) -> str:
    if isinstance(value, dict):
        value = value["low" if how == COVERS else "share"]
    if value is None:
        return "-"
    return "met" if (value >= bound if how == LEAST else value <= bound) else "not met"
