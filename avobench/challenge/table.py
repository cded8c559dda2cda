"""The score of a challenge as a page of text, and beside the project's targets."""

from collections.abc import Callable
from typing import Any

import pandas as pd

from avobench.challenge.case import VISIBLE
from avobench.challenge.score import ALL, score
from avobench.diagnosis.schema import Verdict

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


def as_text(result: dict[str, Any]) -> str:
    lines = [
        f"{result['task']}: {result['solved']} of {result['cases']} cases solved, {len(result['failed'])} failed, "
        f"{' or '.join(map(str, result['num_events']))} events each",
        *(f"  failed {name}: {error}" for name, error in result["failed"].items()),
        f"no effect: false alarms {_percent(result['none']['false_alarms'])}, "
        f"theta within 2 errors {_percent(result['none']['theta_within_2'])}",
    ]
    for each, one in result["one"].items():
        lines += _one(each, one)
    for each, withheld in _sets(result["withheld"]):
        lines += _withheld(each, withheld)
    for each, two in _sets(result["two"]):
        lines += _two(each, two)
    if result["seconds"]:
        lines.append(
            "seconds a data set: "
            f"of a processor median {result['cpu_seconds']['median']:.1f}, max {result['cpu_seconds']['max']:.1f}; "
            f"on the clock median {result['seconds']['median']:.1f}, max {result['seconds']['max']:.1f}"
        )
    return "\n".join(lines)


def _one(each: str, one: dict[str, Any]) -> list[str]:
    if not one["cases"]:
        return []
    return [
        f"one effect, {each} shapes: {one['cases']} cases, {one['undetectable']} undetectable; detected, by the "
        "power that the best test would have:",
        *(f"  {100 * p['from']:3.0f} to {100 * p['to']:3.0f} %: {_percent(p)}" for p in one["power"] if p["of"]),
        f"  of those detected: right name first {_percent(one['right_first'])} "
        f"(whatever the feature {_percent(one['right_first_whatever_feature'])})",
        f"  by chi2/ndf before: {classes(one['right_first_by_gap'])}",
        f"  truth in the tie set {_percent(one['in_tie_set'])}, mean size {number(one['tie_size'])}, another "
        f"effect named or tied {_percent(one['another_would_do'])}",
        f"  of all with a power of {100 * VISIBLE:.0f} % or more: right name first "
        f"{_percent(one['visible_right_first'])}",
        f"  a further effect named, though none was hidden {_percent(one['more_named'])}",
        f'  "{Verdict.NAMED}" {_percent(one["explained"])}; '
        f"then theta within 2 errors {_percent(one['theta_within_2'])}",
        _medians(one),
        *(f"    {line}" for line in one["mistaken"]),
    ]


def _withheld(each: str, withheld: dict[str, Any]) -> list[str]:
    if not withheld["cases"]:
        return []
    return [
        f"withheld effect, {each} shapes: detected {_percent(withheld['detected'])}, of these falsely "
        f"explained {_percent(withheld['falsely_explained'])}",
        f"  by chi2/ndf before: {classes(withheld['falsely_explained_by_gap'])}",
        *(f"    {line}" for line in withheld["mistaken"] if each != ALL),
    ]


def _two(each: str, two: dict[str, Any]) -> list[str]:
    if not two["cases"]:
        return []
    return [
        f"two effects, {each} shapes: detected {_percent(two['detected'])}, of these both named "
        f"{_percent(two['both'])}, with ties {_percent(two['both_with_ties'])}, at least one "
        f"{_percent(two['at_least_one'])}",
        f"  where the best test sees each beside the other at {100 * VISIBLE:.0f} % power or more: both named "
        f"{_percent(two['visible_both'])}, at least one {_percent(two['visible_at_least_one'])}",
        "  of these not both named, but what was named describes the events "
        f"{_percent(two['visible_missed_explained'])}",
        _medians(two),
        *(f"    {line}" for line in two["mistaken"] if each != ALL),
    ]


def _sets(parts: dict[str, Any]) -> list[tuple[str, Any]]:
    """The parts by set of shapes; that of all only where it is more than one of them."""
    return [
        (each, part)
        for each, part in parts.items()
        if each != ALL or part["cases"] > max(other["cases"] for name, other in parts.items() if name != ALL)
    ]


def classes(parts: list[dict[str, Any]]) -> str:
    """How many of how many, by classes of a quantity."""
    return ", ".join(
        f"{part['count']}/{part['of']} {'above' if part['to'] is None else 'to'} {part['to'] or part['from']:g}"
        for part in parts
    )


def _medians(part: dict[str, Any]) -> str:
    return (
        f"  medians: held-out chi2/ndf {number(part['gap_before'])} -> {number(part['gap_after'])}, "
        f"bias of theta {number(part['bias_before'])} -> {number(part['bias_after'])}"
    )


def _percent(rate: dict[str, Any]) -> str:
    if not rate["of"]:
        return "0/0"
    return (
        f"{rate['count']}/{rate['of']} = {100 * rate['share']:.0f} % "
        f"({100 * rate['low']:.0f} to {100 * rate['high']:.0f})"
    )


def number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


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
