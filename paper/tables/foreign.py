"""What the diagnosis says of cases of others, by configuration: `python -m paper.tables.foreign`.

It prints tables of the records of `python -m paper.studies.foreign`: how often it was right, and each first name. A
configuration is called by the shapes that a family may have; `networks` are those of experience.
"""

from pathlib import Path
from statistics import mean, median
from typing import Any

import click
import pandas as pd

from avobench.cli.main import main
from avobench.diagnosis.schema import Verdict
from paper.studies.foreign import FOLDER, read

REJECTED = 1e-10
"""p-value of the model with what was named, below which it does not describe the events."""
RIGHT, DEFENSIBLE, WRONG, UNNAMED, UNSEEN, QUIET = "right", "defensible", "wrong", "no name", "not seen", "no alarm"
MARKS = {RIGHT: "+", DEFENSIBLE: "~", WRONG: "-", UNNAMED: " ", UNSEEN: " ", QUIET: "+"}
Record = dict[str, Any]


def named(effect: dict[str, Any], answers: list[str]) -> bool:
    """Whether an effect is one of the answers, `name` or `name on feature`."""
    return effect["name"] in answers or full_name(effect) in answers


def full_name(effect: dict[str, Any]) -> str:
    return effect["name"] if effect["feature"] is None else f"{effect['name']} on {effect['feature']}"


def judged(record: Record) -> str:
    """What a diagnosis was, by what was written down before it was made.

    Right is the first name, and where nothing is missing no alarm. Defensible is the right name later or as one that is
    tied, or a first name that was called so. Every alarm where nothing is missing is wrong, with a name or without.
    """
    diagnosis, right = record["diagnosis"], record["right"]
    if not right:
        return QUIET if diagnosis["verdict"] == Verdict.NOTHING else WRONG
    effects = diagnosis["effects"]
    if not effects:
        return UNSEEN if diagnosis["verdict"] == Verdict.NOTHING else UNNAMED
    if named(effects[0], right):
        return RIGHT
    tied = [other for effect in effects for other in (effect, *effect["tied_with"])]
    return DEFENSIBLE if named(effects[0], record["defensible"]) or any(named(o, right) for o in tied) else WRONG


def of_truth(record: Record) -> float | None:
    """The probability of the right effect alone, where the 95 % set holds it; None where it does not."""
    models = [each for each in record["diagnosis"]["models"] if len(each["effects"]) == 1]
    shares = [each["probability"] for each in models if named(each["effects"][0], record["right"])]
    return sum(shares) if shares else None


def row(name: str, records: list[Record]) -> dict[str, Any]:
    """How often a configuration was right, over some of its records."""
    nulls = [record for record in records if not record["right"]]
    effects = [record for record in records if record["right"]]
    answers = [judged(record) for record in effects]
    said = [record["diagnosis"] for record in effects]
    seen = [record for record, answer in zip(effects, answers, strict=True) if answer != UNSEEN]
    truth = [of_truth(record) for record in seen]
    first = [each["effects"][0]["probability"] for each in said if each["effects"]]
    rejected = sum(each["verdict"] == Verdict.NAMED and each["p_value_after"] < REJECTED for each in said)
    calls = [record["diagnosis"]["num_simulations"] / record["diagnosis"]["num_events"] for record in seen]
    return {
        "configuration": name,
        "effects": len(effects),
        **{kind: answers.count(kind) for kind in (RIGHT, DEFENSIBLE, WRONG, UNNAMED, UNSEEN)},
        "in the 95 % set": f"{sum(share is not None for share in truth)} of {len(seen)}",
        "its size": _mean([len(record["diagnosis"]["models"]) for record in seen], 1),
        "P(truth)": _mean([share or 0 for share in truth]),
        "P(first name)": _mean(first),
        "P(outside)": _mean([record["diagnosis"]["outside"] or 0 for record in seen]),
        "family alone": sum(each["verdict"] == Verdict.FAMILY for each in said),
        "named, yet rejected": rejected,
        "a further name": sum(len(each["effects"]) > 1 for each in said),
        "false alarms": f"{sum(judged(record) == WRONG for record in nulls)} of {len(nulls)}",
        "calls an event": f"{median(calls):.0f}" if calls else "-",
        "seconds": _mean([record["processor_seconds"] for record in seen], 0),
    }


def _mean(values: list[float], digits: int = 2) -> str:
    return f"{mean(values):.{digits}f}" if values else "-"


def scores(found: list[list[Record]], made_by: str) -> pd.DataFrame:
    """A row a configuration, of the cases that were made so; none of one that lacks some of the cases."""
    chosen = [[record for record in records if record["made_by"] == made_by] for records in found]
    most = max(map(len, chosen))
    return pd.DataFrame([row(called(records[0]), records) for records in chosen if len(records) == most])


def first_names(found: list[list[Record]]) -> pd.DataFrame:
    """A row a case: what is right, and the first name that each configuration gave."""
    rows: dict[str, dict[str, Any]] = {}
    for records in found:
        for record in sorted(records, key=lambda record: (record["made_by"] == "measured", record["case"])):
            diagnosis = record["diagnosis"]
            known = {"events": diagnosis["num_events"], "right": " or ".join(record["right"]) or "nothing"}
            shown = f"{MARKS[judged(record)]} {first_name(record)}"
            rows.setdefault(record["case"], {"case": record["case"], **known})[called(record)] = shown
    return pd.DataFrame(list(rows.values())).fillna("")


def first_name(record: Record) -> str:
    """The first name that was given, with its feature where the answer has one."""
    effects = record["diagnosis"]["effects"]
    if not effects:
        return "nothing" if record["diagnosis"]["verdict"] == Verdict.NOTHING else "something"
    return full_name(effects[0]) if any(" on " in answer for answer in record["right"]) else effects[0]["name"]


def called(record: Record) -> str:
    """A configuration in a few letters."""
    networks = ", networks" if record["experience"] else ""
    return f"{record['shapes'] or 'all'}{networks}{'' if record['simulations'] else ', no limit'}"


def _order(record: Record) -> tuple[bool, bool, int]:
    """As it is shipped first, then by what it lacks; those without a limit last."""
    return record["simulations"] is None, not record["experience"], -(record["shapes"] or 1000)


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def tables(results: Path) -> None:
    """Print the tables."""
    found = sorted(read(results).values(), key=lambda records: _order(records[0]))
    for made_by in ("simulated", "measured"):
        click.echo(f"{made_by}\n{scores(found, made_by).T.to_string(header=False)}\n")
    click.echo(first_names(found).to_string(index=False))


if __name__ == "__main__":
    main(tables)
