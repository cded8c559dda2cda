import sys

import pytest

from avobench.cli.main import main
from benchmark_records import benchmark, make_record

__all__ = ["benchmark", "make_record"]


@pytest.fixture
def run(monkeypatch, capfd):
    """A command of the paper, in this process: command, arguments -> (exit code, standard output, standard error)."""

    def call(command, *arguments):
        monkeypatch.setattr(sys, "argv", ["paper", *map(str, arguments)])
        capfd.readouterr()
        with pytest.raises(SystemExit) as exit:
            main(command)
        return exit.value.code or 0, *capfd.readouterr()

    return call
