"""`python -m paper.tables NAME [FOLDER...]` prints a table of the documentation from committed records."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click
import pandas as pd

from avobench.cli.main import main
from paper.experiments import records_of
from paper.figures import contamination, dimension, misspecification
from paper.studies import agreement, few, hard, saturation, textbook
from paper.studies import contamination as contamination_study
from paper.studies.misspecification import read
from paper.tables import coverage, experiments, targets

TABLES: dict[str, tuple[Callable[[list[dict[str, Any]]], pd.DataFrame], str]] = {
    "ablation": (experiments.ablation, "reference dimension ablation"),
    "contamination": (contamination.compared, "studies"),
    "contamination-pulls": (partial(contamination.compared, value="worst pull"), "studies"),
    "contamination-effects": (contamination.effects, "studies"),
    "contamination-outliers": (contamination.outliers, "studies"),
    "agreement": (agreement.table, "studies"),
    "coverage": (coverage.table, "reference rivals smm"),
    "dimension": (dimension.table, "dimension"),
    "few": (few.table, "studies"),
    "textbook": (textbook.table, "studies"),
    "fresh": (experiments.fresh, "fresh"),
    "growth": (experiments.growth, "growth"),
    "hard": (hard.table, "studies"),
    "misspecification": (misspecification.table, "studies"),
    "rivals": (experiments.rivals, "reference rivals smm plain"),
    "saturation": (saturation.table, "studies"),
    "sensitivity": (experiments.sensitivity, "sensitivity"),
    "targets": (targets.table, "reference"),
    "tuning": (experiments.tuning, "tuning"),
}
"""What makes each table, and the folders in results of which it is made unless others are named."""
ONE_FILE = {
    "agreement": agreement.read,
    **dict.fromkeys(
        ("contamination", "contamination-pulls", "contamination-effects", "contamination-outliers"),
        contamination_study.read,
    ),
    "hard": hard.read,
    "few": few.read,
    "textbook": textbook.read,
    "misspecification": read,
    "saturation": saturation.read,
}
"""The tables of a record that is a file of its own, with what reads it."""


def printed(name: str, folders: tuple[Path, ...] = ()) -> str:
    """A table of TABLES, to be read. Raises UsageError or StoreError where its records are missing."""
    make, usual = TABLES[name]
    chosen = folders or tuple(Path("results") / folder for folder in usual.split())
    kept = [ONE_FILE[name](chosen[0])] if name in ONE_FILE else list(records_of(chosen).values())
    frame = make(kept)
    named = not isinstance(frame.index, pd.RangeIndex)
    return frame.to_string(index=named, na_rep="-", float_format=lambda value: f"{value:.3g}")


@click.command()
@click.argument("name", type=click.Choice(list(TABLES)))
@click.argument("folders", nargs=-1, type=click.Path(path_type=Path), metavar="[FOLDER]...")
def table(name: str, folders: tuple[Path, ...]) -> None:
    """Print a table from the records in results folders, by default those that are committed."""
    click.echo(printed(name, folders))


if __name__ == "__main__":
    main(table)
