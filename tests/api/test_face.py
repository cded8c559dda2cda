"""What `import avobench` offers, and what it costs."""

import subprocess
import sys
from pathlib import Path

import pytest

import avobench


@pytest.mark.parametrize("name", avobench.__all__)
def test_each_name_is_there_and_documented(name):
    assert getattr(avobench, name).__doc__


def test_the_import_loads_no_library_before_it_is_needed():
    heavy = "{'numpy', 'pandas', 'scipy', 'torch', 'matplotlib'} & set(sys.modules)"
    command = [sys.executable, "-c", f"import sys, avobench; avobench.__version__; print({heavy})"]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == "set()"


def test_the_version_is_said_once():
    cited = (Path(__file__).parents[2] / "CITATION.cff").read_text()
    assert f"\nversion: {avobench.__version__}\n" in cited


def test_lists_are_tables():
    assert {"poisson", "weinberg"} <= set(avobench.list_tasks().index)
    assert {"avo", "abc-smc"} <= set(avobench.list_methods().index)
    effects = avobench.list_effects("weinberg")
    assert effects.loc["resolution", "what"].endswith(".")
    assert "sigma" in effects.loc["resolution", "parameters"]
