"""`avobench figure` and `avobench report`: pictures and a page of records."""

from pathlib import Path

import click

from avobench.bench.store.files import require_folder, write_file
from avobench.bench.store.store import Store
from avobench.cli.options import PATH, RESULTS
from avobench.cli.terminal import say
from avobench.reports.figures import FIGURES, TRACED, draw

OUT = click.option("--out", type=PATH, default=Path("reports"), help="Folder to write to.")


@click.command("figure")
@click.argument("names", nargs=-1, required=True, type=click.Choice(FIGURES), metavar=f"{{{'|'.join(FIGURES)}}}...")
@RESULTS
@OUT
def figure(names: tuple[str, ...], results: Path, out: Path) -> None:
    """Draw figures from records. Each is written as .pdf and .png, and its numbers as .csv."""
    require_folder(out)
    store = Store(results)
    for name in names:
        for path in draw(name, store.read_all(traces=name in TRACED), out):
            say(path)


@click.command("report")
@RESULTS
@OUT
def report(results: Path, out: Path) -> None:
    """Write all results as one page, index.html, which needs no network and no other file."""
    from avobench.reports.page import render  # here, because it takes seconds to load

    require_folder(out)
    write_file(out / "index.html", render(results).encode())
    say(out / "index.html")
