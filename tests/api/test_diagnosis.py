"""What a diagnosis shows and keeps."""

import runpy
import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.bench.plugins.source import as_module


def simulate(theta, rng):
    phase = rng.uniform(0, 1, len(theta))
    return np.stack([phase, rng.normal(theta[:, 0], 1)], axis=1)


@pytest.fixture(scope="module")
def found():
    """An excess in the second of two features."""
    task = avobench.task(simulate, prior={"mean": (-1, 1)}, features=["phase", "log_energy"], name="burst")
    x = simulate(np.full((4000, 1), 0.2), np.random.default_rng(3))
    x[:400, 1] = np.random.default_rng(4).normal(2.5, 0.1, 400)
    return avobench.diagnose(task, x, simulations=3_000_000, effects=["peak_background"])


def test_the_picture_is_of_the_feature_on_which_the_effect_is(found):
    assert found.diagnosis.effects[0].feature == "log_energy"
    assert "log_energy" in [axis.get_xlabel().split(" ")[0] for axis in found.plot().axes]


def assert_same_events(model, other):
    theta = np.tile(model.prior.center, (50, 1))
    x, y = (each.simulate(theta, np.random.default_rng(0)) for each in (model, other))
    assert np.array_equal(x, y)


@pytest.fixture(scope="module")
def saved(found, tmp_path_factory):
    """The folder of the diagnosis, with a title that is no text."""
    folder = tmp_path_factory.mktemp("saved")
    found.save(folder, title=b"caf\xe9.csv".decode(errors="surrogateescape"))
    return folder


def test_what_was_saved_is_read_again_without_running_code(found, saved):
    assert "caf?.csv" in (saved / "report.html").read_text()
    again = avobench.load(saved)
    assert again.details() == found.details()
    assert again.effects.equals(found.effects)
    drawn, shown = ([line.get_xydata() for line in each.plot().axes[0].lines] for each in (again, found))
    assert all(np.array_equal(a, b) for a, b in zip(drawn, shown, strict=True))
    with pytest.raises(avobench.UsageError, match="trust=True"):
        _ = again.model
    with pytest.raises(avobench.UsageError, match="copy that folder"):
        again.save(saved)


def test_the_model_of_a_function_is_found_again_with_its_function(found, saved):
    """The task was made in a function, so that it has no name: its simulator goes along in a file."""
    model = avobench.load(saved / "model.json", trust=True)
    assert_same_events(model, found.model)
    assert model.content.task == f"{saved / 'task.py'}:task"
    x = model.simulate(np.tile(model.prior.center, (50, 1)), np.random.default_rng(1))
    again = avobench.infer(model, x, "smm", budget=5000)
    assert list(again.theta) == list(model.parameter_names)


