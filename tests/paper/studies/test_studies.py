"""Small studies: each makes what it says, an interrupted one goes on, and its table counts what there is."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from avobench.tasks.function import task
from paper.figures import misspecification as drawing
from paper.hard_tasks import Bump
from paper.studies import agreement, detector, few, hard, misspecification, saturation


def test_what_is_lacking_is_made_and_counted(tmp_path, monkeypatch):
    mean = task(lambda theta, rng: rng.normal(theta[:, 0], 1), prior={"mean": (-2, 2)}, name="mean")
    right = agreement.Case(mean, lambda n, rng: rng.normal(0.3, 1, (n, 1)), ((200, 600),), sound=True)
    wrong = agreement.Case(mean, lambda n, rng: rng.choice([-1.0, 1.0], (n, 1)), ((200, 600),))
    monkeypatch.setattr(agreement, "cases", lambda: {"right": right})
    first = agreement.made(tmp_path / agreement.FILE.name, num_seeds=2)["fits"]
    monkeypatch.setattr(agreement, "cases", lambda: {"right": right, "wrong": wrong})
    record = agreement.made(tmp_path / agreement.FILE.name, num_seeds=2)
    assert record["fits"][:2] == first
    assert agreement.FILE.read(tmp_path) == record
    assert agreement.table([record])["doubted"].tolist() == [0, 2]


def test_errors_that_hold_have_an_rms_of_one_and_what_is_off_without_a_doubt_is_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(few, "METHODS", ("smm",))
    monkeypatch.setattr(few, "EVENTS", (300,))
    record = few.made(path := tmp_path / few.FILE.name, num_fits=2, budget=4000)
    assert few.made(path, num_fits=2, budget=4000) == record
    rows = few.table([record]).set_index("task")
    assert rows["fits"].tolist() == [2, 2, 2]
    assert rows.loc["poisson", "rms"] < 3
    fit = {"task": "t", "events": 1, "method": "m"}
    off = [fit | {"off": [4, 0.0], "doubt": ""}, fit | {"off": [5, 0.0], "doubt": "d"}]
    [row] = few.table([{"fits": off}]).to_dict("records")
    assert (row["silent"], row["doubted"], row["bias"]) == (1, 1, 2.25)
    assert row["rms"] == pytest.approx((41 / 4) ** 0.5)


def test_what_is_lacking_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr(hard, "METHODS", {"smm": ("smm", {})})
    monkeypatch.setattr(hard, "DEVELOPMENT_TARGETS", 1)
    small = {"tasks": (Bump,), "num_events": 300, "budget": 2000}
    path = tmp_path / hard.FILE.name
    first = hard.made(path, num_targets=1, **small)["fits"]
    record = hard.made(path, num_targets=2, **small)
    assert record["fits"][:1] == first
    assert hard.FILE.read(tmp_path) == record
    assert hard.table([record])["targets"].tolist() == ["seen", "unseen"]


def test_the_table_counts_what_is_far_off_without_a_doubt():
    def fit(off, error, doubt):
        kept = {"task": "bump", "target": 0, "method": "avo", "theta": [0.0, 0.0], "floors": [1.0, 4.0], "seconds": 1.0}
        return {**kept, "estimate": [0.0, off], "error": [1.0, error], "doubt": doubt}

    fits = [fit(2.0, 2.0, ""), fit(20.0, 2.0, "d"), fit(20.0, 20.0, ""), fit(20.0, 2.0, "")]
    [row] = hard.table([{"fits": fits}]).to_dict("records")
    assert row["error / floor"] == "1, 1e+02 D, 1e+02, 1e+02"
    assert (row["far"], row["undoubted"], row["silent"]) == (3, 2, 1)
    assert row["rms pull"] == pytest.approx(((1 + 100 + 1 + 100) / 8) ** 0.5)


def test_a_discriminator_is_looked_at_on_its_way(tmp_path, monkeypatch):
    monkeypatch.setattr(saturation, "NUM_OBSERVATIONS", 1000)
    record = saturation.made(tmp_path / saturation.FILE.name, iterations=(0, 2), num_targets=1)
    assert saturation.FILE.read(tmp_path) == record
    for run in record["runs"]:
        assert 0 < run["largest"][0] < run["largest"][1]  # an untrained network says next to nothing
        assert run["share"][0] == 0
    assert saturation.table([record])["no gradient"].tolist()[::2] == [0, 0]


def test_the_proposal_widens_with_what_varies(tmp_path, monkeypatch):
    monkeypatch.setattr(misspecification, "METHOD", replace(misspecification.METHOD, iterations=100))
    monkeypatch.setattr(misspecification, "TASKS", ("poisson",))
    monkeypatch.setattr(misspecification, "STRENGTHS", (0.0, 0.3))
    monkeypatch.setattr(misspecification, "REPETITIONS", 1)
    monkeypatch.setattr(misspecification, "one", partial(misspecification.one, num_events=5_000, budget=8_000))
    record = misspecification.made(tmp_path / misspecification.FILE.name)
    calm, varied = record["runs"]
    assert calm["p_value"] > 1e-4 > varied["p_value"]
    assert varied["width"][0] > 2 * calm["width"][0]
    assert drawing.medians(record)["width"].tolist() == [calm["width"][0], varied["width"][0]]
    drawing.drawn([record])


def test_the_response_is_made_once(tmp_path, monkeypatch):
    path = tmp_path / detector.FILE.name
    record = detector.made(path, num_events=60)
    for response in record["responses"]:
        mean = np.array(response["mean"])
        assert mean.shape == (1024,)
        np.testing.assert_allclose(mean * 60, np.round(mean * 60))
        assert [bool(event) for event in response["events"]] == [True] * 3
        assert (mean[np.unique(np.concatenate(response["events"]))] > 0).all()
    assert record["responses"][0]["events"] != record["responses"][1]["events"]
    monkeypatch.setattr(detector.Alignment, "simulate", None)
    assert detector.made(path, num_events=60) == record == detector.FILE.read(tmp_path)
    with pytest.raises(TypeError):  # other events would have to be simulated
        detector.made(path, num_events=61)
