"""`avobench diagnose`: from a file of measured events to what the simulator lacks."""

from pathlib import Path
from typing import Any

import click

from avobench.api.diagnosis import diagnose as diagnose_events
from avobench.api.progress import shown
from avobench.bench.events import read_events, read_timed
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.cli.isolated import Isolated
from avobench.cli.measured import read_joint, tables_of
from avobench.cli.options import COLUMNS, DROP_INVALID, JOINT, SECONDS, SEED, TRUST, listed, require_alone
from avobench.cli.terminal import say
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.missing import missing_in_both
from avobench.tasks.sample import bank


@click.command(cls=Isolated)
@click.option("--task", "spec", default=None, metavar="NAME", help="Task, file.py:Class, or a model.json.")
@click.option("--simulated", default=None, metavar="FILE", help="Simulated events, in place of a task.")
@click.option("--theta-columns", metavar="A,B,...", callback=listed, help="Columns of --simulated that are parameters.")
@click.option("--weights", default=None, metavar="COLUMN", help="Column of --simulated with weights.")
@click.option("--data", default=None, metavar="FILE", help="File of measured events. For ROOT, file.root:tree.")
@click.option(
    "--table",
    "tables",
    multiple=True,
    metavar="FILE[:NAME]",
    help="Published table or histogram, in place of --data. Repeatable; --columns names the feature of each.",
)
@click.option("--density", is_flag=True, help="Values of --table are divided by the widths of their bins.")
@click.option("--normalised", is_flag=True, help="Only the shape of each --table is compared, as always of counts.")
@JOINT
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results.")
@COLUMNS
@DROP_INVALID
@TRUST
@SECONDS
@SEED
@click.option("--alpha", type=float, default=0.05, show_default=True, help="Upper bound on the rate of false alarms.")
@click.option(
    "--max-effects", type=click.IntRange(0), default=3, show_default=True, help="Largest number of effects to add."
)
@click.option(
    "--simulations", type=click.IntRange(1), default=None, help="Limit on simulated events.  [as many as needed]"
)
@click.option(
    "--ordered", is_flag=True, help="Also test the order of the rows: drift, change points, seasons, clustering."
)
@click.option(
    "--time", default=None, metavar="COLUMN", help="Also test the order along this column, which is then not a feature."
)
@click.option(
    "--fit",
    default="surrogate",
    show_default=True,
    metavar="NAME",
    help="Method that fits theta first. The diagnosis's own fit is named surrogate.",
)
@click.option(
    "--effects", metavar="A,B,...", callback=listed, help="Effects of the catalogue to try.  [all that apply]"
)
@click.option(
    "--effect",
    "own",
    multiple=True,
    metavar="EFFECT",
    help="Your own effect to try as well, module:Class or file.py:Class. Repeatable.",
)
@click.option("--bank", type=click.Path(path_type=Path), default=None, help="Folder that keeps simulated events.")
@click.option("--jobs", "-j", type=click.IntRange(1), default=1, show_default=True, help="Worker processes.")
def diagnose(
    spec: str | None,
    simulated: str | None,
    theta_columns: list[str] | None,
    weights: str | None,
    data: str | None,
    tables: tuple[str, ...],
    density: bool,
    normalised: bool,
    sets: str | None,
    out: Path,
    columns: list[str] | None,
    trust: bool,
    time: str | None,
    **asked: Any,
) -> None:
    """Test whether a simulator describes measured events, and find the effect that it lacks.

    The folder then holds report.html (a page with figures), diagnosis.json (every number), and model.json (the
    simulator with the effect, which every command accepts as a task). If the disagreement remains, correction.npz
    holds weights that make simulated events look like the measured ones.
    """
    if sets is not None:
        given = {"task": spec, "simulated": simulated, "data": data, "table": tables, "columns": columns, "time": time}
        require_alone(given | {"density": density, "normalised": normalised})
        _carry_out(read_joint(sets, trust), None, out, Path(sets).name, **asked)
        return
    if (spec is None) == (simulated is None):
        raise UsageError("give a simulator by --task, or events that it made by --simulated: one of the two")
    if (theta_columns or weights) and simulated is None:
        raise UsageError("--theta-columns and --weights are columns of --simulated, which is not given")
    if (data is None) == (not tables):
        raise UsageError("give measured events by --data, or published tables by --table: one of the two")
    if (density or normalised) and not tables:
        raise UsageError("--density and --normalised are of --table, which is not given")
    if time is not None and tables:
        raise UsageError("--time is a column of --data, which is not given")
    if spec is not None:
        # What is wrong with the request is said before a folder is made.
        registry.load("task", registry.trusted(spec, trust))
    x: Any
    if data is not None:
        x, when = read_timed(data, columns, time)
    else:
        x, when = tables_of(tables, columns, density=density, normalised=normalised), None
    task: Task | str
    if simulated is not None:
        task = _sample(simulated, None if tables else columns, theta_columns, weights, x)
    else:
        task = registry.trusted(spec or "", trust)
    measured = ", ".join(Path(name).name for name in ([data] if data else tables))
    title = f"{measured} against {spec or Path(simulated or '').name}"
    _carry_out(task, x, out, title, time=when, **asked)


def _carry_out(task: Any, x: Any, out: Path, title: str, **asked: Any) -> None:
    """Diagnose, write the folder, and print what was found."""
    require_folder(out)
    with shown(None, plain=True) as progress:
        found = diagnose_events(task, x, progress=progress, **asked)
    found.save(out, title)
    say(found.details())


def _sample(file: str, columns: list[str] | None, theta: list[str] | None, weights: str | None, x: Any) -> Task:
    """A task of the events in a file; what holds NaN there and in events x may be missing. Raises UsageError."""
    beside = [*(theta or []), *([weights] if weights else [])]
    events = read_events(file, [*columns, *beside] if columns else None)
    if beside and not hasattr(events, "columns"):
        raise UsageError(f"{file} has no columns with names, by which theta or weights could be chosen")
    missing = [] if isinstance(x, list) else missing_in_both(events, x)
    return bank(events, theta=theta, weights=weights, missing=missing)
