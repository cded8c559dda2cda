"""`avobench check`: does a task, method or effect keep its contract?"""

import click

from avobench.bench.plugins import registry
from avobench.cli.isolated import Isolated
from avobench.cli.options import SECONDS, TRUST
from avobench.cli.terminal import say
from avobench.tasks.errors import AvobenchError


@click.command(cls=Isolated)
@click.argument("kind", type=click.Choice(["task", "method", "effect"]))
@click.argument("name")
@TRUST
@SECONDS
def check(kind: str, name: str, trust: bool) -> None:
    """Check that a task, method or effect keeps its contract. NAME is a registered name, or module:Class."""
    from avobench.bench import conformance  # here, because SciPy's statistics take a second to load
    from avobench.tasks.meter import Meter

    passed, meter = True, Meter()
    for result in conformance.run(kind, registry.trusted(name, trust), meter):
        passed &= result.passed
        say(f"{'pass' if result.passed else 'FAIL'}  {result.what}" + (f": {result.why}" if result.why else ""))
    if meter.used:
        say(f"{meter.used} simulated events")
    if not passed:
        raise AvobenchError(f"{kind} {name} does not keep the contract")
