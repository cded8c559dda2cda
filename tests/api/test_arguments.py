"""Whatever is given to the functions that `import avobench` offers is used, or refused in a line."""

import inspect

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.tasks.errors import AvobenchError


class Reached(Exception):
    """All arguments were taken."""


class Speechless:
    def __repr__(self):
        raise RuntimeError


def simulate(theta, rng):
    return rng.normal(theta[:, 0])


RNG = np.random.default_rng(0)
THETAS = RNG.uniform(-1, 1, (8, 1))
TABLE = avobench.Table([-4, 0, 4], [50.0, 50.0])
WRONG = (
    *(object(), Speechless(), "a", b"a", 1j, -1, 0, 2.5, float("nan"), True, None, Exception, lambda *given: 0),
    *([object()], ["a"], [[1, 2], [3]], (1,), {"a": object()}, {1: (0, 1)}, {"a": (0, 1)}, {"a"}),
    *(np.array("a"), np.array([1 + 1j]), pd.DataFrame({"a": ["b", "c"]}), range(3)),
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Arguments with which each function works at once, or nearly so."""
    folder = tmp_path_factory.mktemp("sound")
    task = avobench.task(simulate, prior={"mean": (-1, 1)}, features=["x"], name="sound")
    x = simulate(np.zeros((300, 1)), RNG)
    np.save(folder / "x.npy", x)
    (folder / "table.csv").write_text("low,high,value\n0,1,5\n1,2,7\n")
    fit = avobench.infer(task, x, "smm", budget=2000).save(folder / "fit.json")
    sweep = {"tasks": "toys:Normal", "methods": "toys:Moment", "targets": "0", "budget": 400, "observations": 100}
    sweep |= {"results": folder / "results", "workers": avobench.Workers(in_process=True)}
    avobench.run(**sweep)
    return {
        "bank": {"events": x},
        "calibrate": {"task": task, "n": 1, "events": 100, "budget": 400, "progress": False},
        "compare_tables": {"tables": TABLE, "events": x},
        "diagnose": {"task": task, "x": x, "progress": False},
        "fit_tables": {"tables": TABLE, "theta": THETAS, "simulated": [RNG.normal(t, 1, 200) for t in THETAS]},
        "infer": {"task": task, "x": x, "method": "smm", "budget": 2000, "progress": False},
        "joint": {"sets": {"near": (task, x), "far": (task, x)}},
        "list_effects": {"task": "poisson"},
        "load": {"path": fit},
        "read_events": {"path": str(folder / "x.npy")},
        "read_table": {"source": folder / "table.csv"},
        "records": {"results": folder / "results"},
        "run": sweep,
        "task": {"simulate": simulate, "prior": {"mean": (-1, 1)}},
        "unweighted": {"events": x, "weights": np.ones(300)},
    }


PARAMETERS = [
    (name, each.name)
    for name in avobench.__all__
    if inspect.isfunction(function := getattr(avobench, name))
    for each in inspect.signature(function).parameters.values()
    if each.kind is not each.VAR_KEYWORD
]


@pytest.mark.parametrize(("name", "parameter"), PARAMETERS)
def test_what_is_wrong_is_refused_in_a_line(sound, name, parameter, monkeypatch, tmp_path):
    def reached(*arguments, **options):
        raise Reached

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("avobench.diagnosis.run.diagnose", reached)
    monkeypatch.setattr("avobench.api.sweep.carried_out", reached)
    monkeypatch.setattr("avobench.api.inference.DEFAULTS", ("smm",))
    for value in WRONG:
        said = "used"
        try:
            getattr(avobench, name)(**sound[name] | {parameter: value})
        except Reached:
            pass
        except AvobenchError as error:
            said = str(error)
        assert len(said.splitlines()) == 1, (value, said)


@pytest.mark.parametrize(("name", "value"), [("alpha", "a"), ("alpha", True), ("effects", 1), ("fit", b"surrogate")])
def test_a_wrong_type_is_named(sound, name, value):
    with pytest.raises(avobench.UsageError, match=rf"{name} of avobench\.diagnose must be .*, got {value!r}"):
        avobench.diagnose(**sound["diagnose"] | {name: value})


def test_numbers_of_numpy_and_whole_floats_are_numbers(sound):
    given = sound["infer"] | {"budget": 2e3, "seed": np.int64(1), "drop_invalid": np.True_, "settings": {}}
    assert avobench.infer(**given).num_simulations <= 2000
