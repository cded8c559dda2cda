"""Options that several commands share."""

from pathlib import Path

import click

from avobench.api.sweep import RESULTS as DEFAULT

RESULTS = click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=DEFAULT,
    show_default=True,
    help="Folder of the records.",
)
DATA = click.option(
    "--data", required=True, metavar="FILE", help="Measured events, one row each; file.root:tree for ROOT."
)
COLUMNS = click.option("--columns", default=None, metavar="A,B,...", help="Columns or branches to read, in this order.")
DROP_INVALID = click.option("--drop-invalid", is_flag=True, help="Leave out rows that hold NaN or infinite values.")
