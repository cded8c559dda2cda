"""Options that several commands share."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from avobench.api.sweep import RESULTS as DEFAULT
from avobench.bench.processes.workers import Workers
from avobench.cli.state import State
from avobench.tasks.errors import UsageError


def listed(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> list[str] | None:
    """The names in `A,B,...`, as a callback of an option that may be repeated. Raises UsageError for a name twice."""
    names = [name.strip() for each in given for name in each.split(",")]
    if len(set(names)) < len(names):
        raise UsageError(f"{option.opts[0]} names '{max(names, key=names.count)}' twice")
    return names or None


def names(option: str, description: str) -> Callable[..., Any]:
    """An option that takes names in one or several lists `A,B,...`."""
    return click.option(option, multiple=True, metavar="A,B,...", callback=listed, help=description)


def workers_of(options: dict[str, Any], state: State) -> Workers:
    """The workers that a command line asks for, whose options are taken out of those of the command."""
    asked = {name: options.pop(name) for name in Workers.__dataclass_fields__ if name in options}
    return Workers(**asked, in_process=state.in_process)


PATH = click.Path(path_type=Path)
RESULTS = click.option("--results", type=PATH, default=DEFAULT, help="Folder of the records.")
SEED = click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, help="Seed of all random numbers.")
TRUST = click.option("--trust", is_flag=True, help="Allow a model.json to run code that it names.")
SETTINGS = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="METHOD.PARAM=VALUE",
    help="Value of a setting of a method or task. Repeatable.",
)
SECONDS = click.option(
    "--seconds", type=float, help="End the command, and all that it started, after so many seconds.  [no limit]"
)
TIME_LIMIT = click.option(
    "--time-limit", type=float, metavar="SECONDS", help="Limit for each cell or data set.  [21600]"
)
MEMORY_LIMIT = click.option("--memory-limit", type=float, metavar="MIB", help="Limit for the process of each.  [8192]")
DROP_INVALID = click.option("--drop-invalid", is_flag=True, help="Leave out rows with NaN or infinite values.")
