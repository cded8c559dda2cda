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
