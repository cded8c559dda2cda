"""Simulated events from elsewhere, with their parameters and weights."""

import warnings
from functools import partial

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

import avobench
from avobench.tasks.errors import UsageError

NODES = [[0, 0], [1, 0], [0, 1], [1, 1], [0.4, 0.6]]


@pytest.mark.parametrize(("nodes", "at"), [(NODES, [0.3, 0.2]), ([[0.1], [0.2], [0.4]], [0.25])])
def test_the_mean_between_thetas_is_interpolated_by_those_that_are_near(nodes, at):
    theta = np.repeat(np.array(nodes), 300, axis=0)
    sample = avobench.bank(theta @ [1.0, 10.0][: len(at)], theta={f"t{j}": one for j, one in enumerate(theta.T)})
    x = sample.simulate(np.tile(at, (20_000, 1)), np.random.default_rng(0))
    assert x.mean() == pytest.approx(at @ np.array([1.0, 10.0][: len(at)]), abs=5 * x.std() / np.sqrt(len(x)))
    assert len(np.unique(x)) == len(at) + 1


def test_weights_are_those_of_the_events():
    table = pd.DataFrame({"x": np.repeat([0.0, 1.0, 2.0], 1000), "w": np.repeat([1.0, 3.0, 0.0], 1000)})
    sample = avobench.bank(table, weights="w")
    assert sample.labels == ("x",)
    assert (sample.events == 1).mean() == pytest.approx(0.75, abs=0.01)
    # The shares of three rows are 3/4 and 9/4, in copies of variance 3/16 each: 3 / (9/16 + 81/16 + 6/16).
    assert sample.worth == pytest.approx(1 / 2)


def test_copies_of_an_event_of_large_weight_raise_no_alarm():
    """Of 40 right samples: a classifier that has learnt from copies of the events of its test fails on half of them."""
    alarms = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        weights = np.where(rng.random(6000) < 0.05, 20.0, 1.0)
        sample = avobench.bank(rng.normal(size=6000), weights=weights, seed=seed)
        assert not np.isin(sample.events[sample.aside[0]], sample.events[sample.groups[0]]).any()
        found = avobench.diagnose(sample, rng.normal(size=1000), seed=seed, effects=[], progress=False).diagnosis
        alarms += found.gates["classifier"].p_value < 0.05
    assert alarms <= binom.isf(1e-4, 40, 0.05)


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ({"events": np.full(300, np.nan)}, "NaN"),
        ({"events": ["a"] * 300}, "real numbers"),
        ({"events": np.zeros(100)}, "too few"),
        ({"weights": -np.ones(300)}, "do not add up to a positive number"),
        ({"weights": np.zeros(300)}, "are zero"),
        ({"weights": np.ones(7)}, "as many weights"),
        ({"theta": np.ones(300)}, "leave it out"),
        ({"theta": {"a": np.arange(300.0)}}, "too few"),
        ({"theta": {"a": np.repeat([1.0, 2.0], 150)}, "prior": {"a": (0, 1)}}, "outside the prior"),
        ({"theta": {"a": np.repeat([1.0, 2.0], 150)}, "prior": {"b": (0, 9)}}, "prior is of b"),
        ({"features": ["a", "b"]}, r"\(M, d\)"),
        ({"events": pd.DataFrame(np.ones((300, 2)), columns=["x", "x"])}, "have the name x"),
        ({"events": np.ones((300, 2)), "features": ["x", "x"]}, "have the name x"),
        ({"theta": pd.DataFrame(np.ones((300, 2)), columns=["x", "x"])}, "have the name x"),
    ],
)
def test_wrong_input_is_one_line(what, said):
    with pytest.raises(UsageError, match=said) as error:
        avobench.bank(**{"events": np.arange(300.0)} | what)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("theta", [None, np.repeat([1.0, 2.0, 3.0], [3000, 250, 3000])])
@pytest.mark.parametrize("ask", [partial(avobench.diagnose, effects=[]), avobench.infer])
def test_fewer_simulated_events_near_the_fit_than_half_of_the_measured_ones_are_refused(theta, ask):
    if theta is None and ask is avobench.infer:
        return
    rng = np.random.default_rng(0)
    few = np.full(250, 2.0) if theta is None else theta
    sample = avobench.bank(rng.exponential(few), theta=None if theta is None else {"a": theta})
    with pytest.raises(UsageError, match=r"250 simulated events( at a = 2, near the fit,)? are too few for 2000"):
        ask(sample, rng.exponential(2.0, 2000), progress=False)


def test_as_many_simulated_events_as_the_line_asks_for_are_enough():
    rng = np.random.default_rng(0)
    measured = rng.exponential(2.0, 2000)
    with pytest.raises(UsageError, match="at least 1250"):
        avobench.diagnose(rng.exponential(2.0, 1200), measured, effects=[], progress=False)
    avobench.diagnose(rng.exponential(2.0, 1250), measured, effects=[], progress=False)


