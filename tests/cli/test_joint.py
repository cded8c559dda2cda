"""Several data sets on the command line: a file with a section each, fitted and diagnosed as from Python."""

import json

import numpy as np
import pytest

import avobench as av

SIMULATOR = """
import avobench


def rates(seconds):
    made = lambda theta, rng: rng.poisson(seconds * theta[:, 0])
    return avobench.task(made, name="n", prior={"rate": (0.5, 5)}, features=["n"])


slow, fast = rates(1), rates(10)
"""
SETS = """
shared = ["rate"]

[slow]
task = "simulator.py:slow"
data = "slow.csv"
columns = ["n"]

[fast]
task = "simulator.py:fast"
table = "fast.csv"
"""


@pytest.fixture
def sets(tmp_path):
    rng = np.random.default_rng(0)
    counts = np.bincount(rng.binomial(rng.poisson(20, 3000), 0.85), minlength=45)
    rows = "".join(f"{k - 0.5},{k + 0.5},{n}\n" for k, n in enumerate(counts))
    (tmp_path / "simulator.py").write_text(SIMULATOR)
    (tmp_path / "slow.csv").write_text("run,n\n" + "".join(f"7,{n}\n" for n in rng.poisson(2, 3000)))
    (tmp_path / "fast.csv").write_text("low,high,value\n" + rows)
    (tmp_path / "sets.toml").write_text(SETS)
    return tmp_path / "sets.toml"


def test_it_finds_in_which_set_something_is_missing(sets, done):
    asked = ["--joint", sets, "--effects", "inefficiency", "--max-effects", 1, "--out", sets.parent / "out"]
    assert "missing: inefficiency on fast: n" in done("diagnose", *asked)
    assert json.loads((sets.parent / "out" / "diagnosis.json").read_text())["effects"][0]["feature"] == "fast: n"


def test_it_fits_as_python_does(sets, done):
    done("infer", "--joint", sets, "--budget", 100_000, "--out", sets.parent / "fit.json")
    slow, fast = (av.bench.plugins.registry.task_of(f"{sets.parent}/simulator.py:{name}") for name in ("slow", "fast"))
    x = av.read_events(str(sets.parent / "slow.csv"), ["n"])
    both = av.joint({"slow": (slow, x), "fast": (fast, av.read_table(sets.parent / "fast.csv"))})
    assert av.load(sets.parent / "fit.json").theta == av.infer(both, budget=100_000, progress=False).theta


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("[slow]", "[slow", "cannot be read"),
        ("columns", "colums", "slow cannot have 'colums'; did you mean columns?"),
        ('data = "slow.csv"', "", "slow needs a task, and data or a table"),
        ('["n"]', '"n"', "slow: columns cannot be 'n'"),
        ('["rate"]', '"rate"', "shared must be a list"),
        ('["rate"]', '["x"]', "no two data sets have a parameter 'x'"),
        ('data = "slow.csv"', 'data = "slow.csv"\ndensity = true', "density is of a table"),
        ("fast.csv", "none.csv", "none.csv"),
    ],
)
def test_what_is_wrong_is_one_line(sets, avobench, old, new, word):
    sets.write_text(SETS.replace(old, new, 1))
    status, _, told = avobench("--in-process", "diagnose", "--joint", sets, "--out", sets.parent / "out")
    assert (status, told.count("\n"), word in told) == (2, 1, True), told
    assert not (sets.parent / "out").exists()
