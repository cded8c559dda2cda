"""The command `avobench`. Exit code 0 when all was done, 1 for failed work, 2 for wrong usage, 130 after Ctrl-C."""

import signal
import sys
from pathlib import Path

import click
import joblib
from rich.console import Console

from avobench.bench import conformance as check
from avobench.bench import registry
from avobench.bench.backends.dask import DaskBackend
from avobench.bench.backends.local import LocalBackend
from avobench.bench.backends.together import TogetherBackend
from avobench.bench.cell import Cell
from avobench.bench.plan import on_device, plan
from avobench.bench.record import Status, reason
from avobench.bench.runner import Sweep, run
from avobench.bench.store import Store, to_frame
from avobench.cli import listing
from avobench.cli.challenge import challenge
from avobench.cli.diagnose import diagnose
from avobench.cli.options import RESULTS, require_folder, write_file
from avobench.cli.progress import ProgressView
from avobench.cli.reports import COMMANDS
from avobench.reports.figures import draw
from avobench.tasks.errors import AvobenchError, UsageError


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="avobench")
@click.option("--debug", is_flag=True, help="Show tracebacks; may stand anywhere.")
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Benchmark adversarial variational optimization against ABC-SMC and BOLFI under one simulation budget."""
    context.obj = debug


@cli.command("list")
def list_() -> None:
    """Show the tasks and methods, with their settings."""
    click.echo(listing.tasks_and_methods())


@cli.command("run")
@click.option("--task", "tasks", multiple=True, metavar="NAME", help="Task, or module:Class; repeatable.  [all]")
@click.option("--method", "methods", multiple=True, metavar="NAME", help="Method, or module:Class; repeatable.  [all]")
@click.option("--targets", default="0-14", show_default=True, help="Indices and ranges, such as 0,3,7-9.")
@click.option("--budget", type=int, default=160_000, show_default=True, help="Simulated events a cell may use.")
@click.option("--observations", type=int, default=100_000, show_default=True, help="Observed events of each target.")
@click.option("--repetitions", type=int, default=1, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True, help="Root of all random streams.")
@click.option("--jobs", "-j", type=int, default=None, help="Worker processes.  [one a core]")
@click.option(
    "--backend",
    type=click.Choice(["local", "together", "dask"]),
    default=None,
    help="Processes, all cells of a task at once where a method gains, or a cluster.  [local; together with cuda]",
)
@click.option("--group", type=int, default=None, metavar="N", help="Most cells at once with together.  [all]")
@click.option("--scheduler", default=None, metavar="ADDRESS", help="Of Dask, such as tcp://10.0.0.1:8786.")
@click.option("--device", type=click.Choice(["cpu", "cuda"]), default="cpu", show_default=True, help="Of the networks.")
@RESULTS
@click.option("--set", "settings", multiple=True, metavar="METHOD.PARAM=VALUE", help="A setting of a method or task.")
@click.option("--retry-failed", is_flag=True, help="Make cells again whose status is not ok.")
@click.option("--figure", type=click.Path(path_type=Path), default=None, metavar="DIR", help="Redraw box plots there.")
@click.pass_obj
def run_(
    debug: bool,
    tasks: tuple[str, ...],
    methods: tuple[str, ...],
    targets: str,
    budget: int,
    observations: int,
    repetitions: int,
    seed: int,
    jobs: int | None,
    backend: str | None,
    group: int | None,
    scheduler: str | None,
    device: str,
    results: Path,
    settings: tuple[str, ...],
    retry_failed: bool,
    figure: Path | None,
) -> None:
    """Carry out the cells that the results folder lacks: task x method x target x repetition.

    What is finished is kept at once; after Ctrl-C, or worse, the same command goes on from there.
    """
    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs must be at least 1, got {jobs}")
    backend = backend or ("together" if device == "cuda" else "local")
    if (backend == "dask") != (scheduler is not None):
        raise UsageError("--backend dask and --scheduler ADDRESS belong together")
    if backend == "dask" and jobs is not None:
        raise UsageError("--jobs is for --backend local; a Dask cluster has the workers that it has")
    if group is not None and (backend != "together" or group < 1):
        raise UsageError(f"--group is for --backend together, at least 1; got {group} with --backend {backend}")
    tasks, methods = list(tasks) or registry.names("task"), list(methods) or registry.names("method")
    if device != "cpu":
        settings += on_device(methods, device)
    cells = plan(tasks, methods, targets, repetitions, budget, observations, seed, list(settings))
    if figure is not None:
        require_folder(figure)
    store = Store(results, create=True)

    def redraw(sweep: Sweep, cell: Cell) -> None:
        """After the last cell of a target in a repetition, and after the last of all."""
        same = (cell.target, cell.repetition)
        if figure is not None and all((other.target, other.repetition) != same for other in sweep.pending):
            draw("benchmark", list(sweep.done.values()), figure)

    jobs = jobs or joblib.cpu_count()
    if scheduler is not None:
        where = DaskBackend(scheduler, debug=debug)
    elif backend == "together":
        where = TogetherBackend(jobs, store.running, group, debug=debug)
    else:
        where = LocalBackend(jobs, store.running, debug=debug)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with ProgressView(Console(stderr=True), redraw) as view:
        records = run(cells, store, where, view, retry_failed=retry_failed)
    if figure is not None:
        draw("benchmark", records, figure)
    click.echo(listing.status_table(records))
    failed = [record for record in records if record["status"] != Status.OK]
    click.echo(f"{len(records) - len(failed)} of {len(records)} cells ok, records in {results}")
    if failed:
        sys.exit(1)


@cli.command()
@RESULTS
@click.option("--targets", is_flag=True, help="Show instead whether avo is where it should be, beside the others.")
def status(results: Path, targets: bool) -> None:
    """Summarise the records of a results folder, and name failed cells and damaged files."""
    store = Store(results)
    if targets:
        from avobench.reports.targets import format_table  # here, because it takes a second to load

        click.echo(format_table(store.read_all()))
        return
    records, damaged = store.read()
    if not records and not damaged:
        store.read_all()
    if records:
        click.echo(listing.status_table(records))
    for record in records:
        if record["status"] != Status.OK:
            cell = "{task} {method} target {target} repetition {repetition}".format(**record)
            click.echo(f"{cell}: {reason(record)}")
    for path, fault in damaged.items():
        click.echo(f"{path} {fault}; `avobench run` sets it aside and makes it again, or delete it", err=True)
    if damaged:
        sys.exit(1)


@cli.command()
@click.option("--format", "kind", type=click.Choice(["csv", "parquet"]), required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="File to write.")
@RESULTS
def export(kind: str, out: Path, results: Path) -> None:
    """Write all records as one table, a row a cell."""
    require_folder(out.parent, make=False)
    if out.is_dir():
        raise UsageError(f"{out} is a folder; --out takes the file to write")
    frame = to_frame(Store(results).read_all())
    content = frame.to_csv(index=False).encode() if kind == "csv" else frame.to_parquet(index=False)
    write_file(out, content)
    click.echo(f"{len(frame)} rows in {out}")


@cli.command("check")
@click.argument("kind", type=click.Choice(["task", "method", "effect"]))
@click.argument("name")
def check_(kind: str, name: str) -> None:
    """Tell whether a task, method or effect keeps its contract; NAME is registered or module:Class."""
    passed = True
    for result in check.run(kind, name):
        passed &= result.passed
        click.echo(f"{'pass' if result.passed else 'FAIL'}  {result.what}" + (f": {result.why}" if result.why else ""))
    if not passed:
        raise AvobenchError(f"{kind} {name} does not keep the contract")


for command in (*COMMANDS, diagnose, challenge):
    cli.add_command(command)


def main() -> None:
    """Run the command line; whatever goes wrong is one line on standard error."""
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    debug = len(arguments) < len(sys.argv) - 1
    try:
        sys.exit(cli.main(["--debug"] * debug + arguments, standalone_mode=False))
    except (KeyboardInterrupt, click.Abort):
        click.echo("avobench: stopped; what was finished is kept, and the same command goes on from there", err=True)
        sys.exit(130)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help())
        sys.exit(2)
    except Exception as error:
        if debug:
            raise
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
        if not isinstance(error, (click.ClickException, AvobenchError)):
            message = f"{type(error).__name__}: {message} (a fault of avobench; --debug shows where)"
        click.echo(f"avobench: {' '.join(message.split())}", err=True)
        sys.exit(2 if isinstance(error, (UsageError, click.UsageError)) else 1)
