"""`python -m paper.figures NAME...` draws the paper's own figures from the records of its studies."""

import importlib
from pathlib import Path

import click
import matplotlib

from avobench.bench.store.files import require_folder
from avobench.bench.store.store import Store
from avobench.cli.main import main
from avobench.cli.reports import OUT
from avobench.reports.style import STYLE, save
from paper.studies import contamination, detector, misspecification

FOLDERS = {"weinberg": Path("results/reference"), "dimension": Path("results/dimension")}
FOLDERS |= dict.fromkeys(
    ("poisson", "alignment", "contamination", "detector", "misspecification"), Path("results/studies")
)
"""The figures, and where the records of each are unless another folder is named."""
ONE_FILE = {"contamination": contamination.FILE, "detector": detector.FILE, "misspecification": misspecification.FILE}
"""The figures that are drawn from a file of their own."""


def draw(name: str, results: Path | None, out: Path) -> list[Path]:
    """Draw one figure of FOLDERS. Raises StoreError where its records are missing."""
    folder = results or FOLDERS[name]
    records = [ONE_FILE[name].read(folder)] if name in ONE_FILE else Store(folder).read_all()
    with matplotlib.rc_context(STYLE):
        return save(*importlib.import_module(f"paper.figures.{name}").drawn(records), out, name)


@click.command()
@click.argument("names", nargs=-1, required=True, type=click.Choice(list(FOLDERS)), metavar="NAME...")
@click.option("--results", type=click.Path(path_type=Path), default=None, help="Folder of the records.  [the study's]")
@OUT
def figures(names: tuple[str, ...], results: Path | None, out: Path) -> None:
    """Draw figures of the paper: each as .pdf, .png and, with the numbers drawn, .csv."""
    require_folder(out)
    for name in names:
        for path in draw(name, results, out):
            click.echo(path)


if __name__ == "__main__":
    main(figures)
