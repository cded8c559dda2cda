"""`avobench run`: a sweep, with its progress."""

import signal
import sys
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from avobench.api import sweep
from avobench.bench.cells.cell import Cell
from avobench.bench.plugins.registry import trusted
from avobench.bench.processes.calls import kept
from avobench.bench.store.files import require_folder
from avobench.bench.store.status import Status
from avobench.bench.sweep.runner import Sweep
from avobench.cli import listing
from avobench.cli.isolated import State
from avobench.cli.options import MEMORY_LIMIT, PATH, RESULTS, SETTINGS, TIME_LIMIT, TRUST, workers_of
from avobench.cli.progress import ProgressView
from avobench.cli.terminal import say
from avobench.reports.figures import draw


@click.command()
@click.option(
    "--task",
    "tasks",
    multiple=True,
    metavar="NAME",
    help="Task by name, or module:Class. Repeatable.  [those of the paper]",
)
@click.option(
    "--method", "methods", multiple=True, metavar="NAME", help="Method by name, or module:Class. Repeatable.  [all]"
)
@click.option("--targets", default="0-14", help="Targets by indices and ranges, such as 0,3,7-9.")
@click.option("--budget", type=int, default=160_000, help="Simulated events that each cell may use.")
@click.option("--observations", type=int, default=100_000, help="Observed events of each target.")
@click.option("--repetitions", type=int, default=1, help="Repetitions of each target.")
@click.option("--seed", type=int, default=0, help="Seed of all random numbers.")
@click.option("--jobs", "-j", type=int, help="Worker processes.  [one per core]")
@click.option(
    "--backend",
    type=click.Choice(["local", "together", "dask"]),
    help="local: each cell in a worker process. together: all cells of a task at once, where the method supports it. "
    "dask: a cluster.  [local; together with --device cuda]",
)
@click.option("--group", type=int, metavar="N", help="With --backend together, most cells at once.  [all]")
@click.option("--scheduler", metavar="ADDRESS", help="Address of the Dask scheduler, such as tcp://10.0.0.1:8786.")
@click.option("--device", type=click.Choice(["cpu", "cuda"]), default="cpu", help="Device of the networks.")
@RESULTS
@SETTINGS
@TIME_LIMIT
@MEMORY_LIMIT
@TRUST
@click.option("--retry-failed", is_flag=True, help="Run cells again whose status is not ok.")
@click.option(
    "--figure", type=PATH, metavar="DIR", help="Folder for box plots, which are drawn again after each target."
)
@click.pass_obj
def run(
    state: State,
    tasks: tuple[str, ...],
    trust: bool,
    results: Path,
    retry_failed: bool,
    figure: Path | None,
    **asked: Any,
) -> None:
    """Run the cells that are missing from the results folder.

    A cell is one inference: one task, method, target and repetition. Its record is written as soon as it ends. After
    Ctrl-C or a crash, the same command continues with the missing cells.
    """
    asked["backend"] = asked["backend"] or ("together" if asked["device"] == "cuda" else "local")
    workers = workers_of(asked, state)
    state.resumes = True

    def redraw(now: Sweep, cell: Cell) -> None:
        """After the last cell of a target in a repetition, and after the last of all."""
        same = (cell.target, cell.repetition)
        if figure is not None and all((other.target, other.repetition) != same for other in now.pending):
            draw("benchmark", list(now.done.values()), figure)

    with kept():
        cells = sweep.asked(tuple(trusted(task, trust) for task in tasks), in_process=state.in_process, **asked)
        if figure is not None:
            require_folder(figure)

        signal.signal(signal.SIGTERM, signal.default_int_handler)
        with ProgressView(Console(stderr=True), redraw) as view:
            options = {"retry_failed": retry_failed, "view": view, "debug": state.debug}
            records = sweep.carried_out(cells, results, workers, **options)
    if figure is not None:
        draw("benchmark", records, figure)
    say(listing.status_table(records))
    failed = [record for record in records if record["status"] != Status.OK]
    say(f"{len(records) - len(failed)} of {len(records)} cells ok, records in {results}")
    if failed:
        sys.exit(1)
