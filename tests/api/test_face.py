"""What `import avobench` offers, and what it costs."""

import subprocess
import sys
from pathlib import Path

import pytest

import avobench


@pytest.mark.parametrize("name", avobench.__all__)
def test_each_name_is_there_and_documented(name):
    assert getattr(avobench, name).__doc__


HELP = "from avobench.cli.main import main; sys.argv[1:] = ['--help']; main()"


@pytest.mark.parametrize("code", ["import avobench", HELP])
def test_the_import_and_the_help_load_no_library_before_it_is_needed(code):
    heavy = "{'numpy', 'pandas', 'scipy', 'torch', 'matplotlib', 'rich', 'importlib.metadata'} & set(sys.modules)"
    told = f"import atexit, sys; atexit.register(lambda: print({heavy})); {code}"
    said = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout
    assert said.splitlines()[-1] == "set()"


def test_the_version_is_said_once():
    cited = (Path(__file__).parents[2] / "CITATION.cff").read_text()
    assert f"\nversion: {avobench.__version__}\n" in cited


def test_lists_are_tables():
    assert {"poisson", "weinberg"} <= set(avobench.list_tasks().index)
    assert {"avo", "abc-smc"} <= set(avobench.list_methods().index)
    effects = avobench.list_effects("weinberg")
    assert effects.loc["resolution", "what"].endswith(".")
    assert "sigma" in effects.loc["resolution", "parameters"]
