"""`python -m paper.tables NAME [FOLDER...]` prints a table of the documentation from committed records."""

from pathlib import Path

import click

from avobench.bench.store.store import Store
from avobench.cli.main import main
from paper.tables import targets

TABLES = {"targets": (targets.format_table, ("results/reference",))}
"""What prints a table from records, and the folders of these unless others are named."""


@click.command()
@click.argument("name", type=click.Choice(list(TABLES)))
@click.argument("folders", nargs=-1, type=click.Path(path_type=Path), metavar="[FOLDER]...")
def table(name: str, folders: tuple[Path, ...]) -> None:
    """Print a table from the records in results folders, by default those that are committed."""
    format_table, usual = TABLES[name]
    click.echo(format_table([record for folder in folders or usual for record in Store(Path(folder)).read_all()]))


if __name__ == "__main__":
    main(table)
