"""Give so many hostile inputs of each kind to avobench, and print how many were taken and how many refused."""

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import click
from hypothesis import HealthCheck, Phase, given, seed, settings


def outcomes(target: Any, examples: int, start: int) -> Counter[str]:
    """What became of so many examples. Raises AssertionError for the first bad one, as small as it can be made."""
    found: Counter[str] = Counter()

    @seed(start)
    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
    )
    @given(target.inputs())
    def check(made: Any) -> None:
        found[target.check(made)] += 1

    check()
    return found


@click.command()
@click.option("--examples", default=1000, show_default=True, help="Of each kind.")
@click.option("--only", default=None, help="A part of the name of a kind.")
@click.option("--seed", "start", default=0, show_default=True)
def main(examples: int, only: str | None, start: int) -> None:
    """Print a line for each kind of input; exit code 1 if any did what none may."""
    from fuzz import answers
    from fuzz.targets import targets

    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for target in targets(Path(folder), answers.KINDS):
            if only is not None and only not in target.name:
                continue
            begun = time.monotonic()
            try:
                found = outcomes(target, examples, start)
            except BaseExceptionGroup as error:
                first, told = error.exceptions[0], [str(each)[:300] for each in error.exceptions]
                bad, found = bad + 1, Counter()
                click.echo(f"{target.name:16} BAD: {type(first).__name__}: {' | '.join(told)}")
            except Exception as error:
                bad, found, notes = bad + 1, Counter(), getattr(error, "__notes__", "")
                click.echo(f"{target.name:16} BAD: {type(error).__name__}: {str(error)[:600]} {notes}")
            else:
                counts = f"{found['taken']:6} taken {found['refused']:6} refused"
                click.echo(f"{target.name:16}{found.total():6} inputs {counts} {time.monotonic() - begun:6.0f} s")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
