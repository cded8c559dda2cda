"""`avobench diagnose`: from a file of measured events to what the simulator lacks."""

from pathlib import Path
from typing import Any

import click
from rich.console import Console

from avobench.api.diagnosis import diagnose as diagnose_events
from avobench.bench.events import read_timed
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.cli.isolated import Isolated
from avobench.cli.options import COLUMNS, DATA, DROP_INVALID, SEED, TRUST, named
from avobench.cli.progress import DiagnosisProgress


@click.command(cls=Isolated)
@click.option("--task", "spec", required=True, metavar="NAME", help="Task, file.py:Class, or a model.json.")
@DATA
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results.")
@COLUMNS
@DROP_INVALID
@TRUST
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
@click.option("--effects", default=None, metavar="A,B,...", help="Effects of the catalogue to try.  [all that apply]")
@click.option(
    "--effect",
    "own",
    multiple=True,
    metavar="EFFECT",
    help="Your own effect to try as well, module:Class or file.py:Class. Repeatable.",
)
@click.option("--jobs", "-j", type=click.IntRange(1), default=1, show_default=True, help="Worker processes.")
def diagnose(
    spec: str,
    data: str,
    out: Path,
    columns: str | None,
    trust: bool,
    time: str | None,
    effects: str | None,
    **asked: Any,
) -> None:
    """Test whether a simulator describes measured events, and find the effect that it lacks.

    The folder then holds report.html (a page with figures), diagnosis.json (every number), and model.json (the
    simulator with the effect, which every command accepts as a task). If the disagreement remains, correction.npz
    holds weights that make simulated events look like the measured ones.
    """
    spec = named(spec, trust)
    registry.load("task", spec)  # what is wrong with the request is said before a folder is made
    x, when = read_timed(data, [c.strip() for c in columns.split(",")] if columns else None, time)
    require_folder(out)
    with DiagnosisProgress(Console(stderr=True)) as progress:
        found = diagnose_events(
            spec,
            x,
            effects=None if effects is None else [name.strip() for name in effects.split(",")],
            time=when,
            progress=progress,
            **asked,
        )
    found.save(out, f"{Path(data).name} against {spec}")
    click.echo(found.details())
