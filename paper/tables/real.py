"""What the diagnosis says of real data, beside what is known: `python -m paper.tables.real`.

It prints the table, from the records of `python -m paper.study real`; with `--out` it writes docs/real-data.md.
"""

import textwrap
from pathlib import Path
from typing import Any

import click
import pandas as pd

from avobench.bench.store.files import write_file
from avobench.diagnosis.schema import Verdict
from avobench.reports.numbers import p_equals, p_value, with_error
from paper.studies.real import FOLDER, read_all

RIGHT, DEFENSIBLE, WRONG = "right", "defensible", "wrong"


def judged(expected: dict[str, Any], diagnosis: dict[str, Any]) -> str:
    """Whether a diagnosis is right, defensible or wrong, by what was written down before it was made.

    Where nothing is missing, it is right not to find a disagreement, and all else is wrong. Where something is, it is
    right to name that first, at its known value if there is one; a value outside the tolerance is wrong. Defensible is
    the right name as one that is tied with an effect that was named, or as a later one; or to name first what tells a
    part of it. All else is wrong, and so is to find nothing.
    """
    if not expected["answer"]:
        return RIGHT if diagnosis["verdict"] == Verdict.NOTHING else WRONG
    effects = diagnosis["effects"]
    if not effects:
        return WRONG
    first = effects[0]
    if first["name"] in expected["answer"]:
        return RIGHT if _at_its_value(first, expected["value"]) else WRONG
    others = {other["name"] for effect in effects for other in (effect, *effect["tied_with"])}
    return DEFENSIBLE if others & set(expected["answer"]) or first["name"] in expected["also"] else WRONG


def _at_its_value(effect: dict[str, Any], true: dict[str, Any] | None) -> bool:
    if true is None:
        return True
    parameter = effect["parameters"].get(true["parameter"])
    return parameter is not None and abs(parameter["value"] - true["value"]) <= true["tolerance"]


def table(seeds: list[list[dict[str, Any]]]) -> pd.DataFrame:
    """One row per data set: what is known, what was named and how many are tied, p-values, gaps and the judgement.

    All with the first seed; the last columns say how often each judgement was passed with all seeds.
    """
    rows = []
    for record, *others in zip(*seeds, strict=True):
        judgements = [judged(each["expected"], each["diagnosis"]) for each in (record, *others)]
        expected, diagnosis = record["expected"], record["diagnosis"]
        named = [effect["name"] for effect in diagnosis["effects"]]
        unnamed = "nothing" if diagnosis["verdict"] == Verdict.NOTHING else "something, no name"
        gaps = [diagnosis["gap_before"], diagnosis["gap_after"]]
        row = {
            "data": record["name"],
            "events": diagnosis["num_events"],
            "known": " or ".join(expected["answer"]) or "nothing",
            "named": ", then ".join(named) or unnamed,
            "tied": sum(len(effect["tied_with"]) for effect in diagnosis["effects"]),
            "p": p_value(diagnosis["p_value_before"]),
            "p after": p_value(diagnosis["p_value_after"]),
            "gap": " -> ".join(f"{gap['value']:.2f}" for gap in gaps if gap is not None),
            "seconds": f"{record['processor_seconds']:.1f}",
            "answer": judgements[0],
            **{kind: judgements.count(kind) for kind in (RIGHT, DEFENSIBLE, WRONG)},
        }
        rows.append(row)
    return pd.DataFrame(rows)


def format_table(seeds: list[list[dict[str, Any]]]) -> str:
    """`table`, to be read, and below it how often each judgement was passed."""
    judgements = table(seeds)
    counts = ", ".join(f"{judgements[kind].sum()} {kind}" for kind in (RIGHT, DEFENSIBLE, WRONG))
    return f"{judgements.to_string(index=False)}\n{len(judgements)} data sets with {len(seeds)} seeds each: {counts}"


INTRODUCTION = """\
# Real data

Where a [diagnosis](diagnosis.md) is tried on simulated data, whoever hides an effect may think like whoever wrote the
catalogue. Each of these data sets was measured, and the literature knows what a simple simulator of it lacks, or that
it lacks nothing. The answers were written into `examples/real/expected.json`, and committed, before any diagnosis of
them was made. `python -m paper.study real` diagnoses them all, and this page is what

```
python -m paper.tables.real --out docs/real-data.md
```

writes from the records in `results/real`. Each data set is an example by itself, too:
`python examples/real/accidents.py`.

**Right** is to name first what is known to be missing, at its known value if there is one, or to find no disagreement
where nothing is missing. **Defensible** is the right name as a tied or later one. A first name is also defensible if it
was written down before as a part of the answer. All else is **wrong**, and so is to find nothing where something is
missing. `tied` is the number of other names that describe the data as well. With many of them a right name says
little.

Each data set is diagnosed with five seeds. Each seed holds out other events, which can change the answer for a few
hundred events. The columns are for the first seed, and the last three count all seeds."""


def page(seeds: list[list[dict[str, Any]]]) -> str:
    """The whole page, in Markdown; in words what the first seed says."""
    lines = [INTRODUCTION, "", "```", format_table(seeds), "```"]
    for record in seeds[0]:
        expected, diagnosis = record["expected"], record["diagnosis"]
        about, lacks = " ".join(record["data_head"][:-1]), f"**Known:** {expected['lacks']}. {expected['why']}"
        lines += ["", f"## {record['name'].replace('_', ' ').capitalize()}", "", wrapped(about)]
        lines += ["", wrapped(lacks), "", wrapped(f"**Said: {judged(expected, diagnosis)}.** {_said(diagnosis)}")]
    return "\n".join(lines) + "\n"


def _said(diagnosis: dict[str, Any]) -> str:
    """What a diagnosis says, in sentences."""
    effects = [_told(effect) for effect in diagnosis["effects"]]
    after = diagnosis["theta_after"] or {}
    theta = [
        f"{name} = {with_error(**value)}" + (f", then {with_error(**after[name])}" if name in after else "")
        for name, value in diagnosis["theta_before"].items()
    ]
    verdict = diagnosis["verdict"].capitalize()
    return ". ".join([f"{verdict}, {p_equals(diagnosis['p_value_before'])}", *effects, "; ".join(theta)]) + "."


def _told(effect: dict[str, Any]) -> str:
    values = [f"{name} = {with_error(p['value'], p['std'])}" for name, p in effect["parameters"].items()]
    tied = f", not told from {' or '.join(tie['name'] for tie in effect['tied_with'])}" if effect["tied_with"] else ""
    return f"`{effect['name']}` with {', '.join(values)}{tied}"


def wrapped(text: str) -> str:
    """A paragraph of a page in lines of 120 letters at most."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=None, help="Page to write.  [prints the table]")
def main(results: Path, out: Path | None) -> None:
    """Print the table of the records, or write the page."""
    seeds = read_all(results)
    if out is None:
        click.echo(format_table(seeds))
    else:
        write_file(out, page(seeds).encode())


if __name__ == "__main__":
    main()
