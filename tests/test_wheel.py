"""The wheel, installed in a new environment outside of the repository, does what a user installs it for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PYTHON = os.environ.get("AVOBENCH_WHEEL_PYTHON", sys.executable)
"""Another version of Python to install the wheel into: `AVOBENCH_WHEEL_PYTHON=python3.13 make test-wheel`."""
OWN_METHOD = ROOT / "docs" / "examples" / "nearest_summary.py"


def done(*command, **options):
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with an environment in which the wheel is installed, without any extra."""
    place = tmp_path_factory.mktemp("wheel")
    uv = [sys.executable, "-m", "uv"]
    done(*uv, "build", "--quiet", "--out-dir", place / "dist", ROOT, cwd=place)  # by an sdist: without old files
    (wheel,) = (place / "dist").glob("avobench-*.whl")
    done(*uv, "venv", "--quiet", "--python", PYTHON, place / "env")
    pip = [*uv, "pip", "install", "--quiet", "--python", place / "env" / "bin" / "python"]
    done(*pip, "--constraint", ROOT / "constraints.txt", wheel, cwd=place)
    return place


def test_the_base_install_lists_sweeps_and_diagnoses(installed):
    def avobench(*arguments):
        clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        return done(installed / "env" / "bin" / "avobench", *arguments, cwd=installed, env=clean)

    version = avobench("--version")
    assert version.split()[-1] == done(sys.executable, "-m", "avobench", "--version").split()[-1]
    assert "poisson" in avobench("list")
    (installed / "nearest_summary.py").write_text(OWN_METHOD.read_text())
    sweep = ["run", "--task", "poisson", "--method", "nearest_summary:NearestSummary", "--targets", "0-1"]
    swept = avobench(*sweep, "--budget", 4000, "--observations", 2000, "--results", installed / "results")
    assert "2 of 2 cells ok" in swept
    hide = ["challenge", "make", "--task", "poisson", "--cases", 1, "--kinds", "own", "--seed", 2]
    avobench(*hide, "--events", 2000, "--out", installed / "hidden")
    data = installed / "hidden" / "data" / "0000.npz"
    told = avobench("diagnose", "--task", "poisson", "--data", data, "--out", installed / "told")
    assert "gap on held-out events" in told
    assert (installed / "told" / "report.html").exists()
