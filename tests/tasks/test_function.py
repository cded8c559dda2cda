"""A task from a plain function, and what it returns, held against what its task declares."""

import contextlib
import random
import signal
import sys
import time
import warnings

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.tasks.checked import checked_events
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task


def decay(theta, rng):
    return rng.exponential(theta[:, 0])


def pair(theta, rng):
    return np.column_stack([rng.normal(theta[:, 0]), rng.poisson(np.exp(theta[:, 1]))])


def unpacked(theta, rng):
    mu, sd = theta
    return rng.normal(mu, sd)


def test_it_has_all_that_a_task_has():
    made = task(decay, prior={"lifetime": (1, 4)}, units={"lifetime": "us"}, support={"lifetime": (0.1, 20)})
    assert (made.name, made.parameter_names, made.parameter_units) == ("decay", ("lifetime",), ("us",))
    assert (made.num_features, made.dtype) == (1, np.float64)
    assert made.support.low == (0.1,)
    assert made.targets().shape == (15, 1)
    x = made.simulate(np.full((1000, 1), 2.0), np.random.default_rng(0))
    assert x.shape == (1000, 1)
    summary = made.summary(x)
    assert summary.sum() == pytest.approx(1)
    assert np.isnan(made.floor(np.array([2.0]), 100, 100))
    with pytest.raises(ValueError, match="support"):
        made.simulate(np.full((1, 1), 50.0), np.random.default_rng(0))


def test_features_are_of_the_kinds_that_are_stated_or_seen():
    assert task(lambda theta, rng: rng.poisson(theta), prior={"rate": (1, 9)}, name="n").dtype == np.int64
    options = {"prior": [(0, 1), (1, 2)], "names": ["a", "b"], "features": ["x", "n"]}
    plain, stated = task(pair, **options), task(pair, **options, kinds={"n": "count"}, feature_units={"x": "GeV"})
    assert (plain.parameter_names, plain.labels) == (("a", "b"), ("x", "n"))
    assert plain.summary(plain.simulate(np.tile([0.5, 1.5], (100, 1)), np.random.default_rng(0))).ndim == 1
    assert plain.kinds_of_features == ("continuous", "continuous")
    assert stated.kinds_of_features == ("continuous", "count")
    assert stated.feature_units == ("GeV", "1")
    assert stated.dtype == np.float64
    assert plain.parts[1] != stated.parts[1]
    counts = task(lambda theta, rng: 1.0 * rng.poisson(theta), prior={"rate": (1, 9)}, name="n", kinds={"x1": "count"})
    assert counts.simulate(np.ones((3, 1)), np.random.default_rng(0)).dtype == counts.dtype == np.int64
    half = task(lambda theta, rng: np.rint(theta[:, 0] - 2), prior={"a": (1, 9)}, name="low", kinds={"x1": "count"})
    with pytest.raises(ValueError, match="low makes -1 where"):
        half.simulate(np.ones((3, 1)), np.random.default_rng(0))


