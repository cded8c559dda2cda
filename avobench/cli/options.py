"""Options that several commands share."""

from pathlib import Path

import click

from avobench.api.sweep import RESULTS as DEFAULT
from avobench.bench.plugins import registry

RESULTS = click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=DEFAULT,
    show_default=True,
    help="Folder of the records.",
)
TRUST = click.option("--trust", is_flag=True, help="Run the code that a model.json names, if it names any.")
DATA = click.option(
    "--data", required=True, metavar="FILE", help="Measured events, one row each; file.root:tree for ROOT."
)
COLUMNS = click.option("--columns", default=None, metavar="A,B,...", help="Columns or branches to read, in this order.")
SECONDS = click.option(
    "--seconds", type=float, default=None, help="End it after so many seconds, with what it began.  [no limit]"
)
DROP_INVALID = click.option("--drop-invalid", is_flag=True, help="Leave out rows that hold NaN or infinite values.")


def named(spec: str, trust: bool) -> str:
    """What names a task; the user answers for the code that its file names where `trust` says so."""
    return registry.trusted(spec) if trust else spec
