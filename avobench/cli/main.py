"""The command `avobench`. Exit code 0 when all was done, 1 for failed work, 2 for wrong usage, 130 after Ctrl-C."""

import sys

import click

from avobench.cli.challenge import challenge
from avobench.cli.check import check
from avobench.cli.damaged import naming_damaged
from avobench.cli.diagnose import diagnose
from avobench.cli.effects import effects, list_
from avobench.cli.infer import infer
from avobench.cli.pack import pack
from avobench.cli.records import export, status
from avobench.cli.reports import figure, report
from avobench.cli.run import run
from avobench.cli.study import study
from avobench.tasks.errors import AvobenchError, UsageError


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="avobench")
@click.option("--debug", is_flag=True, help="Show tracebacks; may stand anywhere.")
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Fit simulators that have no likelihood, compare methods under one budget, find what a simulator lacks."""
    context.obj = debug


COMMANDS = (list_, infer, run, status, export, pack, check, study, figure, report, diagnose, challenge, effects)

for command in COMMANDS:
    cli.add_command(command)


def main() -> None:
    """Run the command line; whatever goes wrong is one line on standard error."""
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    debug = len(arguments) < len(sys.argv) - 1
    try:
        sys.exit(naming_damaged(lambda: cli.main(["--debug"] * debug + arguments, standalone_mode=False)))
    except (KeyboardInterrupt, click.Abort):
        click.echo("avobench: stopped; what was finished is kept, and the same command goes on from there", err=True)
        sys.exit(130)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help())
        sys.exit(2)
    except Exception as error:
        if debug:
            raise
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
        if not isinstance(error, (click.ClickException, AvobenchError)):
            message = f"{type(error).__name__}: {message} (a fault of avobench; --debug shows where)"
        click.echo(f"avobench: {' '.join(message.split())}", err=True)
        sys.exit(2 if isinstance(error, (UsageError, click.UsageError)) else 1)
