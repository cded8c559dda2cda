"""The command `avobench`. Exit code 0 when all was done, 1 for failed work, 2 for wrong usage, 130 after Ctrl-C."""

import errno
import signal
import sys
from importlib import import_module
from typing import NoReturn

import click

from avobench.cli.state import STOPPED, State
from avobench.cli.terminal import naming_damaged, say

COMMANDS = {
    "list": ("listing:list_", "Show the tasks, the methods and the effects."),
    "infer": ("infer:infer", "Infer the parameters of a simulator behind measured events."),
    "run": ("run:run", "Carry out the cells that a results folder lacks."),
    "status": ("records:status", "Summarise the records of a results folder."),
    "export": ("records:export", "Write all records as one table, with a row per cell."),
    "pack": ("records:pack", "Put the records of a results folder into one file."),
    "check": ("check:check", "Tell whether a task, method or effect keeps its contract."),
    "figure": ("reports:figure", "Draw figures from records."),
    "report": ("reports:report", "Write one page with everything."),
    "diagnose": ("diagnose:diagnose", "Say what a simulator lacks, by measured events."),
    "challenge": ("challenge:challenge", "Hide effects in measured data, find them again, and score that."),
}
"""The commands by name: where each is, and what it does. What they need takes a second to load, so that each is
imported when it is asked for."""


class Commands(click.Group):
    def list_commands(self, context: click.Context) -> list[str]:
        return sorted(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module, _, command = COMMANDS[name][0].partition(":")
        return getattr(import_module(f"avobench.cli.{module}"), command)

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in self.list_commands(context)])


HELP = {"help_option_names": ["-h", "--help"], "max_content_width": 110, "show_default": True}


@click.group(cls=Commands, context_settings=HELP)
@click.version_option(package_name="avobench")
@click.option("--debug", is_flag=True, help="Show the traceback of an error. Accepted anywhere.")
@click.option("--in-process", is_flag=True, help="Run your code in this process, for a debugger. Accepted anywhere.")
@click.pass_obj
def cli(state: State, debug: bool, in_process: bool) -> None:
    """Fit simulators that have no likelihood, compare methods under one budget, and find what a simulator lacks."""
    state.debug, state.in_process = debug, in_process


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
        from avobench.tasks.errors import UsageError  # here, as in `_said`, because help needs no NumPy

        say(f"avobench: {' '.join(_said(error).split())}", err=True)
        sys.exit(2 if isinstance(error, (UsageError, click.UsageError)) else 1)


def _stop(state: State) -> NoReturn:
    say(state.stopped, err=True)
    sys.exit(STOPPED)


def _said(error: Exception) -> str:
    from avobench.bench.processes.calls import Fault
    from avobench.tasks.errors import AvobenchError

    if isinstance(error, click.ClickException):
        return error.format_message()
    if isinstance(error, AvobenchError):
        return str(error)
    if isinstance(error, OSError) and error.errno in SURROUNDINGS:
        return f"{error.filename or 'a file'}: {error.strerror}"
    kind = "" if isinstance(error, Fault) else f"{type(error).__name__}: "
    return f"{kind}{error} (a fault of avobench; --debug shows where)"
