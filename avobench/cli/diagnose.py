"""`avobench diagnose`: from a file of measured events to what the simulator lacks."""

from pathlib import Path
from typing import Any

import click

from avobench.api.diagnosis import diagnose as diagnose_events
from avobench.api.progress import shown
from avobench.bench.store.files import require_folder
from avobench.cli.isolated import Isolated
from avobench.cli.measured import Asked, of_measurement
from avobench.cli.options import DROP_INVALID, PATH, SECONDS, SEED, names
from avobench.cli.terminal import say


@click.command(cls=Isolated)
@of_measurement
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Folder of the results.")
@DROP_INVALID
@SECONDS
@SEED
@click.option("--alpha", type=float, default=0.05, help="Upper bound on the rate of false alarms.")
@click.option("--max-effects", type=click.IntRange(0), default=3, help="Largest number of effects to add.")
@click.option("--simulations", type=click.IntRange(1), help="Limit on simulated events.  [as many as needed]")
@click.option(
    "--ordered", is_flag=True, help="Also test the order of the rows: drift, change points, seasons, clustering."
)
@click.option("--time", metavar="COLUMN", help="Also test the order along this column, which is then not a feature.")
@click.option(
    "--fit",
    default="surrogate",
    metavar="NAME",
    help="Method that fits theta first. The diagnosis's own fit is named surrogate.",
)
@names("--effects", "Effects of the catalogue to try.  [all that apply]")
@click.option(
    "--effect",
    "own",
    multiple=True,
    metavar="EFFECT",
    help="Your own effect to try as well, module:Class or file.py:Class. Repeatable.",
)
@click.option("--bank", type=PATH, help="Folder that keeps simulated events.")
@click.option("--jobs", "-j", type=click.IntRange(1), default=1, help="Worker processes.")
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
        diagnosis = diagnose_events(task, x, time=when, progress=progress, **options)
    diagnosis.save(out, asked.title)
    say(diagnosis.details())
