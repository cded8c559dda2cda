"""`avobench list`: what there is to choose from."""

import click

from avobench.bench.plugins import registry
from avobench.cli import listing
from avobench.cli.isolated import Isolated
from avobench.cli.options import TRUST
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError


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
