"""A cell's record: scored on success, named on failure, reproducible always."""

import numpy as np
import pytest

import avobench
from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import observe
from avobench.bench.cells.trial import blank_record, execute
from avobench.bench.store.record import check
from avobench.bench.store.status import Status
from avobench.bench.store.versions import versions
from avobench.bench.sweep.plan import plan


def cell(*settings, budget=4000, target="0", repetitions=1, seed=0):
    return plan(["toys:Normal"], ["toys:Moment"], target, repetitions, budget, 2000, seed, list(settings))[-1]


def test_a_record_holds_the_estimate_its_score_and_what_it_took():
    record = execute(cell())
    truth, estimate = np.array(record["theta_true"]), np.array(record["theta_hat"])
    assert record["status"] == "ok"
    assert record["squared_error"] == pytest.approx(((truth - estimate) ** 2).sum())
    assert record["squared_error"] < 30 * record["floor"]
    assert record["floor"] == pytest.approx(1 / 2000 + 1 / 4000)
    assert record["floor_likelihood"] == pytest.approx(1 / 2000)
    assert record["simulations_used"] == record["simulations_requested"] == 4000
    assert [point["simulations"] for point in record["trace"]] == [1000, 2000, 3000, 4000]
    assert record["method_seconds"] > 0 < record["simulator_seconds"]
    assert record["versions"]["numpy"] == np.__version__


def test_a_record_tells_the_versions_of_what_its_method_and_task_need():
    from importlib.metadata import version

    assert versions(("sklearn", "sbi"))["scikit-learn"] == version("scikit-learn")  # by the name it is installed under
    assert versions(("sbi", "no_such_module"))["no_such_module"] is None
    record = blank_record(plan(["poisson"], ["nle"], "0", 1, 4000, 2000, 0, [])[0], Status.OK, "")
    assert record["versions"]["sbi"] == version("sbi")


@pytest.mark.parametrize(
    ("setting", "status", "message"),
    [
        ("moment.fault=greedy", "budget_exhausted", "4000 events asked for, 0 of 4000 left"),
        ("moment.fault=raises", "method_error", "RuntimeError: lost the thread"),
        ("moment.fault=outside", "invalid_estimate", "not within the support"),
        ("moment.fault=nothing", "invalid_estimate", "NoneType instead of an Estimate"),
        ("moment.fault=trace", "invalid_estimate", "the trace must be a list of TracePoint, got 1"),
        ("moment.fault=backwards", "invalid_estimate", "the trace must go from 0 towards the 4000 used"),
        ("moment.fault=beyond", "invalid_estimate", "the trace must go from 0 towards the 4000 used"),
        ("moment.fault=spread", "invalid_estimate", "the std of the estimate is negative"),
        ("moment.fault=error", "invalid_estimate", "the error of the estimate is negative"),
        ("moment.fault=kept", "invalid_estimate", "made without a simulated event"),
        ("moment.fault=support", "outside_support", "theta = [100.0] lies outside"),
        ("normal.fault=raises", "simulator_error", "the simulator of normal raised RuntimeError"),
        ("normal.fault=nan", "simulator_error", "NaN or infinity"),
        ("normal.fault=exits", "simulator_error", "the simulator of normal raised SystemExit: 0"),
        ("normal.fault=floor", "simulator_error", "the floor of normal must be a number, not negative, got N"),
        ("normal.fault=negative floor", "simulator_error", "the floor of normal must be a number, not negative, got -"),
        ("moment.fault=exits", "method_error", "SystemExit: 0"),
        ("moment.fault=quiet", "budget_exhausted", ""),
        ("moment.fault=usage", "method_error", "not like this"),
        ("moment.fault=cheats", "method_error", "AttributeError"),
    ],
)
def test_a_failure_is_a_record_with_its_reason(setting, status, message):
    settings = [setting, "moment.steps=8"]  # 500 events a request: the faulty simulator fails after the observation
    record = execute(cell(*settings))
    assert record["status"] == status
    assert message in record["message"]
    assert record["theta_hat"] is None
    assert record["squared_error"] is None
    assert set(record) == set(execute(cell()))
    check(record)
    assert record["simulations_used"] <= 4000
    assert record["simulations_requested"] == record["simulations_used"] + record["simulations_refused"]


def test_a_standard_error_is_recorded_where_the_method_tells_one():
    record = execute(cell("moment.fault=tells"))
    assert record["standard_error"] == record["std"]
    check(record)
    with pytest.raises(ValueError, match="standard_error is negative"):
        check({**record, "standard_error": [-0.1]})
    assert "standard_error" not in execute(cell())


WHOLE = avobench.task(
    lambda theta, rng: rng.normal(theta, 20),
    prior={"number": (0, 90)},
    support={"number": (0, 99)},
    kinds={"number": "integer"},
    name="whole",
)


def test_an_integer_is_recorded_whole_with_an_error_that_covers_the_rounding():
    for target in range(3):
        record = execute(Cell(f"{__file__}:WHOLE", {}, "smm", {}, target, 0, 2000, 200, 0))
        (theta,), (mean,), (error,) = (record[name] for name in ("theta_hat", "mean", "standard_error"))
        assert theta == round(theta)
        assert error >= abs(theta - mean) > 0
        assert record["squared_error"] == (theta - record["theta_true"][0]) ** 2
        check(record)


def test_a_summary_that_is_not_finite_is_named():
    record = execute(cell("normal.fault=summary", "moment.fault=summary"))
    assert record["status"] == "simulator_error"
    assert "the summary of normal must be a finite array" in record["message"]


def test_an_observation_that_does_not_fit_in_memory_is_not_blamed_on_the_method():
    (huge,) = plan(["toys:Normal"], ["toys:Moment"], "0", 1, 400, 10**15, 0, [])
    record = execute(huge)
    assert record["status"] == "simulator_error"
    assert "MemoryError" in record["message"]


def test_every_method_and_repetition_sees_the_same_observation():
    task = cell().build_task()
    np.testing.assert_array_equal(observe(task, 0, 100, 0), observe(task, 0, 100, 0))
    assert not np.array_equal(observe(task, 0, 100, 0), observe(task, 0, 100, 1))
    first, second = execute(cell(repetitions=1)), execute(cell(repetitions=2))
    assert first["theta_true"] == second["theta_true"]
    assert first["theta_hat"] != second["theta_hat"]
