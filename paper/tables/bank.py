"""What a diagnosis of the development data in `results/bank` costs and finds: `python -m paper.tables.bank`."""

import json
from statistics import median
from typing import Any

import click
import pandas as pd
from scipy.stats import binomtest

from paper.studies.bank import FOLDER

Row = dict[str, Any]
FORMER, BANK, NOTHING = "hidden-4c8d801", "hidden-bank", "nothing-bank"
ALPHA = 0.05


def rows_of(name: str) -> list[Row]:
    """The records of a file of the folder."""
    return [json.loads(line) for line in (FOLDER / f"{name}.jsonl").read_text().splitlines()]


def first(row: Row) -> bool:
    """Whether what was named is what was hidden."""
    return bool(row["named"]) and set(row["named"]) <= set(row["truth"])


def table(former: list[Row], bank: list[Row]) -> pd.DataFrame:
    """One row per task and search, of the data sets that both diagnosed."""
    both = {(row["data"], row["case"]) for row in former} & {(row["data"], row["case"]) for row in bank}
    lines = []
    for task in sorted({data for data, _ in both}):
        for search, rows in (("before", former), ("bank", bank)):
            of = [row for row in rows if row["data"] == task and (task, row["case"]) in both]
            calls = [row["calls_per_event"] for row in of]
            lines.append(
                {
                    "task": task,
                    "search": search,
                    "sets": len(of),
                    "first right": sum(map(first, of)),
                    "in the set": sum(row["truth"] in row["models"] for row in of),
                    "calls per event": f"{median(calls):.0f} (at most {max(calls):.0f})",
                    "seconds": f"{median(row['seconds'] for row in of):.0f}",
                }
            )
    return pd.DataFrame(lines)


def alarms(rows: list[Row]) -> pd.DataFrame:
    """False alarms where nothing is hidden, with the exact 95 % interval."""
    lines = []
    for data in sorted({row["data"] for row in rows}):
        of = [row for row in rows if row["data"] == data]
        wrong = sum(row["p_value"] < ALPHA for row in of)
        interval = binomtest(wrong, len(of)).proportion_ci()
        calls = [row["calls_per_event"] for row in of]
        lines.append(
            {
                "nothing hidden": data,
                "alarms": f"{wrong} of {len(of)} ({100 * interval.low:.0f} to {100 * interval.high:.0f} %)",
                "calls per event": f"{median(calls):.0f} (at most {max(calls):.0f})",
            }
        )
    return pd.DataFrame(lines)


@click.command()
def main() -> None:
    """Print both tables."""
    click.echo(table(rows_of(FORMER), rows_of(BANK)).to_string(index=False))
    click.echo()
    click.echo(alarms(rows_of(NOTHING)).to_string(index=False))


if __name__ == "__main__":
    main()
