"""`avobench figure` and `avobench report`: pictures and a page of records."""

from pathlib import Path

import click

from avobench.bench.store.files import require_folder, write_file
from avobench.bench.store.store import Store
from avobench.cli.options import RESULTS
from avobench.reports.figures import FIGURES, FOLDERS, draw, records_for

OUT = click.option("--out", type=click.Path(path_type=Path), default=Path("reports"), show_default=True, help="Folder.")


@click.command("figure")
@click.argument("names", nargs=-1, required=True, type=click.Choice(FIGURES), metavar=f"{{{'|'.join(FIGURES)}}}...")
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=None,
    help="Folder of the records.  [results/local; the study's own for what a study has made]",
)
@OUT
def figure(names: tuple[str, ...], results: Path | None, out: Path) -> None:
    """Draw figures from records: each as .pdf, .png and, with the numbers drawn, .csv."""
    require_folder(out)
    for name in names:
        store = Store(results or FOLDERS.get(name, Path("results/local")))
        for path in draw(name, records_for(name, store), out):
            click.echo(path)


@click.command("report")
@RESULTS
@click.option(
    "--studies",
    type=click.Path(path_type=Path),
    default=None,
    help="Folder of the studies, for the paper's figures and claims.  [results/studies where there is one]",
)
@OUT
def report(results: Path, studies: Path | None, out: Path) -> None:
    """Write one page with everything, index.html: it needs no network and no other file."""
    from avobench.reports.page import render  # here, because it takes seconds to load

    require_folder(out)
    default = Path("results/studies")
    page = render(results, default if studies is None and default.exists() else studies)
    write_file(out / "index.html", page.encode())
    click.echo(out / "index.html")