@pytest.mark.parametrize("events", [[[1, 2], [3]] * 200, pd.DataFrame({"a": [np.arange(k % 3) for k in range(400)]})])
def test_events_of_different_lengths_are_to_be_reduced(events):
    with pytest.raises(UsageError, match=r"reduce events .* `\[\(len\(e\), sum\(e\)\) for e in events\]`"):
        avobench.diagnose(events, events)


def test_theta_lies_at_a_node_as_well_as_between_two():
    """The noise of few simulated events is least between nodes, which drew the fit there by several errors."""
    pulls = []
    for seed in range(8):
        rng, nodes = np.random.default_rng(seed), np.repeat([1.5, 2.0, 2.7], [3000, 1400, 3000])
        fit = avobench.infer(avobench.bank(rng.exponential(nodes), theta={"mean": nodes}), rng.exponential(2.0, 1500))
        pulls.append((fit.theta["mean"] - 2.0) / fit.std["mean"])
    assert np.sqrt(np.mean(np.square(pulls))) < 1.7


def named(**columns):
    """300 simulated events x and y, y 100 above, and further columns."""
    x = np.random.default_rng(0).random(300)
    return pd.DataFrame({"x": x, "y": x + 100} | columns)


@given(order=st.permutations(["a", "b", "c"]), as_prior=st.permutations(["a", "b", "c"]))
def test_names_decide_which_column_of_theta_is_which(order, as_prior):
    x = np.random.default_rng(0).normal(size=1000)
    theta = pd.DataFrame({"b": [20.0, 30.0], "c": [3.0, 4.0]}).loc[np.repeat([0, 1], 500)]
    theta.insert(0, "a", np.tile([1.0, 2.0], 500))
    for prior in (None, {name: (0, 40) for name in as_prior}):
        made = avobench.bank(x, theta=theta[list(order)], prior=prior)
        assert made.parameter_names == tuple(order)
        at = dict(zip(made.parameter_names, made.nodes.T, strict=True))
        assert all(set(at[name]) == set(theta[name]) for name in theta)
    with pytest.raises(UsageError, match="the prior is of d"):
        avobench.bank(x, theta=theta, prior={"d": (0, 40), "b": (0, 40), "c": (0, 40)})
    unnamed = avobench.bank(x, theta=pd.DataFrame(theta.to_numpy(float)), prior={name: (0, 40) for name in as_prior})
    assert unnamed.parameter_names == tuple(as_prior)


@given(st.permutations(["x", "y", "z"]), st.integers(1, 3))
def test_features_of_a_table_are_chosen_by_name(order, number):
    table, names = named(z=np.arange(300) + 200.5), order[:number]
    made = avobench.bank(table, features=names)
    assert made.labels == tuple(names)
    np.testing.assert_array_equal(np.sort(made.events, axis=0), np.sort(table[names].to_numpy(), axis=0))
    unnamed = avobench.bank(pd.DataFrame(table.to_numpy()), features=order)
    assert unnamed.labels == tuple(order)
    assert unnamed.events[:, 0].max() < 1


def test_one_name_is_one_column_of_theta():
    table = pd.DataFrame({"x": np.arange(600) / 7, "lifetime": np.repeat([1.0, 2.0], 300)})
    made = avobench.bank(table, theta="lifetime")
    assert (made.parameter_names, made.labels) == (("lifetime",), ("x",))


@pytest.mark.parametrize(
    ("column", "said"),
    [
        ("a", "column w of the simulated events must be real numbers"),
        (pd.Timestamp("2020-02-02"), "column w"),
        (pd.array([True, None] * 150, dtype="boolean"), "column w"),
        ([[1]] * 300, "column w"),
        (pd.array([1, None] * 150, dtype="Int64"), "the values of w of the simulated events hold NaN"),
    ],
)
@pytest.mark.parametrize("missing", [[], ["y"]])
def test_a_column_that_holds_no_numbers_is_named(column, said, missing):
    with pytest.raises(UsageError, match=said):
        avobench.bank(named(w=column), missing=missing)


@pytest.mark.parametrize("dtype", [bool, "boolean", "Int64", "Float64", object])
def test_columns_of_any_numbers_are_taken(dtype):
    w = np.arange(300) % 2
    made = avobench.bank(named(w=pd.Series(w, dtype=dtype)))
    np.testing.assert_array_equal(np.sort(made.events[:, 2]), np.sort(w))
    lacking = avobench.bank(named(w=pd.Series([1.0, None] * 150)), missing=["w"])
    assert np.isnan(lacking.events[:, 2]).sum() == 150


