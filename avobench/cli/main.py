"""The command `avobench`. Exit code 0 when all was done, 1 for failed work, 2 for wrong usage, 130 after Ctrl-C."""

import errno
import signal
import sys
from typing import NoReturn

import click

from avobench.bench.processes.apart import Fault
from avobench.cli.challenge import challenge
from avobench.cli.check import check
from avobench.cli.damaged import naming_damaged
from avobench.cli.diagnose import diagnose
from avobench.cli.effects import effects, list_
from avobench.cli.infer import infer
from avobench.cli.isolated import STOPPED, State
from avobench.cli.pack import pack
from avobench.cli.records import export, status
from avobench.cli.reports import figure, report
from avobench.cli.run import run
from avobench.cli.terminal import say
from avobench.tasks.errors import AvobenchError, UsageError


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="avobench")
@click.option("--debug", is_flag=True, help="Show tracebacks; may stand anywhere.")
@click.option("--in-process", is_flag=True, help="Run your code in this process, for a debugger; may stand anywhere.")
@click.pass_obj
def cli(state: State, debug: bool, in_process: bool) -> None:
    """Fit simulators that have no likelihood, compare methods under one budget, find what a simulator lacks."""
    state.debug, state.in_process = debug, in_process


COMMANDS = (list_, infer, run, status, export, pack, check, figure, report, diagnose, challenge, effects)

for command in COMMANDS:
    cli.add_command(command)


ANYWHERE = ("--debug", "--in-process")
SURROUNDINGS = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO, errno.EACCES, errno.EPERM, errno.ENOENT}
SURROUNDINGS |= {errno.EISDIR, errno.ENOTDIR, errno.EEXIST, errno.ENAMETOOLONG, errno.ELOOP}
"""Faults of a disk, of what was named on it, or of what somebody did to its folders while the command ran."""


def main(command: click.Command = cli) -> None:
    """Run a command line, that of avobench by default; whatever goes wrong is one line on standard error."""
    given = sys.argv[1:]
    anywhere = [flag for flag in ANYWHERE if flag in given]
    arguments = [*anywhere, *(argument for argument in given if argument not in ANYWHERE)]
    state = State()
    signal.signal(signal.SIGINT, state.interrupt)
    try:
        sys.exit(naming_damaged(lambda: command.main(arguments, standalone_mode=False, obj=state)))
    except (KeyboardInterrupt, click.Abort):
        _stop(state)
    except click.exceptions.NoArgsIsHelpError as error:
        say(error.ctx.get_help())
        sys.exit(2)
    except Exception as error:
        if state.interrupted is not None:  # libraries turn what interrupts their loading into an ImportError
            _stop(state)
        if state.debug or "--debug" in anywhere:
            raise
        say(f"avobench: {' '.join(_said(error).split())}", err=True)
        sys.exit(2 if isinstance(error, (UsageError, click.UsageError)) else 1)


def _stop(state: State) -> NoReturn:
    say(state.stopped, err=True)
    sys.exit(STOPPED)


def _said(error: Exception) -> str:
    """What went wrong, for a person."""
    if isinstance(error, click.ClickException):
        return error.format_message()
    if isinstance(error, AvobenchError):
        return str(error)
    if isinstance(error, OSError) and error.errno in SURROUNDINGS:
        return f"{error.filename or 'a file'}: {error.strerror}"
    kind = "" if isinstance(error, Fault) else f"{type(error).__name__}: "
    return f"{kind}{error} (a fault of avobench; --debug shows where)"