def test_a_simulator_that_no_file_could_hold_is_named_in_a_warning(found, tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.reports.diagnosis.write", lambda *given: [])
    task = avobench.task(lambda theta, rng: simulate(theta, rng), prior={"mean": (-1, 1)}, name="burst")
    with pytest.warns(UserWarning, match=r"no model\.json: another process does not find the simulator of burst"):
        replace(found, result=replace(found.result, task=task)).save(tmp_path)
    assert avobench.load(tmp_path).verdict == found.verdict


SCRIPT = """
from __future__ import annotations
import dataclasses
import sys
import numpy as np
import avobench

WIDTH = 0.1

@dataclasses.dataclass
class Bump(avobench.Effect):
    centre: float = 0.0
    name, feature, sentence, source = "bump", 0, "A bump.", "test"
    parameters = (avobench.Parameter("share", 0, 0.5, 0, "1"),)

    def apply(self, simulate, theta, phi, rng: Nothing):
        x = simulate(theta, rng)
        return np.where(rng.random(x.shape) < phi, rng.normal(self.centre, WIDTH, x.shape), x)

if __name__ == "__main__":
    def sim(theta, rng):
        return rng.normal(theta[:, 0], 1)
    task = avobench.task(sim, prior={"mean": (-1, 1)})
    x = np.r_[np.random.default_rng(0).normal(0, 1, 900), np.random.default_rng(1).normal(2.5, WIDTH, 100)]
    given = dict(own=[Bump(2.5)], effects=["scale"], simulations=60_000, progress=False)
    found = avobench.diagnose(task, x, **given)
    found.save(sys.argv[1])
"""


def test_an_effect_of_a_script_is_found_again_with_its_settings(tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.reports.diagnosis.write", lambda *given: [])
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(SCRIPT)
    monkeypatch.setattr(sys, "argv", ["script.py", str(out)])
    found = runpy.run_path(str(script), run_name="__main__")["found"]
    model = avobench.load(out, trust=True).model
    assert [each.name for each in model.content.effects] == ["bump"]
    assert_same_events(model, found.model)


SMEAR = """
from avobench import Effect, Parameter


class Smear(Effect):
    name, sentence, source = "smear", "is smeared", "a test"
    parameters = (Parameter("sigma", 0, 2, 0, "1"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        return x + phi * rng.normal(size=x.shape)
"""


def test_a_model_is_diagnosed_and_extended_in_turn(tmp_path, monkeypatch):
    """By an effect of a file in the working folder: normal events of a variance of 2 in place of 1."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "smears.py").write_text(SMEAR)
    task = avobench.task(lambda theta, rng: rng.normal(theta), prior={"mean": (-2, 2)}, features=["e"], name="normal")
    x, how = np.random.default_rng(0).normal(0, 2**0.5, 1000), {"effects": [], "simulations": 60_000, "progress": False}
    model = avobench.diagnose(task, x, own=["smears.py:Smear"], **how).model
    assert model.parameter_names == ("mean", "smear_sigma")
    theta = np.tile([0.5, 1.0], (50_000, 1))
    further = avobench.diagnose(model, x, **how).model
    assert further.parameter_names == model.parameter_names
    for each in (model, further):
        y = each.simulate(theta, np.random.default_rng(1))
        assert (y.mean(), y.var()) == pytest.approx((0.5, 2), abs=0.1)  # at least five standard errors


def test_a_file_of_the_user_is_not_replaced(found, tmp_path):
    (tmp_path / "task.py").write_text("# the thesis\n")
    with pytest.raises(avobench.UsageError, match=r"task\.py is not of a diagnosis"):
        found.save(tmp_path)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["# the thesis\n"]


def test_the_code_of_a_notebook_is_that_of_its_cells(monkeypatch):
    notebook = ModuleType("notebook")
    notebook.In = ["import numpy as np", "%matplotlib inline", "RATE = 2\nout = 1 / 0", "def sim(*_):\n    return RATE"]
    exec(notebook.In[-1], vars(notebook))
    monkeypatch.setitem(sys.modules, "notebook", notebook)
    exec(as_module("notebook", {"sim"}), home := {})
    assert home["sim"](None, None) == 2


def test_two_samples_are_compared_and_the_sample_with_the_effect_is_written(tmp_path):
    rng = np.random.default_rng(0)
    simulated = pd.DataFrame({"time": rng.exponential(2.0, 30_000)})
    measured = pd.DataFrame({"run": 1, "time": np.r_[rng.exponential(2.0, 2000), rng.normal(6, 0.1, 200)]})
    found = avobench.diagnose(simulated, measured, effects=["peak_background"], progress=False)
    assert found.effects["effect"].unique().tolist() == ["peak_background"]
    assert found.effects.set_index("parameter").loc["fraction", "value"] == pytest.approx(200 / 2200, abs=0.03)
    assert found.diagnosis.num_simulations == 30_000
    found.save(tmp_path)
    written = pd.read_parquet(tmp_path / "simulated.parquet")
    assert written["avobench weight"].sum() == pytest.approx(30_000)
    share, expected = (each["time"].between(5.7, 6.3).mean() for each in (written, measured))
    assert share == pytest.approx(expected, abs=0.02)
    assert not (tmp_path / "model.json").exists()
