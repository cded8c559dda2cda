"""What a diagnosis of the development data in `results/bank` costs and finds: `python -m paper.tables.bank`."""

from statistics import median
from typing import Any

import click
import pandas as pd

from paper.studies.bank import FOLDER
from paper.studies.files import read_lines
from paper.tables.decide import share

Row = dict[str, Any]
FILES = ("hidden-4c8d801", "hidden-bank", "nothing-bank")
"""With the search before, with that of now, and where nothing is hidden."""
ALPHA = 0.05


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
        calls = [row["calls_per_event"] for row in of]
        lines.append(
            {
                "nothing hidden": data,
                "alarms": share([row["p_value"] < ALPHA for row in of]),
                "calls per event": f"{median(calls):.0f} (at most {max(calls):.0f})",
            }
        )
    return pd.DataFrame(lines)


@click.command()
def main() -> None:
    """Print both tables."""
    former, bank, nothing = (read_lines(FOLDER / f"{name}.jsonl") for name in FILES)
    click.echo(table(former, bank).to_string(index=False))
    click.echo()
    click.echo(alarms(nothing).to_string(index=False))


if __name__ == "__main__":
    main()
