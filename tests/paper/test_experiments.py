"""The grid: what each experiment compares, whose committed records are found, and that the command makes the rest."""

import json
from pathlib import Path

import numpy as np
import pytest

from avobench.bench.plugins import registry
from avobench.bench.store.store import Store
from avobench.methods.abc_smc import AbcSmcTuned
from avobench.methods.avo_paper import AvoPlain
from avobench.methods.bolfi import BolfiTuned
from avobench.methods.proposal import TruncatedGaussian
from paper import experiments, tasks
from paper.experiments import EXPERIMENTS, Experiment, Runs
from paper.study import study

ROOT = Path(__file__).parents[2]


PARTLY = ("fresh",)
"""Experiments of which not all runs were made."""


@pytest.mark.parametrize("name", [name for name in EXPERIMENTS if name != "reference"])
def test_the_committed_records_are_those_of_the_grid(name):
    cells = EXPERIMENTS[name].cells()
    ids = {cell.id for cell in cells}
    assert len(ids) == len(cells)
    assert [(c.repetition, c.target) for c in cells] == sorted((c.repetition, c.target) for c in cells)
    folder = EXPERIMENTS[name].folder
    kept = {record["id"] for record in Store(ROOT / folder).read_all(traces=False)}
    sharing = [each for other, each in EXPERIMENTS.items() if each.folder == folder and other != name]
    assert kept <= ids | {cell.id for each in sharing for cell in each.cells()}
    assert ids <= kept or name in PARTLY


@pytest.mark.parametrize(("name", "iterations"), [("poisson", 3000), ("alignment", 5000)])
def test_an_example_of_the_paper_has_its_iterations_and_moves_in_theta_itself(name, iterations):
    cell = EXPERIMENTS[name].cells()[0]
    task = cell.build_task()
    assert cell.budget == iterations * cell.build_method().events_per_iteration
    theta = np.array([[-1.0], [0.0], [2.0]])
    np.testing.assert_allclose(TruncatedGaussian(task.prior, task.support).to_standard(theta), theta, atol=1e-12)
    assert np.isfinite(task.floor(task.targets()[0], 100_000, 160_000))
    assert not {c.id for c in EXPERIMENTS[name].cells(1)} & {c.id for c in EXPERIMENTS[name].cells()}


def test_the_row_sums_are_those_of_the_average_image():
    task, other = tasks.AlignmentRows(), tasks.Alignment()
    x = np.random.default_rng(0).integers(0, 2, (5, 1024)).astype(np.uint8)
    np.testing.assert_allclose(task.summary(x), other.summary(x).reshape(32, 32).sum(axis=1))
    np.testing.assert_array_equal(task.targets(), other.targets())
    assert task.floor(task.targets()[0], 10, 10) == other.floor(task.targets()[0], 10, 10)


@pytest.mark.parametrize("task", [*tasks.FRESH, *tasks.FRESH_WARPED])
def test_fresh_targets_are_others_than_the_tasks_own_and_pose_the_same_problem(task):
    own, targets = task.of(), task().targets()
    assert targets.shape == (100, own.prior.dim)
    assert own.prior.contains_all(targets)
    assert not np.isin(targets, own.targets(100)).any()
    assert registry.settings_of(task()) == registry.settings_of(own)
    assert task().floor(targets[0], 1000, 1000) == own.floor(targets[0], 1000, 1000)


@pytest.mark.parametrize("name", tasks.DEVELOPMENT)
def test_no_development_target_is_one_of_the_benchmark(name):
    development, benchmark = tasks.DEVELOPMENT[name](), registry.build("task", name, {})
    assert not np.isin(development.targets(), benchmark.targets()).any()
    assert development.floor_shares == benchmark.floor_shares


@pytest.mark.parametrize(
    ("experiment", "preset"), [("tuning", AbcSmcTuned()), ("tuning", BolfiTuned()), ("sensitivity", AvoPlain())]
)
def test_a_preset_is_one_of_the_candidates(experiment, preset):
    settings = json.loads(json.dumps(registry.settings_of(preset)))
    plain = type(preset).__mro__[1]
    tried = [run.settings for run in EXPERIMENTS[experiment].runs if run.method == plain.name]
    candidates = [registry.settings_of(registry.build("method", plain.name, each)) for each in tried]
    assert any(settings.items() <= json.loads(json.dumps(each)).items() for each in candidates)


def test_the_command_makes_what_lacks(run, tmp_path, monkeypatch):
    def small(budget):
        settings = {"hidden": [4], "schedule": "shared"}
        return Runs("", "avo-paper", settings, (tasks.spec(tasks.PoissonExample),), 1, 2, budget=budget)

    monkeypatch.setattr(experiments, "NUM_OBSERVATIONS", 100)
    grid = Experiment("small", tmp_path / "s", (small(64), small(10)))  # of which 10 is less than one iteration
    monkeypatch.setitem(EXPERIMENTS, "poisson", grid)
    code, out, err = run(study, "poisson", "-j", 1)
    assert (code, "2 of 4 cells failed" in err) == (1, True), err
    monkeypatch.setitem(EXPERIMENTS, "poisson", Experiment("small", tmp_path / "s", (small(64),)))
    code, out, err = run(study, "poisson", "-j", 1)
    assert code == 0, err
    assert "poisson-example" in out
    assert len(Store(tmp_path / "s").sweeps()) == 1
    assert run(study, "poisson", "-j", 0)[0] == 2
