"""`python -m paper.study NAME` carries out an experiment of the grid, or one of the studies that are no cells."""

from pathlib import Path

import click
from rich.console import Console

from avobench.bench.processes.workers import Workers
from avobench.bench.store.files import require_folder
from avobench.bench.store.status import ESTIMATED, reason
from avobench.bench.store.store import Store
from avobench.bench.sweep.runner import run
from avobench.cli import listing
from avobench.cli.main import main
from avobench.cli.progress import ProgressView
from avobench.cli.state import State
from avobench.tasks.errors import AvobenchError, UsageError
from paper.experiments import EXPERIMENTS
from paper.studies import (
    agreement,
    baseline,
    contamination,
    detector,
    few,
    hard,
    misspecification,
    real,
    saturation,
    textbook,
)
from paper.tables.real import format_table

STUDIES = {
    each.__name__.rpartition(".")[2]: each
    for each in (agreement, baseline, contamination, detector, few, hard, misspecification, real, saturation, textbook)
}
"""The modules of the studies that are no cells. Each but `real` makes one file of records."""
NAMES = {name: experiment.says for name, experiment in EXPERIMENTS.items()}
NAMES |= {name: module.__doc__.splitlines()[0] for name, module in STUDIES.items()}


@click.command(epilog="\b\n" + "\n".join(f"{name}: {says}" for name, says in NAMES.items()))
@click.argument("name", type=click.Choice(list(NAMES)), metavar="NAME")
@click.option("--results", type=click.Path(path_type=Path), default=None, help="Folder of the records.  [its own]")
@click.option("--seed", type=int, default=0, show_default=True, help="Root of all random streams.")
@click.option("--jobs", "-j", type=int, default=None, help="Worker processes.  [one a core]")
@click.pass_obj
def study(state: State, name: str, results: Path | None, seed: int, jobs: int | None) -> None:
    """Carry out an experiment of the paper, or one beyond it, as far as the results folder lacks it."""
    workers = Workers(jobs, in_process=state.in_process)
    state.resumes = True
    if not 0 <= seed < 2**63:
        raise UsageError(f"--seed must lie between 0 and 2^63 - 1, got {seed}")
    if name == "real":
        require_folder(folder := results or real.FOLDER)
        click.echo(format_table(real.with_seeds(folder, seed, jobs or 1)))
        return
    if name in STUDIES:
        store = Store(results or Path("results/studies"), create=True)
        with store.lock():
            STUDIES[name].made(path := store.path / STUDIES[name].FILE.name, seed)
        click.echo(path)
        return
    experiment = EXPERIMENTS[name]
    store = Store(results or experiment.folder, create=True)
    with ProgressView(Console(stderr=True), lambda sweep, cell: None) as view:
        records = run(experiment.cells(seed), store, workers.begin(store.running, debug=state.debug), view)
    click.echo(listing.status_table(records))
    failed = [record for record in records if record["status"] not in ESTIMATED]
    if failed:
        raise AvobenchError(f"{len(failed)} of {len(records)} cells failed, the first with {reason(failed[0])}")


if __name__ == "__main__":
    main(study)
