"""What was measured and by what it is simulated is told to `infer` and `diagnose` in the same words."""

import json

import numpy as np
import pandas as pd
import pytest

import avobench as av


@pytest.fixture
def files(tmp_path):
    rng, mean = np.random.default_rng(0), np.repeat([1.0, 2.0, 3.0], 6000)
    simulated = pd.DataFrame(
        {"time": rng.exponential(mean), "mean": mean, "w": rng.choice([1, -0.2], 18_000, p=[0.9, 0.1])}
    )
    simulated.to_parquet(tmp_path / "mc.parquet")
    x = rng.exponential(2.0, 6000)
    seen = rng.random(6000) < np.exp(-x / 8)
    pd.DataFrame({"run": 1, "time": x[seen], "v": np.exp(x[seen] / 8)}).to_csv(tmp_path / "data.csv", index=False)
    return tmp_path, simulated


def test_a_fit_from_a_bank_with_weights_on_both_sides_is_that_of_python(files, done):
    folder, simulated = files
    asked = ["--simulated", folder / "mc.parquet", "--theta-columns", "mean", "--weights", "w"]
    asked += ["--data", folder / "data.csv", "--columns", "time", "--data-weights", "v", "--out", folder / "fit.json"]
    done("infer", *asked)
    fit = json.loads((folder / "fit.json").read_text())
    with pytest.warns(UserWarning, match="kept"):
        x = av.unweighted(av.read_events(str(folder / "data.csv"), ["time", "v"]), "v")
    assert fit["theta"] == av.infer(av.bank(simulated, theta=["mean"], weights="w"), x, progress=False).theta
    assert abs(fit["theta"]["mean"] - 2) < 4 * fit["std"]["mean"] < 0.4


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("--data d.csv", "--task, or events that it made by --simulated"),
        ("--task poisson --simulated mc.csv --data d.csv", "one of the two"),
        ("--task poisson", "--data, or published tables by --table"),
        ("--task poisson --data d.csv --weights w", "columns of --simulated"),
        ("--task poisson --data d.csv --density", "are of --table"),
        ("--task poisson --data d.csv --columns a --columns b,a", "--columns names 'a' twice"),
        ("--task poisson --table t.csv --data-weights w", "columns of --data"),
        ("--task poisson --table t.csv --columns a,b", "2 for 1 tables"),
        ("--joint sets.toml --data d.csv", "leave --data out"),
        ("--joint sets.toml --columns n", "leave --columns out"),
    ],
)
@pytest.mark.parametrize("command", ["infer", "diagnose"])
def test_what_does_not_go_together_is_refused_before_anything_is_read(command, asked, said, avobench, tmp_path):
    status, _, told = avobench(command, *asked.split(), "--out", tmp_path / "out")
    assert (status, told.count("\n"), said in told) == (2, 1, True), told
