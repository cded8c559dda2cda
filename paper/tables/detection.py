"""How often a right simulator is rejected and a wrong one is seen: `python -m paper.tables.detection`."""

from statistics import median
from typing import Any

import click
import pandas as pd

from paper.studies.detection import FOLDER, LIMITS
from paper.studies.files import read_lines
from paper.tables.decide import share

VERSIONS = ("former", "now")
ALPHA, PLAINLY = 0.05, 0.001
"""The rate of false alarms that is asked for, and a p-value that nobody doubts."""


def line(version: str, limit: int | None, rows: list[dict[str, Any]]) -> dict[str, str]:
    """One row of the table."""
    right, wrong = ([row for row in rows if (row["kind"] == "null") == null] for null in (True, False))
    p, p_wrong = ([row["p_value"] for row in some if "refused" not in row] for some in (right, wrong))
    calls = [[row["calls_per_event"] for row in some if "refused" not in row] for some in (right, wrong)]
    return {
        "version": version,
        "limit": "none" if limit is None else str(limit),
        "calls": " and ".join(f"{median(some):.0f}" for some in calls),
        "right: refused": f"{len(right) - len(p)} of {len(right)}",
        "alarms": share([value < ALPHA for value in p]),
        "p < 0.001": str(sum(value < PLAINLY for value in p)),
        "wrong: refused": f"{len(wrong) - len(p_wrong)} of {len(wrong)}",
        "seen": f"{sum(value < ALPHA for value in p_wrong)} of {len(p_wrong)}",
    }


@click.command()
def main() -> None:
    """Print the table."""
    lines = []
    for version in VERSIONS:
        rows = read_lines(FOLDER / f"{version}.jsonl")
        lines += [line(version, limit, [row for row in rows if row["limit"] == limit]) for limit in LIMITS]
    click.echo(pd.DataFrame(lines).to_string(index=False))


if __name__ == "__main__":
    main()