@pytest.mark.parametrize(
    ("function", "options", "said"),
    [
        (decay, {"prior": [(1, 4)]}, "a name to each"),
        (decay, {"prior": {"t": (4, 1)}}, "low < high"),
        (decay, {"prior": {"t": (-1e308, 1e308)}}, "low < high"),
        (decay, {"prior": {}}, "is empty"),
        (decay, {"prior": {"t": (1, 4)}, "support": {"t": (2, 3)}}, "must hold its prior"),
        (decay, {"prior": {"t": (1, 4)}, "units": {"u": "s"}}, "the parameters of decay are t"),
        (decay, {"prior": {"t": (1, 4)}, "features": ["a", "b"]}, "1 features, 2 names"),
        (decay, {"prior": {"t": (1, 4)}, "name": "../x"}, "letters, digits"),
        (decay, {"prior": {"t": (1, 4)}, "kinds": {"x1": "count"}}, "where its kinds promise a count"),
        (decay, {"prior": {"t": (1, 4)}, "kinds": {"time": "count"}}, "kinds names 'time'; the features are x1"),
        (decay, {"prior": {"t": (1, 4)}, "kinds": {"x1": "cosine"}}, "one of count, continuous, angle, not cosine"),
        (decay, {"prior": {"t": (1, 4)}, "feature_units": {"t": "us"}}, "feature_units names 't'"),
        (lambda theta, rng: 1 / 0, {"prior": {"t": (1, 4)}}, "ZeroDivisionError"),
        (lambda theta, rng: sys.exit(0), {"prior": {"t": (1, 4)}}, "SystemExit"),
        (lambda theta, rng: np.ones(7), {"prior": {"t": (1, 4)}}, "events of shape"),
        (lambda theta: theta, {"prior": {"t": (1, 4)}}, "TypeError"),
        (unpacked, {"prior": {"m": (0, 1), "s": (1, 2)}}, r"theta\[:, 0\] is the first parameter"),
        (lambda theta, rng: rng.normal(theta[0]), {"prior": {"m": (0, 1), "s": (1, 2)}}, r"theta\[:, 0\]"),
        (lambda theta, rng: 1.0, {"prior": {"t": (1, 4)}}, r"theta\[:, 0\]"),
        (decay, {"prior": {"t": (1, 4.5)}, "kinds": {"t": "integer"}}, "t is an integer"),
        (decay, {"prior": {"t": (1, 4)}, "failed": "drop"}, "failed must be one of raise, region"),
        (lambda theta, rng: np.nan * theta, {"prior": {"t": (1, 4)}, "failed": "region"}, "no finite events"),
        (pair, {"prior": {"a": (0, 1), "b": (1, 2)}, "features": ["a", "a"]}, "have the name a"),
        (pair, {"prior": [(0, 1), (1, 2)], "names": ["a", "a"]}, "have the name a"),
        (
            *(lambda theta, n, rng: np.ones(3), {"prior": {"a": (0, 1)}, "per_theta": True}),
            r"events of shape \(3,\) for one theta of shape \(1,\) and n = 2",
        ),
        (
            *(lambda theta, n, rng: theta[:, 0], {"prior": {"a": (0, 1)}, "per_theta": True}),
            r"IndexError.*theta\[0\] is the first parameter",  # as theta is given
        ),
    ],
)
def test_what_makes_no_task_is_said_in_a_line(function, options, said):
    with pytest.raises(UsageError, match=said):
        task(function, **options)


def test_its_arguments_make_it_again():
    stated = {"kinds": {"n": "count"}, "feature_units": {"x": "GeV"}, "support": {"a": (-1, 2)}, "name": "pair.2"}
    made = task(pair, prior=[(0, 1), (1, 2)], names=["a", "b"], features=["x", "n"], units={"b": "s"}, **stated)
    again = task(pair, **eval(repr(made.arguments)))
    assert (again.parts, again.parameter_units) == (made.parts, made.parameter_units)
    assert (again.name, again.prior, again.support, again.dtype) == (made.name, made.prior, made.support, made.dtype)


def modules(theta, rng):
    """The energy in a detector of so many modules: whole numbers alone are asked for."""
    assert (theta[:, 0] == np.rint(theta[:, 0])).all()
    return rng.normal(theta[:, 0] ** 2, theta[:, 1])


def test_an_integer_is_simulated_and_quoted_whole_with_an_error_that_covers_it():
    task = avobench.task(modules, prior={"number": (1, 9), "width": (0.5, 2)}, kinds={"number": "integer"}, name="m")
    x = modules(np.tile([3.0, 1.0], (2000, 1)), np.random.default_rng(0))
    found = avobench.infer(task, x, "smm", budget=8000)
    assert found.theta["number"] == 3
    assert found.std["number"] < 0.5
    assert str(found).startswith("number = 3 ± 0.")
    value, error = task.quoted(np.array([3.46, 1.2]), np.array([0.056, 0.1]))
    np.testing.assert_allclose([value, error], [[3, 1.2], [np.hypot(0.46, 0.056), 0.1]])
    between = task.at_whole(np.tile([2.25, 1.5], (10_000, 1)), np.random.default_rng(1))
    assert between[:, 0].mean() == pytest.approx(2.25, abs=0.03)
    assert (task.targets() == np.c_[np.rint(task.targets()[:, 0]), task.targets()[:, 1]]).all()


