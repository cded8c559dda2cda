"""Weighted events: sums over regions stay, none weight is negative, and what is left is a sample."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import avobench
from avobench.tasks.errors import UsageError
from avobench.tasks.weights import effective, without_negative


@given(seed=st.integers(0, 10**6), share=st.floats(0, 0.4), dim=st.integers(1, 3), whole=st.booleans())
@settings(max_examples=25, deadline=None)
def test_no_weight_is_negative_and_their_sum_stays(seed, share, dim, whole):
    rng = np.random.default_rng(seed)
    x = rng.poisson(2.0, (300, dim)) if whole else rng.normal(size=(300, dim))
    w = rng.uniform(0.5, 2, 300) * np.where(rng.random(300) < share, -1, 1)
    positive = without_negative(x, w)
    assert (positive >= 0).all()
    assert positive.sum() == pytest.approx(w.sum())


def test_what_is_added_and_subtracted_again_leaves_the_shape():
    rng = np.random.default_rng(0)
    x = np.r_[rng.exponential(2, 40_000), rng.normal(4, 1, 16_000)]
    w = np.r_[np.ones(48_000), -np.ones(8000)]
    sample = avobench.bank(x, weights=w)
    counts = len(x) / 40_000 * np.histogram(x, np.arange(9), weights=w)[0]
    assert (np.abs(np.histogram(sample.events, np.arange(9))[0] - counts) < 5 * np.sqrt(counts)).all()
    assert sample.total == 40_000
    assert 0.9 < sample.worth / (40_000**2 / 56_000**2) < 1  # the draw costs a little more than the weights


@pytest.mark.parametrize("weight", [lambda rng: rng.random(600), lambda rng: rng.choice([0.5, 1.5], 600)])
def test_events_are_worth_what_a_mean_of_the_drawn_ones_scatters(weight):
    """The variance of 2000 shares is known to 3 %."""
    shares, worth = [], []
    for seed in range(2000):
        rng = np.random.default_rng(seed)
        sample = avobench.bank(rng.random(600), weights=weight(rng), seed=seed)
        shares.append((sample.events < 0.5).mean())
        worth.append(sample.worth)
    assert np.mean(worth) == pytest.approx(0.25 / 600 / np.var(shares), rel=0.13)


def test_at_each_theta_as_many_events_are_drawn_as_there_are():
    theta = np.repeat([1.0, 2.0], [3000, 1000])
    sample = avobench.bank(np.random.default_rng(0).exponential(theta), theta={"a": theta}, weights=10.0**-theta)
    assert [len(a) + len(b) for a, b in zip(sample.groups, sample.aside, strict=True)] == [3000, 1000]
    assert sample.worth == pytest.approx(1)


def test_measured_events_are_kept_by_their_weights():
    rng = np.random.default_rng(1)
    x = rng.exponential(2, 20_000)
    kept = rng.random(len(x)) < (seen := 0.3 + 0.7 * np.exp(-x / 2))
    table = pd.DataFrame({"time": x[kept], "w": 1 / seen[kept]})
    with pytest.warns(UserWarning, match=f"worth {effective(1 / seen[kept]):.0f} of equal weight"):
        events = avobench.unweighted(table, "w")
    assert list(events.columns) == ["time"]
    assert abs(events["time"].mean() - 2) < 4 * 2 / np.sqrt(len(events))
    assert not events.index.duplicated().any()


@pytest.mark.parametrize(
    ("weights", "said"),
    [([1, -1, 1], "1 weights of measured events are negative"), ("v", "no column 'v'"), ([0, 0, 0], "are zero"),
     ([1, 2], "as many weights"), ([1, np.nan, 1], "NaN")],
)  # fmt: skip
def test_wrong_weights_are_one_line(weights, said):
    with pytest.raises(UsageError, match=said):
        avobench.unweighted(pd.DataFrame({"a": [1.0, 2.0, 3.0]}), weights)


def test_measured_events_of_negative_weight_are_compared_as_a_table():
    rng = np.random.default_rng(2)
    x = np.r_[rng.exponential(2, 6000), rng.uniform(0, 8, 2000)]
    w, edges = np.r_[np.ones(7000), -np.ones(1000)], np.linspace(0, 8, 17)
    sums, squares = (np.histogram(x, edges, weights=each)[0] for each in (w, w**2))
    table = avobench.Table(edges, np.maximum(sums, 0), errors=np.sqrt(squares), normalised=True, feature="time")
    right, wrong = (avobench.bank(rng.exponential(mean, 20_000), features=["time"]) for mean in (2, 2.3))
    assert avobench.diagnose(right, table, max_effects=0, progress=False).diagnosis.p_value_before > 0.01
    assert avobench.diagnose(wrong, table, max_effects=0, progress=False).diagnosis.p_value_before < 0.001
