"""`avobench check`: does a task, method or effect keep its contract?"""

import click

from avobench.bench import conformance
from avobench.tasks.errors import AvobenchError


@click.command()
@click.argument("kind", type=click.Choice(["task", "method", "effect"]))
@click.argument("name")
def check(kind: str, name: str) -> None:
    """Tell whether a task, method or effect keeps its contract; NAME is registered or module:Class."""
    passed = True
    for result in conformance.run(kind, name):
        passed &= result.passed
        click.echo(f"{'pass' if result.passed else 'FAIL'}  {result.what}" + (f": {result.why}" if result.why else ""))
    if not passed:
        raise AvobenchError(f"{kind} {name} does not keep the contract")
