"""The paper's single experiments are run with its numbers, and kept like any other cell."""

import numpy as np
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.store.store import Store
from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks.errors import StoreError
from paper.studies import paper as study
from paper.study import study as command


@pytest.mark.parametrize(("name", "iterations", "runs"), [("poisson", 3000, 20), ("alignment", 5000, 2)])
def test_a_study_has_the_papers_number_of_iterations(name, iterations, runs):
    cells = study.cells(name)
    assert len({cell.id for cell in cells}) == runs
    for cell in cells:
        assert cell.budget == iterations * cell.build_method().events_per_iteration


def test_the_poisson_example_is_that_of_section_4_1():
    cell = study.cells("poisson")[0]
    method, task = cell.build_method(), cell.build_task()
    assert task.targets()[0, 0] == pytest.approx(1.94591, abs=1e-5)
    assert (method.hidden, method.batch_size, method.r1, method.learning_rate) == ((20, 20, 20), 32, 10, 1e-3)
    assert (method.initial_mean, method.initial_std, method.proposal_learning_rate) == (0, 0.5, 1e-3)
    assert sorted({cell.build_method().entropy for cell in study.cells("poisson")}) == [0, 1e-4, 1e-2]


@pytest.mark.parametrize("name", ["poisson", "alignment"])
def test_the_proposal_moves_in_theta_itself(name):
    """So that the paper's start and learning rate mean what they say."""
    task = study.cells(name)[0].build_task()
    theta = np.array([[-1.0], [0.0], [2.0]])
    np.testing.assert_allclose(TruncatedGaussian(task.prior, task.support).to_standard(theta), theta, atol=1e-12)
    assert np.isfinite(task.floor(task.targets()[0], 100_000, 160_000))


def test_the_row_sums_are_those_of_the_average_image():
    task, other = study.AlignmentRows(), study.Alignment()
    x = np.random.default_rng(0).integers(0, 2, (5, 1024)).astype(np.uint8)
    np.testing.assert_allclose(task.summary(x), other.summary(x).reshape(32, 32).sum(axis=1))
    np.testing.assert_array_equal(task.targets(), other.targets())
    assert task.floor(task.targets()[0], 10, 10) == other.floor(task.targets()[0], 10, 10)
    assert {(cell.identity["task"], cell.target) for cell in study.cells("summary")} == {
        ("alignment-rows", target) for target in range(study.SUMMARY_TARGETS)
    }


def test_another_seed_is_another_study():
    assert not {cell.id for cell in study.cells("poisson", 1)} & {cell.id for cell in study.cells("poisson")}


def test_the_detectors_response_is_made_once(tmp_path, monkeypatch):
    path = tmp_path / study.DETECTOR_FILE
    record = study.detector(path, num_events=60)
    for response in record["responses"]:
        mean = np.array(response["mean"])
        assert mean.shape == (1024,)
        np.testing.assert_allclose(mean * 60, np.round(mean * 60))
        assert [bool(event) for event in response["events"]] == [True] * 3
        assert (mean[np.unique(np.concatenate(response["events"]))] > 0).all()
    assert record["responses"][0]["events"] != record["responses"][1]["events"]
    monkeypatch.setattr(study.Alignment, "simulate", None)
    assert study.detector(path, num_events=60) == record
    assert study.read_detector(tmp_path) == record
    with pytest.raises(TypeError):  # other events would have to be simulated
        study.detector(path, num_events=61)


def test_a_damaged_or_missing_response_is_told(tmp_path):
    with pytest.raises(StoreError, match="study detector"):
        study.read_detector(tmp_path)
    (tmp_path / study.DETECTOR_FILE).write_text("{}")
    with pytest.raises(StoreError, match="truncated"):
        study.read_detector(tmp_path)


def test_the_command_makes_what_lacks(run, tmp_path, monkeypatch):
    spec = "paper.studies.paper:PoissonExample"
    cells = [Cell(spec, {}, "avo-paper", {"hidden": [4], "schedule": "shared"}, 0, n, 64, 100, 0) for n in range(2)]
    monkeypatch.setattr(study, "cells", lambda name, seed: cells)
    for _ in range(2):
        code, out, err = run(command, "poisson", "--results", tmp_path / "s", "-j", 1)
        assert code == 0, err
        assert "poisson-example" in out
    assert len(Store(tmp_path / "s").sweeps()) == 1
    assert run(command, "poisson", "--results", tmp_path / "s", "-j", 0)[0] == 2
    cells += [Cell(spec, {}, "avo-paper", {"hidden": [4]}, 0, 0, 10, 100, 0)]  # less than one iteration
    code, out, err = run(command, "poisson", "--results", tmp_path / "s", "-j", 1)
    assert (code, "1 of 3 cells failed" in err) == (1, True), err
