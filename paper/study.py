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
from paper.studies import agreement, baseline, contamination, detector, misspecification, real
from paper.tables.real import format_table

STUDIES = {
    "agreement": "how often a fit is doubted, where its simulator is right and where it is not",
    "baseline": "the variance of the proposal's gradient with each baseline (Section 3.2)",
    "contamination": "squared errors against the share of outliers among the observed events",
    "detector": "the detector's average response at two offsets (Section 4.2)",
    "misspecification": "the width of avo's proposal on events with a hidden effect, and what the diagnosis says",
    "real": "what the diagnosis says of the measured events in examples/real, with five seeds from --seed on",
}
"""The studies that are no cells."""
STUDIED = {
    "agreement": agreement,
    "baseline": baseline,
    "contamination": contamination,
    "detector": detector,
    "misspecification": misspecification,
}
"""The modules of those that make one file of records."""
NAMES = {name: experiment.says for name, experiment in EXPERIMENTS.items()} | STUDIES


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
            STUDIED[name].made(path := store.path / STUDIED[name].FILE, seed)
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
