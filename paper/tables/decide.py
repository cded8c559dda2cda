"""Whether what is said to decide does: `python -m paper.tables.decide` prints it, from `results/studies`."""

from pathlib import Path
from statistics import median
from typing import Any

import click
import pandas as pd
from scipy.stats import binomtest

from paper.studies.decide import FILE
from paper.studies.files import read_lines

Row = dict[str, Any]


def table(rows: list[Row]) -> pd.DataFrame:
    """A column for each kind of shape, and all."""
    columns = {kind: [row for row in rows if row["kind"] == kind] for kind in ("own", "foreign")}
    return pd.DataFrame({kind: column(of) for kind, of in [*columns.items(), ("all", rows)]})


def column(rows: list[Row]) -> dict[str, str]:
    """Counts over data sets, and over pairs of models of which one is the hidden family."""
    asked = [{**each, "truth": row["truth"], "num_events": row["num_events"]} for row in rows for each in row["asked"]]
    enough = [each for each in asked if each["events"] == 0]
    again = [each for each in asked if "named" in each]
    times = [1 + each["events"] / each["num_events"] for each in again]
    return {
        "data sets": str(len(rows)),
        "pairs with the hidden family": str(len(asked)),
        "no number is known": str(sum(each["events"] is None for each in asked)),
        "enough are measured": str(len(enough)),
        "  the hidden one is first": share([[each["truth"]] == each["true"] for each in enough]),
        "measured anew, with the number that was said": str(len(again)),
        "  times as many events, median": f"{median(times):.1f} (at most {max(times):.0f})" if times else "-",
        "  the hidden one is named": share([[each["truth"]] == each["named"] for each in again]),
        "  it has more evidence": share([[each["truth"]] == each["best"] for each in again]),
        "  it is alone in the 95 % set": share([[[each["truth"]]] == each["models"] for each in again]),
    }


def share(right: list[bool]) -> str:
    """How many, with the exact 95 % interval."""
    if not right:
        return "-"
    low, high = binomtest(sum(right), len(right)).proportion_ci()
    return f"{sum(right)} of {len(right)} ({100 * low:.0f} to {100 * high:.0f} %)"


@click.command()
@click.option("--file", type=click.Path(path_type=Path, exists=True), default=FILE, show_default=True)
def main(file: Path) -> None:
    """Print the table."""
    rows = read_lines(file)
    counted = pd.Series([row["task"] for row in rows]).value_counts()
    click.echo(", ".join(f"{name} {number}" for name, number in counted.items()))
    click.echo()
    click.echo(table(rows).to_string())


if __name__ == "__main__":
    main()
