"""The commands `study`, `figure` and `report`, which `avobench` attaches."""

from pathlib import Path

import click
import joblib
from rich.console import Console

from avobench.bench.backends.local import LocalBackend
from avobench.bench.record import Status, reason
from avobench.bench.runner import run
from avobench.bench.store import Store
from avobench.cli import listing
from avobench.cli.options import RESULTS, require_folder, write_file
from avobench.cli.progress import ProgressView
from avobench.reports.figures import FIGURES, STUDY_FIGURES, draw, records_for
from avobench.studies import paper as study
from avobench.tasks.errors import AvobenchError, UsageError

OUT = click.option("--out", type=click.Path(path_type=Path), default=Path("reports"), show_default=True, help="Folder.")
STUDIES = ("poisson", "alignment", "detector", "summary", "ablation")


@click.command("study")
@click.argument("name", type=click.Choice(STUDIES))
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=None,
    help="Folder of the records.  [results/studies, results/ablation for ablation]",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Root of all random streams.")
@click.option("--jobs", "-j", type=int, default=None, help="Worker processes.  [one a core]")
@click.pass_obj
def study_(debug: bool, name: str, results: Path | None, seed: int, jobs: int | None) -> None:
    """Carry out one of the paper's single experiments, as far as the results folder lacks it.

    poisson and alignment are runs of avo-paper (Sections 4.1 and 4.2), detector is the average response at two offsets,
    summary runs abc-smc and bolfi on alignment with a better summary statistic, ablation runs avo with what sets it
    apart from avo-paper undone, one difference at a time.
    """
    jobs = joblib.cpu_count() if jobs is None else jobs
    if jobs < 1:
        raise UsageError(f"--jobs must be at least 1, got {jobs}")
    if not 0 <= seed < 2**63:
        raise UsageError(f"--seed must lie between 0 and 2^63 - 1, got {seed}")
    store = Store(results or Path("results/ablation" if name == "ablation" else "results/studies"), create=True)
    if name == "detector":
        with store.lock():
            study.detector(store.path / study.DETECTOR_FILE, seed)
        click.echo(f"{len(study.DETECTOR_THETA)} average responses in {store.path / study.DETECTOR_FILE}")
        return
    with ProgressView(Console(stderr=True), lambda sweep, cell: None) as view:
        records = run(study.cells(name, seed), store, LocalBackend(jobs, store.running, debug=debug), view)
    click.echo(listing.status_table(records))
    failed = [record for record in records if record["status"] != Status.OK]
    if failed:
        raise AvobenchError(f"{len(failed)} of {len(records)} cells failed, the first with {reason(failed[0])}")


@click.command("figure")
@click.argument("names", nargs=-1, required=True, type=click.Choice(FIGURES), metavar=f"{{{'|'.join(FIGURES)}}}...")
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=None,
    help="Folder of the records.  [results/local, and results/studies for poisson, alignment and detector]",
)
@OUT
def figure(names: tuple[str, ...], results: Path | None, out: Path) -> None:
    """Draw figures from records: each as .pdf, .png and, with the numbers drawn, .csv."""
    require_folder(out)
    for name in names:
        store = Store(results or Path("results/studies" if name in STUDY_FIGURES else "results/local"))
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


COMMANDS = (study_, figure, report)
