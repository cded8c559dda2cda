"""`avobench list` and `avobench effects`: what there is to choose from, and what each effect does to events."""

from pathlib import Path

import click

from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder
from avobench.cli import listing
from avobench.cli.isolated import Isolated
from avobench.cli.options import TRUST, named
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError

TASKS = ("poisson", "weinberg", "carl", "alignment")
"""Whose effects are drawn where no task is given: together they show every family."""


@click.command("list", cls=Isolated)
@click.argument("kind", type=click.Choice(["tasks", "methods", "effects"]), required=False)
@click.option("--task", "spec", default=None, metavar="NAME", help="Show the effects of this task, with their bounds.")
@TRUST
def list_(kind: str | None, spec: str | None, trust: bool) -> None:
    """Show the tasks, the methods and the effects, or one kind of them."""
    if spec is not None:
        if kind not in (None, "effects"):
            raise UsageError(f"--task is for `avobench list effects`, not for {kind}")
        say(listing.effects_of(named(spec, trust)))
        return
    tables = {"tasks": listing.tasks, "methods": listing.methods, "effects": listing.effects}
    say("\n\n".join(table() for name, table in tables.items() if kind in (None, name)))


@click.group()
def effects() -> None:
    """What a simulator may lack, in pictures; `avobench list effects` says it in words."""


@effects.command("draw", cls=Isolated)
@click.option(
    "--task", "specs", multiple=True, metavar="NAME", help=f"Task, or module:Class; repeatable.  [{', '.join(TASKS)}]"
)
@click.option("--out", type=click.Path(path_type=Path), default=Path("reports/effects"), show_default=True)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@TRUST
def draw_(specs: tuple[str, ...], out: Path, seed: int, trust: bool) -> None:
    """Draw what each effect does to the events of a task: each shape without and with it, at a middling strength."""
    from avobench.reports.effects import draw  # here, because matplotlib takes a second to load

    require_folder(out)
    for spec in specs or TASKS:
        task = registry.build("task", named(spec, trust), {})
        registry.require_packages("task", task)
        for paths in draw(task, out, seed):
            say("\n".join(map(str, paths)))
