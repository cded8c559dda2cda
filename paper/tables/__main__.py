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
from paper.studies import misspecification as misspecification_study
from paper.studies.files import StudyFile
from paper.tables import experiments, targets

TABLES: dict[str, tuple[Callable[[list[dict[str, Any]]], pd.DataFrame], str | StudyFile]] = {
    "ablation": (experiments.ablation, "reference dimension ablation"),
    "contamination": (contamination.compared, contamination_study.FILE),
    "contamination-pulls": (partial(contamination.compared, value="worst pull"), contamination_study.FILE),
    "contamination-effects": (contamination.effects, contamination_study.FILE),
    "contamination-outliers": (contamination.outliers, contamination_study.FILE),
    "agreement": (agreement.table, agreement.FILE),
    "coverage": (experiments.coverage, "reference rivals smm"),
    "dimension": (dimension.table, "dimension"),
    "few": (few.table, few.FILE),
    "textbook": (textbook.table, textbook.FILE),
    "fresh": (experiments.fresh, "fresh"),
    "growth": (experiments.growth, "growth"),
    "hard": (hard.table, hard.FILE),
    "misspecification": (misspecification.table, misspecification_study.FILE),
    "rivals": (experiments.rivals, "reference rivals smm plain"),
    "saturation": (saturation.table, saturation.FILE),
    "sensitivity": (experiments.sensitivity, "sensitivity"),
    "targets": (targets.table, "reference"),
    "tuning": (experiments.tuning, "tuning"),
}
"""What makes each table, and of what: the record that is a file of its own, in results/studies, or all records of these
folders in results, unless others are named."""


def printed(name: str, folders: tuple[Path, ...] = ()) -> str:
    """A table of TABLES, to be read. Raises UsageError or StoreError where its records are missing."""
    make, of = TABLES[name]
    if isinstance(of, StudyFile):
        frame = make([of.read(folders[0] if folders else Path("results/studies"))])
    else:
        usual = [Path("results") / folder for folder in of.split()]
        frame = make(list(records_of(folders or usual).values()))
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
