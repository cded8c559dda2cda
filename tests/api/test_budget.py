"""The number of simulated events that is said is the number that a counter in the simulator counts."""

import importlib
import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import avobench
from avobench.bench.plugins.user_files import module_name
from avobench.bench.processes.workers import Workers
from avobench.challenge.make import make
from avobench.challenge.solve import solve
from avobench.cli.main import cli
from avobench.cli.state import State


@pytest.fixture
def counted():
    """A task of decay times, and the numbers of events of each call of its simulator from now on."""
    calls = []

    def decay(theta, rng):
        calls.append(len(theta))
        return rng.exponential(theta[:, 0])

    task = avobench.task(decay, prior={"lifetime": (1, 4)})
    calls.clear()
    return task, calls


MEASURED = np.random.default_rng(0).exponential(2.2, 2000)


@pytest.mark.parametrize(("method", "budget"), [("smm", 300), ("smm", 40_000), ("abc-smc", 4000), ("avo", 2000)])
def test_a_fit_simulates_what_it_says_and_no_more_than_its_budget(counted, method, budget):
    task, calls = counted
    few = {"abc-smc": {"population_size": 20, "events_per_theta": 20}, "avo": {"iterations": 20}}
    found = avobench.infer(task, MEASURED, method, budget=budget, settings=few.get(method, {}))
    assert sum(calls) == found.num_simulations <= budget


def test_a_diagnosis_without_a_limit_simulates_what_it_says(counted):
    """The model in memory and the figure take no further event."""
    task, calls = counted
    x = MEASURED.copy()
    x[:100] = 9.0
    found = avobench.diagnose(task, x, effects=["outliers", "peak_background"])
    assert found.model.num_features == 1
    found.plot()
    assert sum(calls) == found.diagnosis.num_simulations


def test_a_diagnosis_that_is_refused_has_simulated_no_more_than_the_checks_of_its_limit(counted):
    task, calls = counted
    with pytest.raises(avobench.UsageError, match="too few"):
        avobench.diagnose(task, MEASURED, simulations=10_000)
    assert sum(calls) <= 500


COUNTING = """
import numpy as np

import avobench

used = 0


def decay(theta, rng):
    global used
    used += len(theta)
    return rng.exponential(theta[:, 0])


def program(theta, n, rng):
    return decay(np.tile(theta, (n, 1)), rng)


task = avobench.task(decay, prior={"lifetime": (1, 4)})
started = avobench.task(program, prior={"lifetime": (1, 4)}, per_theta=True)
used = 0
"""
TRIED = 600
"""Events with which a sweep tries a user's simulator."""


def said(*command):
    result = CliRunner().invoke(cli, ["--in-process", *map(str, command)], obj=State(), catch_exceptions=False)
    assert result.exit_code == 0
    return result.output


def swept(spec, folder):
    how = {"budget": 600, "observations": 300, "workers": Workers(in_process=True)}
    (row,) = avobench.run(spec, "smm", "0", results=folder, **how).itertuples()
    return TRIED + row.num_observations + row.simulations_used


def swept_by_command(spec, folder):
    command = ["run", "--results", folder, "--task", spec, "--method", "smm", "--targets", "0"]
    said(*command, "--budget", "600", "--observations", "300")
    (row,) = avobench.records(folder).itertuples()
    return TRIED + row.num_observations + row.simulations_used


def diagnosed(spec, folder):
    told = avobench.diagnose(spec, MEASURED, simulations=100_000, effects=["outliers"]).diagnosis.num_simulations
    assert told <= 100_000
    return told


def solved(spec, folder):
    made = make(spec, 1, 0, folder, num_events=500, kinds=("none",))
    solve(folder, options={"num_simulations": 100_000}, trust=True, workers=Workers(in_process=True))
    return made + json.loads((folder / "results" / "0000.json").read_text())["diagnosis"]["num_simulations"]


ENTRIES = {
    "run": swept,
    "avobench run": swept_by_command,
    "check": lambda spec, folder: int(re.search(r"(\d+) simulated events", said("check", "task", spec))[1]),
    "make": lambda spec, folder: make(spec, 2, 0, folder, num_events=500, kinds=("none", "own")),
    "solve": solved,
    "calibrate": lambda spec, folder: avobench.calibrate(spec, n=2, events=300, budget=600).num_simulations,
    "infer": lambda spec, folder: avobench.infer(spec, MEASURED, "smm", budget=600).num_simulations,
    "diagnose": diagnosed,
}


@pytest.mark.parametrize("name", ["task", "started"])
@pytest.mark.parametrize("entry", ENTRIES)
def test_every_entry_says_what_a_counter_in_the_simulator_says(tmp_path, entry, name):
    (tmp_path / "counting.py").write_text(COUNTING)
    told = ENTRIES[entry](f"{tmp_path / 'counting.py'}:{name}", tmp_path / "results")
    assert told == importlib.import_module(module_name(tmp_path / "counting.py")).used
