"""The output of a command is text, and gives the terminal no orders."""

import click

from avobench.api.terminal import plain


def say(text: object, *, err: bool = False) -> None:
    """Print a line on standard output, or on standard error."""
    click.echo(plain(text), err=err)
