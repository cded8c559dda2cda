"""`avobench diagnose`: from a file of measured events to what the simulator lacks."""

from pathlib import Path
from typing import Any

import click

from avobench.api.diagnosis import diagnose as diagnose_events
from avobench.api.progress import shown
from avobench.bench.store.files import require_folder
from avobench.cli.isolated import Isolated
from avobench.cli.measured import Asked, of_measurement
from avobench.cli.options import DROP_INVALID, SECONDS, SEED, listed
from avobench.cli.terminal import say


@click.command(cls=Isolated)
@of_measurement
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results.")
@DROP_INVALID
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
    "--effects",
    multiple=True,
    metavar="A,B,...",
    callback=listed,
    help="Effects of the catalogue to try.  [all that apply]",
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
def diagnose(out: Path, time: str | None, **options: Any) -> None:
    """Test whether a simulator describes measured events, and find the effect that it lacks.

    The folder then holds report.html (a page with figures), diagnosis.json (every number), and model.json (the
    simulator with the effect, which every command accepts as a task). If the disagreement remains, correction.npz
    holds weights that make simulated events look like the measured ones.
    """
    asked = Asked.of(options, time)
    task, x, when = asked.read(time=time)
    require_folder(out)
    with shown(None, plain=True) as progress:
        found = diagnose_events(task, x, time=when, progress=progress, **options)
    found.save(out, asked.title)
    say(found.details())
