"""Simulated events from elsewhere, with their parameters and weights."""

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.tasks.errors import UsageError

NODES = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0.4, 0.6]])


def test_the_mean_between_thetas_is_interpolated():
    theta = np.repeat(NODES, 300, axis=0)
    sample = avobench.bank(theta @ [[1.0], [10.0]], theta=theta, prior={"a": (0, 1), "b": (0, 1)})
    asked = np.tile([0.3, 0.2], (20_000, 1))
    x = sample.simulate(asked, np.random.default_rng(0))
    assert x.mean() == pytest.approx(2.3, abs=5 * x.std() / np.sqrt(len(x)))


def test_one_parameter_is_interpolated_too():
    theta = np.repeat([1.0, 2.0, 4.0], 300)
    sample = avobench.bank(theta, theta={"a": theta})
    x = sample.simulate(np.full((20_000, 1), 2.5), np.random.default_rng(0))
    assert set(np.unique(x)) == {2.0, 4.0}
    assert x.mean() == pytest.approx(2.5, abs=0.03)


def test_weights_are_those_of_the_events():
    table = pd.DataFrame({"x": np.repeat([0.0, 1.0, 2.0], 1000), "w": np.repeat([1.0, 3.0, 0.0], 1000)})
    sample = avobench.bank(table, weights="w")
    assert sample.labels == ("x",)
    assert (sample.events == 1).mean() == pytest.approx(0.75, abs=0.01)
    assert sample.worth == pytest.approx(16 / 30)  # (1 + 3)^2 / (1 + 9) of three


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ({"events": np.full(300, np.nan)}, "NaN"),
        ({"events": ["a"] * 300}, "real numbers"),
        ({"events": np.zeros(100)}, "too few"),
        ({"weights": -np.ones(300)}, "negative"),
        ({"weights": np.zeros(300)}, "all weights are zero"),
        ({"weights": np.ones(7)}, "as many weights"),
        ({"theta": np.ones(300)}, "leave it out"),
        ({"theta": {"a": np.arange(300.0)}}, "too few"),
        ({"theta": {"a": np.repeat([1.0, 2.0], 150)}, "prior": {"a": (0, 1)}}, "outside the prior"),
        ({"theta": {"a": np.repeat([1.0, 2.0], 150)}, "prior": {"b": (0, 9)}}, "prior is of b"),
        ({"features": ["a", "b"]}, r"\(M, d\)"),
    ],
)
def test_wrong_input_is_one_line(what, said):
    with pytest.raises(UsageError, match=said) as error:
        avobench.bank(**{"events": np.arange(300.0)} | what)
    assert "\n" not in str(error.value)
