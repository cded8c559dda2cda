import os
import signal
import sys
from functools import partial
from pathlib import Path

import pytest
from hypothesis import settings

USERS = Path(__file__).parent / "users"
"""Tasks, methods and effects as a user writes them: sound ones, and ones with a fault each."""

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # as the command does, so that results are the same

signal.signal(signal.SIGINT, signal.default_int_handler)  # what a script runs in its background ignores Ctrl-C

settings.register_profile("busy", deadline=None)  # a loaded machine is no fault of the code
settings.load_profile("busy")

from avobench.cli import main as cli  # noqa: E402
from benchmark_records import benchmark, make_record  # noqa: E402
from browser import browser  # noqa: E402

__all__ = ["benchmark", "browser", "make_record"]


@pytest.fixture
def run(monkeypatch, capfd):
    """A command, in this process: command, arguments -> (exit code, standard output, standard error)."""

    def call(command, *arguments):
        monkeypatch.setattr(sys, "argv", ["avobench", *map(str, arguments)])
        capfd.readouterr()
        with pytest.raises(SystemExit) as exit:
            cli.main(command)
        return exit.value.code or 0, *capfd.readouterr()

    return call


@pytest.fixture
def avobench(run):
    """The command `avobench`: arguments -> (exit code, standard output, standard error)."""
    return partial(run, cli.cli)


@pytest.fixture
def done(avobench):
    """The standard output of a command that must end well: arguments -> text."""

    def call(*arguments):
        code, out, err = avobench(*arguments)
        assert code == 0, err
        return out

    return call


@pytest.fixture
def beside_users_modules(monkeypatch):
    """`toys:Normal` is found as a user's own module is: beside the user."""
    monkeypatch.chdir(USERS)
    monkeypatch.syspath_prepend(str(USERS))


def pytest_collection_modifyitems(items):
    """The longest files come first, so that at the end no core waits for another."""
    items.sort(key=lambda item: item.path.name not in ("test_robustness.py", "test_wheel.py", "test_published.py"))
