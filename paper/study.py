"""`python -m paper.study NAME` carries out one of the paper's single experiments, or a study beyond it."""

from pathlib import Path

import click
from rich.console import Console

from avobench.bench.processes.workers import Workers
from avobench.bench.store.files import require_folder
from avobench.bench.store.status import ESTIMATED, reason
from avobench.bench.store.store import Store
from avobench.bench.sweep.runner import run
from avobench.cli import listing
from avobench.cli.isolated import State
from avobench.cli.main import main
from avobench.cli.progress import ProgressView
from avobench.tasks.errors import AvobenchError, UsageError
from paper.studies import dimension, fresh, misspecification, paper, real, sensitivity, tuning
from paper.tables import sensitivity as sensitivity_report
from paper.tables import tuning as tuning_report
from paper.tables.real import format_table as format_real

STUDIES = (
    "poisson",
    "alignment",
    "detector",
    "summary",
    "ablation",
    "tuning",
    "sensitivity",
    "dimension",
    "fresh",
    "misspecification",
    "real",
)
TABLES = {"tuning": tuning_report, "sensitivity": sensitivity_report}
"""Of the studies by which settings are chosen, what prints their table."""
FOLDERS = {name: Path("results") / name for name in ("ablation", "dimension", "fresh", "real")}
FOLDERS |= {name: report.STORE for name, report in TABLES.items()}
"""Of the studies whose records are not in results/studies."""
CELLS = {
    "dimension": dimension.cells,
    "fresh": fresh.cells,
    "tuning": lambda seed: tuning.cells(),
    "sensitivity": lambda seed: sensitivity.cells(),
}
"""Of the studies that are none of the paper's; those of settings have a seed of their own."""


@click.command()
@click.argument("name", type=click.Choice(STUDIES))
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=None,
    help="Folder of the records.  [results/NAME; results/studies for the paper's and misspecification]",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Root of all random streams.")
@click.option("--jobs", "-j", type=int, default=None, help="Worker processes.  [one a core]")
@click.pass_obj
def study(state: State, name: str, results: Path | None, seed: int, jobs: int | None) -> None:
    """Carry out one of the paper's single experiments, as far as the results folder lacks it.

    poisson and alignment are runs of avo-paper (Sections 4.1 and 4.2), detector is the average response at two offsets,
    summary runs abc-smc and bolfi on alignment with a better summary statistic, ablation runs avo with what sets it
    apart from avo-paper undone, one difference at a time; tuning runs abc-smc and bolfi with the candidates for the
    settings of abc-smc-tuned and bolfi-tuned, on targets and with a seed of its own, and sensitivity avo-paper with
    those for avo-plain. dimension runs every method against the number of parameters, fresh runs avo and smm on a
    hundred targets a task that nothing was chosen on.
    misspecification is the width of avo's proposal on events with a hidden effect, and what the diagnosis says of them.
    real is what the diagnosis says of the measured events in examples/real, with five seeds from --seed on.
    """
    workers = Workers(jobs, in_process=state.in_process)
    state.resumes = True
    if not 0 <= seed < 2**63:
        raise UsageError(f"--seed must lie between 0 and 2^63 - 1, got {seed}")
    if name == "real":
        require_folder(folder := results or FOLDERS[name])
        click.echo(format_real(real.with_seeds(folder, seed, jobs or 1)))
        return
    store = Store(results or FOLDERS.get(name, Path("results/studies")), create=True)
    if name == "detector":
        with store.lock():
            paper.detector(store.path / paper.DETECTOR_FILE, seed)
        click.echo(f"{len(paper.DETECTOR_THETA)} average responses in {store.path / paper.DETECTOR_FILE}")
        return
    if name == "misspecification":
        with store.lock():
            record = misspecification.misspecification(store.path / misspecification.FILE, seed)
        click.echo(f"{len(record['runs'])} runs in {store.path / misspecification.FILE}")
        return
    with ProgressView(Console(stderr=True), lambda sweep, cell: None) as view:
        cells = CELLS[name](seed) if name in CELLS else paper.cells(name, seed)
        records = run(cells, store, workers.begin(store.running, debug=state.debug), view)
    click.echo(TABLES[name].format_table(store.path) if name in TABLES else listing.status_table(records))
    failed = [record for record in records if record["status"] not in ESTIMATED]
    if failed:
        raise AvobenchError(f"{len(failed)} of {len(records)} cells failed, the first with {reason(failed[0])}")


if __name__ == "__main__":
    main(study)