def test_a_function_that_hangs_is_named_and_the_alarm_of_others_is_kept():
    def hangs(theta, rng):
        while True:
            with contextlib.suppress(Exception):
                time.sleep(0.01)

    before = signal.signal(signal.SIGALRM, signal.SIG_IGN)
    try:
        signal.alarm(100)
        with pytest.raises(UsageError, match=r"the task hangs, tried on 2 events, has not returned after 0\.05 s"):
            task(hangs, prior={"mean": (0, 1)}, seconds=0.05)
        assert 90 < signal.alarm(0) <= 100
        assert signal.getsignal(signal.SIGALRM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def program():
    """A task of a program that is started for each theta, and the numbers of events that it was asked for."""
    started = []

    def decays(theta, n, rng):
        started.append(n)
        return rng.exponential(theta[0], n)

    return task(decays, prior={"lifetime": (1, 4)}, per_theta=True), started


def test_a_program_is_started_once_for_each_theta_of_a_call_and_every_event_counts(program):
    made, started = program
    theta, rng = np.array([[3.0], [1.0], [3.0], [2.0]]), np.random.default_rng(0)
    x = np.mean([made.simulate(theta, rng)[:, 0] for _ in range(2000)], axis=0)
    np.testing.assert_allclose(x, theta[:, 0], rtol=0.15)
    assert started[-3:] == [1, 1, 2]  # of 1, 2 and 3
    started.clear()
    found = avobench.diagnose(made, rng.exponential(2.2, 1000), progress=False, effects=[])
    assert sum(started) == found.diagnosis.num_simulations


@pytest.mark.xfail(strict=True, reason="6 events a start where 20 are wanted: scans have a theta for each event")
def test_a_diagnosis_starts_a_program_seldom(program):
    made, started = program
    avobench.diagnose(made, np.random.default_rng(0).exponential(2.2, 1000), progress=False, effects=[])
    assert sum(started) > 20 * len(started)


@pytest.mark.parametrize("failed", ["raise", "region"])
@pytest.mark.parametrize("per_theta", [False, True])
@pytest.mark.parametrize("returned", [None, 1.0, "text", np.ones(1), np.ones((1, 2)), np.ones((2, 1, 1))])
def test_what_is_returned_in_place_of_events_is_said_beside_what_is_due(returned, per_theta, failed):
    said = r"returned .* for .*, as \(2,\) or \(2, d\), where (.*) is the first"
    with pytest.raises(UsageError, match=said) as error:
        task(lambda *given: returned, prior={"a": (0, 1)}, name="odd", per_theta=per_theta, failed=failed)
    assert ("theta[0]" in str(error.value)) == per_theta
    assert "\n" not in str(error.value)


def table_of_rows(theta, rng):
    return pd.DataFrame({"t": rng.exponential(theta[:, 0]), "z": rng.normal(theta[:, 0] + 100)})


def table_of_one(theta, n, rng):
    return table_of_rows(np.tile(theta, (n, 1)), rng)


@pytest.mark.parametrize("function", [table_of_rows, table_of_one])
@pytest.mark.parametrize("features", [["z", "t"], ["z"], ["t", "z"], []])
def test_features_of_a_simulated_table_are_chosen_by_name(function, features):
    options = {"prior": {"mean": (1, 4)}, "per_theta": function is table_of_one}
    made = task(function, features=features, **options)
    x = made.simulate(np.full((50, 1), 2.0), np.random.default_rng(0))
    expected = table_of_rows(np.full((50, 1), 2.0), np.random.default_rng(0))[features or ["t", "z"]]
    np.testing.assert_array_equal(x, expected.to_numpy())
    with pytest.raises(UsageError, match="no column 'u'; the columns are t, z"):
        task(function, features=["t", "u"], **options)


@pytest.mark.parametrize("function", [table_of_rows, table_of_one])
def test_measured_columns_in_another_order_are_found_by_the_names_of_a_simulated_table(function):
    made = task(function, prior={"mean": (1, 4)}, per_theta=function is table_of_one)
    assert made.feature_names == ("t", "z")
    measured = table_of_rows(np.full((500, 1), 2.0), np.random.default_rng(0))
    one, other = (
        avobench.infer(made, measured[names], "rank-moments", budget=2000, progress=False).theta["mean"]
        for names in (["t", "z"], ["z", "t"])
    )
    assert one == other == pytest.approx(2, abs=0.3)
    with pytest.raises(UsageError, match="the data have no z"):
        avobench.infer(made, measured.rename(columns={"z": "y"}), "rank-moments", budget=2000, progress=False)


def test_a_simulated_table_without_names_has_none():
    made = task(lambda theta, rng: pd.DataFrame(rng.normal(theta[:, [0, 0]])), prior={"mean": (1, 4)})
    assert made.feature_names == ()
    with pytest.raises(UsageError, match="the name t"):
        task(lambda theta, rng: table_of_rows(theta, rng)[["t", "t"]], prior={"mean": (1, 4)})


@pytest.mark.parametrize(
    ("draw", "told"),
    [
        (lambda mean, rng: np.random.exponential(mean), True),
        (lambda mean, rng: np.random.default_rng().exponential(mean), True),
        (lambda mean, rng: [random.expovariate(1 / one) for one in mean], True),
        (lambda mean, rng: rng.exponential(mean), False),
        (lambda mean, rng: np.where(rng.random(len(mean)) < 2, np.nan, mean), False),
    ],
)
@pytest.mark.parametrize("per_theta", [False, True])
def test_randomness_beside_the_generator_is_told(draw, told, per_theta):
    def events(theta, *given):
        return draw(np.full(given[0], theta[0]) if per_theta else theta[:, 0], given[-1])

    with warnings.catch_warnings(record=True, action="always") as seen:
        task(events, prior={"mean": (1, 4)}, per_theta=per_theta)
    assert ["same generator again" in str(one.message) for one in seen] == [True] * told


def test_a_slow_simulator_is_asked_once(monkeypatch):
    monkeypatch.setattr("avobench.tasks.function.QUICK", 0)
    calls = []
    task(lambda theta, rng: calls.append(len(theta)) or rng.normal(theta), prior={"a": (0, 1)}, name="slow")
    assert calls == [2]


def test_events_stay_though_a_program_fills_one_buffer_for_each_theta():
    buffer = np.empty(100)

    def reusing(theta, n, rng):
        buffer[:n] = theta[0]
        return buffer[:n]

    theta = np.array([[1.0], [2.0], [3.0], [1.0]])
    made = task(reusing, prior={"a": (0, 4)}, per_theta=True)
    np.testing.assert_array_equal(made.simulate(theta, np.random.default_rng(0)), theta)


THETA = np.full((50, 1), 2.0)


def toy(simulate):
    return task(simulate, prior={"mean": (1, 3)}, name="toy")


def test_events_can_be_written_to_though_the_simulator_s_cannot():
    frozen = toy(lambda theta, rng: np.broadcast_to(rng.exponential(theta), theta.shape))  # which is read-only
    checked_events(frozen, THETA, np.random.default_rng(0))[:] = 0


def test_events_stay_though_the_simulator_fills_one_buffer_again_and_again():
    buffer = np.empty((50, 1))

    def reusing(theta, rng):
        buffer[: len(theta)] = rng.exponential(theta)
        return buffer[: len(theta)]

    made = toy(reusing)
    first = checked_events(made, THETA, np.random.default_rng(0))
    kept = first.copy()
    checked_events(made, THETA, np.random.default_rng(1))
    np.testing.assert_array_equal(first, kept)


def test_theta_stays_though_the_simulator_changes_it():
    def changing(theta, rng):
        x = rng.exponential(theta)
        theta /= 2
        return x

    theta = THETA.copy()
    checked_events(toy(changing), theta, np.random.default_rng(0))
    np.testing.assert_array_equal(theta, THETA)
