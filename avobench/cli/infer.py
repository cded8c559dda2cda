"""`avobench infer`: from a file of measured events to the parameters of a simulator."""

from pathlib import Path
from typing import Any

import click

from avobench.api.inference import infer as infer_events
from avobench.api.progress import shown
from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.bench.sweep.plan import parse_settings
from avobench.cli.isolated import Isolated
from avobench.cli.measured import read_joint
from avobench.cli.options import COLUMNS, DROP_INVALID, JOINT, SECONDS, SEED, SETTINGS, TRUST, require_alone
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError


@click.command(cls=Isolated)
@click.option("--task", "spec", default=None, metavar="NAME", help="Task, file.py:Class, or a model.json.")
@click.option("--data", default=None, metavar="FILE", help="File of measured events. For ROOT, file.root:tree.")
@JOINT
@click.option("--method", default=None, metavar="NAME", help="Method, or file.py:Class.  [avo, or smm without PyTorch]")
@click.option("--budget", type=int, default=160_000, show_default=True, help="Simulated events, at most.")
@SEED
@SETTINGS
@COLUMNS
@DROP_INVALID
@TRUST
@SECONDS
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE", help="JSON file to write the result to.")
def infer(
    spec: str | None,
    data: str | None,
    sets: str | None,
    method: str | None,
    budget: int,
    seed: int,
    settings: tuple[str, ...],
    columns: list[str] | None,
    drop_invalid: bool,
    trust: bool,
    out: Path | None,
) -> None:
    """Infer the parameters of a simulator from measured events."""
    if out is not None:
        require_folder(out.parent, make=False)
    specs: dict[str, list[str]] = {"task": [], "method": [method] if method else []}
    if sets is not None:
        require_alone({"task": spec, "data": data, "columns": columns})
    elif spec is None or data is None:
        raise UsageError("give a simulator by --task and measured events by --data, or several data sets by --joint")
    else:
        specs["task"] = [registry.trusted(spec, trust)]
    chosen = parse_settings(list(settings), specs)
    task: Any
    x: Any = None
    if sets is not None:
        task = read_joint(sets, trust)
    else:
        task = registry.build("task", *specs["task"], chosen[specs["task"][0]])
        x = read_events(data, columns)
    with shown(None, plain=True) as progress:
        found = infer_events(
            task,
            x,
            method,
            budget=budget,
            seed=seed,
            settings=chosen[method] if method else None,
            drop_invalid=drop_invalid,
            progress=progress,
        )
    if out is not None:
        found.save(out)
    say(found)
