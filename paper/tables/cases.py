"""How often the diagnosis was right on cases of others: `python -m paper.tables.cases [opened|sealed]`.

It prints a table of the records of `python -m paper.studies.cases`, a column per group of cases, and no case by itself.
Groups are those of the simulated cases; what was measured is a group of its own.
"""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from statistics import mean, median
from typing import Any

import click
import numpy as np
import pandas as pd
from sklearn.metrics import roc_auc_score

from avobench.cli.main import main
from avobench.diagnosis.schema import Verdict
from avobench.effects.catalogue import families
from paper.cases.case import Case
from paper.studies.cases import CASES, FOLDER, read

OF = {case.name: case for groups in CASES.values() for cases in groups.values() for case in cases}
REJECTED = 1e-10
"""p-value of the model with what was named, below which it does not describe the events."""
FAR = 10.0
"""Difference of chi-squared by which one fit is plainly better than another: three standard deviations."""
Record = dict[str, Any]
BINS = 5
"""Of probabilities, with equal numbers of cases, for the error of calibration."""


def table(records: list[Record]) -> pd.DataFrame:
    """One row per quantity, and one column per group of cases."""
    groups: dict[str, Callable[[Record], bool]] = {
        group: lambda record, group=group: record["made_by"] == "simulated" and case_of(record).group == group
        for group in ("counts", "one feature", "several features")
    }
    groups |= {"simulated": lambda record: record["made_by"] == "simulated"}
    groups |= {"measured": lambda record: record["made_by"] == "measured"}
    return pd.DataFrame({name: column([r for r in records if of(r)]) for name, of in groups.items()})


def case_of(record: Record) -> Case:
    return OF[record["case"]]


def named(effect: dict[str, Any], answers: Sequence[str]) -> bool:
    """Whether an effect is one of the answers, `name` or `name on feature`."""
    wanted = [answer.partition(" on ") for answer in answers]
    return any(effect["name"] in called(name) and feature in ("", effect["feature"]) for name, _, feature in wanted)


@cache
def called(name: str) -> set[str]:
    """The families that a name stands for: itself, and those of its entries in the catalogue, as quantisation has
    heaping and an edge acceptance has truncation."""
    return {name, *(family.name for point, family in families().items() if point.rpartition(".")[2] == name)}


def column(records: list[Record]) -> dict[str, str]:
    """What is counted of some cases."""
    kinds = {kind: [r for r in records if case_of(r).kind == kind] for kind in ("null", "single", "pair", "outside")}
    alarms = [r for r in kinds["null"] if seen(r)]
    single, pairs, outside = (list(filter(seen, kinds[kind])) for kind in ("single", "pair", "outside"))
    sizes = [len(r["diagnosis"]["models"]) for r in single]
    detected = [*single, *pairs, *outside]
    seconds = [r["processor_seconds"] for r in records]
    calls = [r["diagnosis"]["num_simulations"] / r["diagnosis"]["num_events"] for r in records]
    return {
        "single effects, detected": f"{len(single)} of {len(kinds['single'])}",
        "first name right": of(first_right, single),
        "by chi-squared alone": of(lowest_right, single),
        "right or defensible": of(first_defensible, single),
        "truth in the 95 % set": of(in_set, single),
        "models in it": f"{mean(sizes):.1f}" if sizes else "-",
        "chi-squared per dof with it": f"{median(map(chi_squared, single)):.2f}" if single else "-",
        "a wrong one fits far better": of(misled, single),
        "pairs, detected": f"{len(pairs)} of {len(kinds['pair'])}",
        "both named": of(both_named, pairs),
        "both in the 95 % set": of(in_set, pairs),
        "outside, detected": f"{len(outside)} of {len(kinds['outside'])}",
        "said to be outside": of(said_outside, outside),
        "AUC of P(outside)": area(single, outside),
        "error of calibration": calibration(detected),
        "a lone name, though rejected": of(lone, detected),
        "false alarms": f"{len(alarms)} of {len(kinds['null'])}",
        "right, of all": of(right, records),
        "calls per event": f"{median(calls):.0f}" if calls else "-",
        "seconds": f"{median(seconds):.0f}" if seconds else "-",
    }


def of(holds: Callable[[Record], bool], records: list[Record]) -> str:
    return f"{sum(map(holds, records))} of {len(records)}"


def seen(record: Record) -> bool:
    return record["diagnosis"]["verdict"] != Verdict.NOTHING


def first_right(record: Record) -> bool:
    return bool(effects := record["diagnosis"]["effects"]) and named(effects[0], record["right"])


