"""Options that several commands share."""

from pathlib import Path

import click

from avobench.api.sweep import RESULTS as DEFAULT
from avobench.bench.plugins import registry

RESULTS = click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=DEFAULT,
    help="Folder of the records.",
)
SEED = click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, help="Seed of all random numbers.")
TRUST = click.option("--trust", is_flag=True, help="Allow a model.json to run code that it names.")
DATA = click.option(
    "--data",
    required=True,
    metavar="FILE",
    help="File of measured events, one row per event. For ROOT, file.root:tree.",
)
COLUMNS = click.option("--columns", metavar="A,B,...", help="Columns or branches to read, in this order.")
SECONDS = click.option(
    "--seconds",
    type=float,
    help="End the command, and all that it started, after so many seconds.  [no limit]",
)
TIME_LIMIT, MEMORY_LIMIT = (
    click.option(f"--{what}-limit", type=float, metavar=unit, help=f"Limit for {of}.  [{usual}]")
    for what, unit, of, usual in (
        ("time", "SECONDS", "each cell or data set", 21600),
        ("memory", "MIB", "the process of each", 8192),
    )
)
DROP_INVALID = click.option("--drop-invalid", is_flag=True, help="Leave out rows with NaN or infinite values.")


def named(spec: str, trust: bool) -> str:
    """The argument that names a task; the user answers for the code that its file names where `trust` says so."""
    return registry.trusted(spec) if trust else spec
