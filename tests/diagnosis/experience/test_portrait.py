"""What is seen of measured beside simulated events, whatever the simulator."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.diagnosis.experience.recogniser import portrait
from avobench.diagnosis.settings import RECOGNITION


def events(n, d, seed=0, shift=0.0):
    return np.random.default_rng(seed).normal(shift, 1, (n, d))


@given(power=st.integers(-20, 20), seed=st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_units_do_not_matter(power, seed):
    x, simulated = events(800, 1, seed, shift=0.1), events(2000, 1, seed + 100)
    factor = 2.0**power
    np.testing.assert_allclose(portrait(factor * x, factor * simulated, False), portrait(x, simulated, False))


def test_the_order_of_features_does_not_matter():
    x, simulated = events(3000, 4), events(6000, 4, seed=1)
    x[:, 2] += 0.3 * x[:, 0] ** 2
    order = [2, 0, 3, 1]
    seen, other = portrait(x[:, order], simulated[:, order], False), portrait(x, simulated, False)
    np.testing.assert_allclose(seen, other, rtol=0.01, atol=0.02)  # a simulated event's place among them is random


@pytest.mark.parametrize("d", [2, 3, 5])
def test_portraits_of_several_features_have_one_length(d):
    assert len(portrait(events(500, d), events(500, d, seed=1), False)) == 371


def test_where_nothing_differs_bins_scatter_by_their_errors():
    bins = len(RECOGNITION.shares) - 1
    pulls = np.array([portrait(events(2000, 1, k), events(4000, 1, 1000 + k), False)[:bins] for k in range(100)])
    # 5 events in the variance make little of bins that expect few
    assert 0.7 < pulls[:, 5:-5].var() < 1.05
    assert abs(pulls.mean()) < 0.05


def test_remainders_show_in_which_steps_counts_were_rounded():
    rng = np.random.default_rng(2)
    counts, simulated = rng.poisson(40, (5000, 1)), rng.poisson(40, (10_000, 1))
    first = -6 - len(RECOGNITION.steps)  # before spikes and variances
    remainders = portrait(5 * (counts // 5), simulated, True)[first:-6]
    assert set(np.array(RECOGNITION.steps)[np.argsort(remainders)[-2:]]) == {5, 10}
    assert portrait(counts, simulated, True)[first:-6].max() < 3


@pytest.mark.parametrize("counts", [True, False])
@pytest.mark.parametrize("values", [0, 7, 10**12])
def test_values_all_alike_have_a_portrait(counts, values):
    x = np.full((100, 1), values)
    seen = portrait(x if counts else x.astype(float), np.arange(200)[:, None] * (1 if counts else 1.0), counts)
    assert np.isfinite(seen).all()