def single_fits(record: Record) -> list[tuple[float, bool]]:
    """Chi-squared of the best fit with each effect alone, lowest first, and whether it is the right one."""
    fits = [(each["q"], each["effects"][0]) for each in record["sets"] if len(each["effects"] or ()) == 1]
    return sorted((q, named(effect, record["right"])) for q, effect in fits)


def lowest_right(record: Record) -> bool:
    """Whether the single effect whose fit has the lowest chi-squared is right: the simplest rule there is."""
    return bool(fits := single_fits(record)) and fits[0][1]


def misled(record: Record) -> bool:
    """Whether chi-squared of a wrong effect is FAR below that of the right one, or this was not fitted."""
    lowest = {is_right: q for q, is_right in reversed(single_fits(record))}
    return lowest.get(False, np.inf) < lowest.get(True, np.inf) - FAR


def first_defensible(record: Record) -> bool:
    wanted = [*record["right"], *record["defensible"]]
    return bool(effects := record["diagnosis"]["effects"]) and named(effects[0], wanted)


def true(record: Record, effects: list[dict[str, Any]]) -> bool:
    """Whether a set of effects is what happened: the effect alone, or both of a pair."""
    number = 2 if case_of(record).kind == "pair" else 1
    kinds = {effect["name"] for effect in effects}
    return len(effects) == number == len(kinds) and all(named(effect, record["right"]) for effect in effects)


def in_set(record: Record) -> bool:
    return any(true(record, each["effects"]) for each in record["diagnosis"]["models"])


def chi_squared(record: Record) -> float:
    """How well the best fit with what happened describes the events; infinite if there is none."""
    fits = [each for each in record["sets"] if each["effects"] and true(record, each["effects"])]
    return min((each["q"] / max(each["dof"], 1) for each in fits), default=np.inf)


def both_named(record: Record) -> bool:
    return true(record, record["diagnosis"]["effects"])


def said_outside(record: Record) -> bool:
    """Whether nothing is named, or something outside the catalogue is more probable than any set of effects."""
    diagnosis = record["diagnosis"]
    most = max((each["probability"] for each in diagnosis["models"]), default=0)
    return not diagnosis["effects"] or (diagnosis["outside"] or 0) > most


def right(record: Record) -> bool:
    """Whether the answer is right: silence, the first name, both names, or that it lies outside."""
    by_kind = {"null": lambda r: not seen(r), "single": first_right, "pair": both_named}
    by_kind |= {"outside": lambda r: seen(r) and said_outside(r)}
    return by_kind[case_of(record).kind](record)


def lone(record: Record) -> bool:
    """Whether one effect is named as what is missing, though its model is rejected."""
    diagnosis = record["diagnosis"]
    alone = len(diagnosis["effects"]) == 1 and diagnosis["verdict"] != Verdict.FAMILY
    return alone and diagnosis["p_value_after"] < REJECTED


def area(present: list[Record], outside: list[Record]) -> str:
    """The area under the curve of P(outside) for what lies outside against single effects of the catalogue."""
    if not present or not outside:
        return "-"
    scores = [record["diagnosis"]["outside"] or 0 for record in (*present, *outside)]
    return f"{roc_auc_score([0] * len(present) + [1] * len(outside), scores):.2f}"


def calibration(records: list[Record]) -> str:
    """Mean distance of the probability of the most probable answer from how often it is right, in bins of it."""
    told = []
    for record in records:
        diagnosis = record["diagnosis"]
        if diagnosis["outside"] is None:
            continue
        best = max(diagnosis["models"], key=lambda each: each["probability"], default={"effects": [], "probability": 0})
        if diagnosis["outside"] > best["probability"]:
            told.append((diagnosis["outside"], case_of(record).kind == "outside"))
        else:
            told.append((best["probability"], true(record, best["effects"])))
    if len(told) < BINS:
        return "-"
    parts = np.array_split(np.array(sorted(told), dtype=float), BINS)
    return f"{sum(len(part) * abs(np.diff(part.mean(axis=0))[0]) for part in parts) / len(told):.2f}"


@click.command()
@click.argument("which", nargs=-1, type=click.Choice(list(CASES)))
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def tables(which: tuple[str, ...], results: Path) -> None:
    """Print the table of the opened cases, of the sealed ones, or of both, for each configuration with records."""
    for each in which or list(CASES):
        for folder in sorted((results / each).iterdir()):
            records = read(folder)
            click.echo(f"{each}, {folder.name}: {len(records)} cases\n\n{table(records).to_string()}\n")


if __name__ == "__main__":
    main(tables)
