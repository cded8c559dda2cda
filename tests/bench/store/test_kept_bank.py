"""A bank in a folder is read again, belongs to one simulator, and says what is wrong with it."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import pytest

import avobench
from avobench.bench.store.kept_bank import KeptBank
from avobench.effects.model_file import AugmentedTask, ModelFile
from avobench.tasks.carl import Carl
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task
from avobench.tasks.joint import JointTask
from avobench.tasks.meter import Meter
from avobench.tasks.poisson import Poisson

THETA = np.tile([[2.0]], (50, 1))
OPENED = """
import sys
from pathlib import Path
from avobench.bench.store.kept_bank import KeptBank
from avobench.tasks.meter import Meter
from avobench.tasks.poisson import Poisson
KeptBank(Poisson(), Meter(), 0, 1, Path(sys.argv[1]))
"""


@dataclass(frozen=True)
class Shifted(Poisson):
    """A task with settings, one of them none that a file of JSON can hold as it is."""

    shift: float = 0.0
    table: np.ndarray = field(default_factory=lambda: np.zeros(2))

    def simulate(self, theta, rng):
        return super().simulate(theta, rng) + int(self.shift)


def taken(folder, task=None):
    meter = Meter()
    x = KeptBank(task or Poisson(), meter, 0, 1, folder).session()(THETA, np.random.default_rng(0))
    return x, meter.used


def test_what_was_simulated_costs_nothing_later(tmp_path):
    (first, cost), (again, later) = taken(tmp_path), taken(tmp_path)
    np.testing.assert_array_equal(first, again)
    assert first.dtype == again.dtype
    assert (cost, later) == (50, 0)


def test_two_that_simulate_into_one_folder_lose_and_double_nothing(tmp_path):
    banks = [KeptBank(Poisson(), Meter(), 0, 1, tmp_path) for _ in range(2)]
    banks[0].session()(THETA, np.random.default_rng(0))
    with pytest.raises(UsageError, match="since it was read"):
        banks[1].session()(2 * THETA, np.random.default_rng(0))
    run = partial(subprocess.run, [sys.executable, "-c", OPENED, tmp_path], capture_output=True, text=True)
    assert "another process simulates into" in run().stderr
    del banks
    assert run().returncode == 0
    assert taken(tmp_path)[1] == 0


def test_threads_of_one_process_may_use_a_folder_in_turn(tmp_path):
    bank = KeptBank(Poisson(), Meter(), 0, 1, tmp_path)
    bank.session()(THETA, np.random.default_rng(0))
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(taken, tmp_path).result()[1] == 0


def joined(shift):
    made = task(lambda theta, rng: theta[:, 0] + shift, prior={"mu": (0, 9)}, name="one")
    return JointTask({"one": made, "two": made}, shared=["mu"])


def model(shape):
    """Poisson counts with a dead time."""
    effect = {"name": "dead_time", "feature": None, "shape": shape, "source": None, "settings": {}}
    each = {"unit": "1", "value": 0.2, "std": 0.1, "prior": (0, 0.5), "support": (0, 0.5)}
    parameters = [{"name": name, **each} for name in ("log_rate", "tau")]
    content = {"name": "model", "task": "poisson", "task_settings": {}, "effects": [effect], "parameters": parameters}
    return AugmentedTask.of(ModelFile.model_validate(content), Poisson(), None)


def sample(last):
    return avobench.bank(np.append(np.random.default_rng(0).normal(size=3000), last))


PAIRS = {
    "task": (Poisson(), Carl()),
    "setting": (Shifted(), Shifted(shift=1.0)),
    "table": (Shifted(), Shifted(table=np.ones(2))),
    "data sets": (joined(0.0), joined(1.0)),
    "model": (model("paralysable"), model("non_paralysable")),
    "sample": (sample(0.0), sample(1.0)),
}


@pytest.mark.parametrize("of", PAIRS)
def test_events_of_another_simulator_are_refused_though_it_has_the_same_name(tmp_path, of):
    one, other = PAIRS[of]
    KeptBank(one, Meter(), 0, 1, tmp_path)
    with pytest.raises(UsageError, match="another simulator"):
        KeptBank(other, Meter(), 0, 1, tmp_path)


@pytest.mark.parametrize("make", [lambda: Shifted(shift=0), lambda: joined(0.0)], ids=["setting", "data sets"])
def test_those_of_the_same_simulator_are_taken_though_it_was_made_anew(tmp_path, make):
    assert [taken(tmp_path, make())[1] for _ in range(2)] == [50, 0]


def test_no_file_is_written_over_where_another_was_deleted(tmp_path):
    for rate in (1.0, 2.0, 3.0):
        KeptBank(Poisson(), Meter(), 0, 1, tmp_path).session()(rate * THETA, np.random.default_rng(0))
    files = sorted(tmp_path.glob("events-*.parquet"))
    files[0].unlink()
    KeptBank(Poisson(), Meter(), 0, 1, tmp_path).session()(0.5 * THETA, np.random.default_rng(0))
    assert len(list(tmp_path.glob("events-*.parquet"))) == 3


def test_many_files_become_few_and_an_end_in_between_loses_and_doubles_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.bench.store.kept_bank.MERGED", 4)
    rates = np.linspace(0.5, 3, 10)

    def filled():
        bank = KeptBank(Poisson(), meter := Meter(), 0, 1, tmp_path)
        return [bank.session()(np.tile(rate, (50, 1)), np.random.default_rng(0)) for rate in rates], meter.used

    def interrupted(path):
        raise KeyboardInterrupt

    with monkeypatch.context() as ending:
        ending.setattr("pathlib.Path.unlink", interrupted)
        with pytest.raises(KeyboardInterrupt):
            filled()
    assert len(list(tmp_path.glob("events-*.parquet"))) == 5
    (first, cost), (again, later) = filled(), filled()
    assert (cost, later) == (300, 0)
    assert len(list(tmp_path.glob("events-*.parquet"))) == 4  # two merged, and two that are fewer than four
    np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize("how", ["cut", "link", "lost", "other"])
def test_a_damaged_bank_is_named(tmp_path, how):
    folder = tmp_path / "bank"
    taken(folder)
    file = next(folder.glob("events-*.parquet"))
    if how == "cut":
        file.write_bytes(file.read_bytes()[:100])
    elif how == "link":
        file.rename(tmp_path / "elsewhere")
        file.symlink_to(tmp_path / "elsewhere")
    elif how == "other":
        file = file.rename(folder / "events-mine.parquet")
    else:
        file = folder / "bank.json"
        file.unlink()
    with pytest.raises(UsageError, match=file.name):
        taken(folder)
