import sys
from pathlib import Path

import pytest

from avobench.bench import cli

HERE = Path(__file__).parent


@pytest.fixture(autouse=True)
def _beside_the_toys(monkeypatch):
    """`toys:Normal` is found as a user's own module is: beside the user."""
    monkeypatch.chdir(HERE)
    monkeypatch.syspath_prepend(str(HERE))


@pytest.fixture
def avobench(monkeypatch, capsys):
    """The command, in this process: arguments -> (exit code, standard output, standard error)."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["avobench", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as exit:
            cli.main()
        return exit.value.code or 0, *capsys.readouterr()

    return call
