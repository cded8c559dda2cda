"""`avobench infer`: from a file of measured events to the parameters of a simulator."""

from pathlib import Path
from typing import Any

import click

from avobench.api.inference import infer as infer_events
from avobench.api.progress import shown
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.bench.sweep.plan import parse_settings
from avobench.cli.isolated import Isolated
from avobench.cli.measured import Asked, of_measurement
from avobench.cli.options import DROP_INVALID, PATH, SECONDS, SEED, SETTINGS
from avobench.cli.terminal import say


@click.command(cls=Isolated)
@of_measurement
@click.option("--method", metavar="NAME", help="Method, or file.py:Class.  [avo, or rank-moments without PyTorch]")
@click.option("--budget", type=int, default=160_000, help="Simulated events, at most.")
@SEED
@SETTINGS
@DROP_INVALID
@click.option("--jobs", "-j", type=click.IntRange(1), help="Processes that simulate events.  [that of the method]")
@SECONDS
@click.option("--bank", type=PATH, help="Folder that keeps simulated events.")
@click.option("--out", type=PATH, metavar="FILE", help="JSON file to write the result to.")
def infer(method: str | None, settings: tuple[str, ...], out: Path | None, **options: Any) -> None:
    """Infer the parameters of a simulator from measured events."""
    if out is not None:
        require_folder(out.parent, make=False)
    asked = Asked.of(options)
    spec = asked.spec and registry.trusted(asked.spec, asked.trust)
    methods = [method] if method not in (None, "abc") else []
    chosen = parse_settings(settings, {"task": [spec] if spec else [], "method": methods})
    task, x, _ = asked.read(chosen.get(spec))
    with shown(None, plain=True) as progress:
        inference = infer_events(task, x, method, settings=chosen.get(method), progress=progress, **options)
    if out is not None:
        inference.save(out)
    say(inference)
