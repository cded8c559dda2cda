"""Reading `model.json`: what it may say, and what of it is run."""

import json
import pickle
import sys

import numpy as np
import pytest

import avobench
from avobench.bench.events.checks import check_events
from avobench.bench.plugins import registry
from avobench.effects.model_file import AugmentedTask, ModelFile
from avobench.tasks.errors import UsageError

MODEL = {
    "kind": "avobench-model",
    "schema_version": 1,
    "name": "poisson-dead-time",
    "task": "poisson",
    "task_settings": {},
    "effects": [
        {"name": "dead_time", "feature": None, "shape": "paralysable", "source": None, "settings": {"highest": 0.5}}
    ],
    "parameters": [
        {"name": "log_rate", "unit": "1", "value": 1, "std": 0.1, "prior": [0, 4], "support": [-10, 10]},
        {"name": "tau", "unit": "of the window", "value": 0.1, "std": 0.1, "prior": [0, 0.2], "support": [0, 0.5]},
    ],
}
EVIL = """
from pathlib import Path

from avobench.effects.counts.exposure import Inefficiency
from avobench.tasks.poisson import Poisson

Path(__file__).with_name("ran").touch()


class Evil(Poisson):
    name = "evil"


class EvilEffect(Inefficiency):
    name = "dead_time"
    shape = "paralysable"
    SHAPES = {"paralysable": ()}
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A function that writes a model with changes, beside code that leaves a trace when it is run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "evil.py").write_text(EVIL)

    def write(**changes):
        (tmp_path / "model.json").write_text(json.dumps(MODEL | changes))
        return "model.json"

    yield write
    sys.modules.pop("evil", None)
    sys.path[:] = [folder for folder in sys.path if folder != str(tmp_path)]


def with_effect(**changes):
    return {"effects": [MODEL["effects"][0] | changes]}


def with_tau(**changes):
    return {"parameters": [MODEL["parameters"][0], MODEL["parameters"][1] | changes]}


def test_a_model_is_a_task(written):
    task = registry.build("task", written(), {})
    assert (task.name, task.parameter_names) == ("poisson-dead-time", ("log_rate", "tau"))
    assert task.model.effects[0].highest == 0.5
    assert task.simulate(np.tile([2.0, 0.1], (5, 1)), np.random.default_rng(0)).shape == (5, 1)
    assert "task_source_sha256" not in registry.identity("task", "model.json", task)


FOREIGN = (
    {"task": "evil:Evil"},
    {"task": "evil.py:Evil"},
    {"task": {**MODEL, "task": "evil:Evil"}, "effects": [], "parameters": MODEL["parameters"]},
    with_effect(source="evil:EvilEffect", settings={}),
    with_effect(source="./evil.py:EvilEffect", settings={}),
)


@pytest.mark.parametrize("changes", FOREIGN)
def test_code_that_a_model_names_is_not_run_unless_the_file_is_trusted(written, tmp_path, changes):
    path = written(**changes)
    with pytest.raises(UsageError, match="reading it would run that code") as raised:
        registry.build("task", path, {})
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "ran").exists()
    task = registry.build("task", registry.trusted(path), {})
    assert (tmp_path / "ran").exists()
    assert "task_source_sha256" in registry.identity("task", path, task)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"task": "nothing"}, "names task 'nothing', which is not installed"),
        ({"task": "model.json"}, "names task 'model.json', which is not installed"),
        ({"task": "../../etc/passwd"}, "which is not installed"),
        (with_effect(source="nothing"), "names effect 'nothing', which is not installed"),
        (with_tau(prior=[0.2, 0]), "low < high"),
        (with_tau(support=[1, 1]), "low < high"),
        (with_tau(prior=[0, float("inf")]), "finite low < high"),
        ({"parameters": MODEL["parameters"][:1]}, "gives 1 parameters to a model of 2"),
    ],
)
def test_what_makes_no_model_is_said_in_a_line_trusted_or_not(written, changes, said):
    path = written(**changes)
    for spec in (path, registry.trusted(path)):
        with pytest.raises(UsageError, match=said):
            registry.build("task", spec, {})


@pytest.mark.parametrize("name", ["../../x", "a/b", "", ".hidden", "a\nb", "with space", "poisson\n", "naïve"])
def test_the_name_in_a_file_is_checked_as_that_of_a_class_is(written, name):
    with pytest.raises(UsageError, match=r"is not a model: .* at name"):
        registry.build("task", written(name=name), {})
    with pytest.raises(UsageError, match=r"is not a model: .* at task.*name"):
        registry.build("task", written(task=MODEL | {"name": name}), {})
    with pytest.raises(UsageError, match=r"is not a model: .* at effects.0.name"):
        registry.build("task", written(**with_effect(name=f"{name}/")), {})


def test_trust_reaches_worker_processes(written):
    path = registry.trusted(written(task="evil:Evil"))
    there = pickle.loads(pickle.dumps({"task": path}))["task"]
    assert there == path
    assert registry.build("task", there, {}).model.task.name == "evil"


@pytest.mark.parametrize("kind", ["continuous", "integer"])
def test_a_model_of_a_program_starts_it_at_as_few_thetas_as_the_task_and_at_whole_ones_if_it_must(kind):
    started = []

    def program(theta, n, rng):
        started.append(theta[0])
        return rng.normal(theta[0], 1, n)

    task = avobench.task(program, prior={"m": (0, 8)}, kinds={"m": kind}, name="program", per_theta=True)
    m = {"name": "m", "unit": "1", "value": 4, "std": 1, "prior": [0, 8], "support": [0, 8]}
    model = AugmentedTask.of(ModelFile(**{**MODEL, "task": "program", "effects": [], "parameters": [m]}), task, None)
    numbers = []
    for one in (task, model):
        started.clear()
        check_events(one, np.random.default_rng(0).normal(4, 1, 1000))
        numbers.append(len(started))
        assert kind == "continuous" or not np.mod(started, 1).any()
    assert numbers[0] == numbers[1]
