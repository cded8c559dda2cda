"""`avobench list` and `avobench effects`: what there is to choose from, and what each effect does to events."""

from pathlib import Path

import click

from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.cli import listing
from avobench.cli.isolated import Isolated
from avobench.cli.options import TRUST
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError

TASKS = ("poisson", "weinberg", "carl", "alignment")
"""Whose effects are drawn where no task is given: together they show every family."""


@click.command("list", cls=Isolated)
@click.argument("kind", type=click.Choice(["tasks", "methods", "effects"]), required=False)
@click.option(
    "--task",
    "spec",
    metavar="NAME",
    help="List the effects that apply to this task, with the bounds of their parameters.",
)
@TRUST
def list_(kind: str | None, spec: str | None, trust: bool) -> None:
    """List the tasks, the methods and the effects, or one kind of them."""
    if spec is not None:
        if kind not in (None, "effects"):
            raise UsageError(f"--task is for `avobench list effects`, not for {kind}")
        say(listing.effects_of(registry.trusted(spec, trust)))
        return
    tables = {"tasks": listing.tasks, "methods": listing.methods, "effects": listing.effects}
    say("\n\n".join(table() for name, table in tables.items() if kind in (None, name)))


@click.group()
def effects() -> None:
    """Draw the effects of the catalogue. `avobench list effects` describes them in words."""


@effects.command("draw", cls=Isolated)
@click.option(
    "--task", "specs", multiple=True, metavar="NAME", help=f"Task, or module:Class. Repeatable.  [{', '.join(TASKS)}]"
)
@click.option("--out", type=click.Path(path_type=Path), default=Path("reports/effects"), help="Folder.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the events.")
@TRUST
def draw_(specs: tuple[str, ...], out: Path, seed: int, trust: bool) -> None:
    """Draw the events of a task without and with each shape of each effect, at a medium strength."""
    from avobench.reports.effects import draw  # here, because matplotlib takes a second to load

    require_folder(out)
    for spec in specs or TASKS:
        task = registry.build("task", registry.trusted(spec, trust), {})
        registry.require_packages("task", task)
        for paths in draw(task, out, seed):
            say("\n".join(map(str, paths)))
