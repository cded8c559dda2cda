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
from avobench.cli.options import COLUMNS, DATA, DROP_INVALID, SECONDS, TRUST, named
from avobench.cli.progress import DiagnosisProgress
from avobench.cli.terminal import say


@click.command(cls=Isolated)
@click.option("--task", "spec", required=True, metavar="NAME", help="Task, file.py:Class, or a model.json.")
@DATA
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results.")
@COLUMNS
@DROP_INVALID
@TRUST
@SECONDS
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True)
@click.option("--alpha", type=float, default=0.05, show_default=True, help="Rate of false alarms, at most.")
@click.option("--max-effects", type=click.IntRange(0), default=3, show_default=True, help="Effects to add at most.")
@click.option("--simulations", type=click.IntRange(1), default=None, help="Simulated events, at most.  [what it takes]")
@click.option("--ordered", is_flag=True, help="Test the order of the rows: drift, change points, seasons, clustering.")
@click.option("--time", default=None, metavar="COLUMN", help="The same along this column, which is no feature then.")
@click.option(
    "--fit", default="surrogate", show_default=True, metavar="NAME", help="Method that looks for theta first."
)
@click.option("--effects", default=None, metavar="A,B,...", help="Effects of the catalogue to try.  [all that apply]")
@click.option("--effect", "own", multiple=True, metavar="EFFECT", help="module:Class or file.py:Class; repeatable.")
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
    """Say whether measured events disagree with a simulator, where, which effect is missing, and add it.

    Writes diagnosis.json, model.json (a task, for wherever a task is accepted), and correction.npz, weights for
    simulated events, where the catalogue does not explain all.
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
    say(found.details())