@pytest.mark.parametrize("missing", [[], ["x1"]])
def test_masked_values_are_refused(missing):
    x = np.random.default_rng(0).normal(size=600)
    masked = np.ma.masked_greater(x, 1)
    for what in ({"events": masked}, {"weights": masked}, {"theta": masked}, {"theta": {"a": masked}}):
        with pytest.raises(UsageError, match="masked"):
            avobench.bank(**{"events": x} | what, missing=missing)
    with pytest.raises(UsageError, match="masked"):
        avobench.diagnose(masked, x)
    assert len(avobench.bank(np.ma.array(x), missing=missing).events) == 600


SHAPES = {
    "exponential": lambda n, rng: rng.exponential(2, n),
    "uniform": lambda n, rng: rng.random(n),
    "cauchy": lambda n, rng: rng.standard_cauchy(n),
}


@given(
    seed=st.integers(0, 99),
    shape=st.sampled_from(list(SHAPES)),
    times=st.sampled_from([0, 2, 4]),
    whole=st.booleans(),
    weighted=st.booleans(),
)
@settings(max_examples=30, deadline=None)
def test_copies_of_an_event_count_as_its_weight(seed, shape, times, whole, weighted):
    rng = np.random.default_rng(seed)
    x = SHAPES[shape](3000, rng)
    x = np.tile(x, times) if times else rng.choice(x, 3000)  # a bootstrap: of a row there are 2 on average
    x = np.c_[x, np.rint(x)] if whole else x
    copies = len(x) - len(np.unique(x, axis=0))
    with pytest.warns(UserWarning, match=f"{copies} of {len(x)} simulated events are copies"):
        sample = avobench.bank(x, weights=np.full(len(x), 0.5) if weighted else None, seed=seed)
    assert sample.worth == pytest.approx(1 / (times or 2), rel=0.1 if times == 0 else 1e-9)
    assert not np.isin(sample.events[sample.aside[0], 0], sample.events[sample.groups[0], 0]).any()
    np.testing.assert_array_equal(np.sort(sample.events[:, 0]), np.sort(np.reshape(x, (len(x), -1))[:, 0]))


def grids(x, step, kind, rng):
    """Values that were rounded: to a grid, before a calibration, in channels of their own, or once more as floats."""
    if kind == "channels":
        gain = step * (1 + 0.0371 * rng.integers(3, size=len(x)))
        return np.rint(x / gain) * gain
    rounded = np.rint(x / step) * step
    if kind == "calibrated":
        return np.arcsinh(rounded) + rounded**3 / 10
    return rounded * (1 + 1e-16 * rng.integers(-2, 3, len(x))) if kind == "floats" else rounded


@given(
    seed=st.integers(0, 99),
    shape=st.sampled_from(list(SHAPES)),
    step=st.floats(1e-3, 1),
    kind=st.sampled_from(["grid", "calibrated", "channels", "floats"]),
    pair=st.booleans(),
)
@settings(max_examples=150, deadline=None)
def test_rounded_values_and_counts_are_no_copies(seed, shape, step, kind, pair):
    rng = np.random.default_rng(seed)
    x = grids(SHAPES[shape](4000, rng), step, kind, rng)
    x = np.c_[x, grids(SHAPES[shape](4000, rng), step, kind, rng)] if pair else x
    with warnings.catch_warnings(action="error"):
        assert avobench.bank(x).worth == 1
        assert avobench.bank(np.tile(np.rint(x / step).astype(np.int64), (2, 1) if pair else 2)).worth == 1


def test_the_same_events_at_two_thetas_are_no_copies():
    x = np.random.default_rng(0).normal(size=2000)
    assert avobench.bank(np.tile(x, 2), theta={"a": np.repeat([1.0, 2.0], 2000)}).worth == 1


def test_copies_are_seen_beside_missing_values_and_none_where_one_value_is_frequent():
    rng = np.random.default_rng(0)
    x = np.tile(np.where(rng.random(2000) < 0.3, np.nan, rng.normal(size=2000)), 3)
    both = np.c_[x, np.tile(rng.normal(size=2000), 3)]
    with pytest.warns(UserWarning, match="4000 of 6000 simulated events are copies"):
        assert avobench.bank(both, missing=["x1"]).worth == pytest.approx(1 / 3)
    with warnings.catch_warnings(action="error"):
        frequent = np.where(rng.random(6000) < 0.4, 1.5, rng.normal(size=6000))
        assert avobench.bank(frequent).worth == avobench.bank(np.tile(frequent, 2)).worth == 1


def test_copies_raise_no_alarm():
    """Of 16 right samples, four copies of each event, two in three were rejected."""
    rejected = 0
    for seed in range(16):
        rng = np.random.default_rng(seed)
        x = np.tile(rng.exponential(2, 2000), 4)
        with pytest.warns(UserWarning, match="copies"):
            found = avobench.diagnose(x, rng.exponential(2, 2000), progress=False, effects=[])
        assert "8000 simulated events with weights or copies are worth 2000" in " ".join(found.diagnosis.notes)
        rejected += found.verdict != "no significant disagreement"
    assert rejected <= binom.isf(1e-4, 16, 0.05)
