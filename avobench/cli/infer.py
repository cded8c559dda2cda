"""`avobench infer`: from a file of measured events to the parameters of a simulator."""

import json
from pathlib import Path

import click

from avobench.api.inference import infer as infer_events
from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder, write_file
from avobench.bench.sweep.plan import parse_settings
from avobench.cli.isolated import Isolated
from avobench.cli.options import COLUMNS, DATA, DROP_INVALID, SECONDS, TRUST, named
from avobench.cli.terminal import say


@click.command(cls=Isolated)
@click.option("--task", "spec", required=True, metavar="NAME", help="Task, file.py:Class, or a model.json.")
@DATA
@click.option("--method", default=None, metavar="NAME", help="Method, or file.py:Class.  [avo, or smm without PyTorch]")
@click.option("--budget", type=int, default=160_000, show_default=True, help="Simulated events that it may use.")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True)
@click.option("--set", "settings", multiple=True, metavar="METHOD.PARAM=VALUE", help="A setting of the method or task.")
@COLUMNS
@DROP_INVALID
@TRUST
@SECONDS
@click.option("--out", type=click.Path(path_type=Path), default=None, metavar="FILE", help="Write the result as JSON.")
def infer(
    spec: str,
    data: str,
    method: str | None,
    budget: int,
    seed: int,
    settings: tuple[str, ...],
    columns: str | None,
    drop_invalid: bool,
    trust: bool,
    out: Path | None,
) -> None:
    """Infer the parameters of a simulator behind measured events."""
    if out is not None:
        require_folder(out.parent, make=False)
    spec = named(spec, trust)
    chosen = parse_settings(list(settings), {"task": [spec], "method": [method] if method else []})
    found = infer_events(
        registry.build("task", spec, chosen[spec]),
        read_events(data, [c.strip() for c in columns.split(",")] if columns else None),
        method,
        budget=budget,
        seed=seed,
        settings=chosen[method] if method else None,
        drop_invalid=drop_invalid,
    )
    if out is not None:
        write_file(out, (json.dumps(found.to_dict(), indent=1) + "\n").encode())
    say(found)
