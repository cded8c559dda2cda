"""The yardsticks: what an efficient estimator would show, and weinberg's asymmetry."""

import numpy as np
import pandas as pd
import pytest

from avobench.reports.quantities import labelled
from paper.quantities import ahead, by_mean, efficient_median, interval


@pytest.mark.parametrize("shares", [(1.0,), (0.1, 0.9), (0.5, 0.5), (0.2, 0.3, 0.5)])
def test_the_median_of_a_weighted_sum_is_that_of_draws(shares):
    z = np.random.default_rng(0).standard_normal((400_000, len(shares)))
    assert efficient_median(shares) == pytest.approx(np.median(z**2 @ np.array(shares)), abs=5e-3)


def test_an_interval_of_a_mean_is_that_of_a_gaussian():
    values = np.random.default_rng(0).standard_normal(400)
    low, high = interval(values, pd.Series(range(400)), np.mean)
    error = values.std() / 20
    assert [low, high] == pytest.approx([values.mean() - 1.96 * error, values.mean() + 1.96 * error], abs=0.12 * error)


def test_an_interval_draws_whole_targets():
    """Three equal repetitions add nothing, and of a single target nothing is known."""
    values, targets = np.arange(5.0), pd.Series(range(5))
    once = interval(values, targets, np.mean)
    assert interval(np.repeat(values, 3), targets.repeat(3), np.mean) == pytest.approx(once)
    assert np.isnan(interval(values[:1], targets[:1], np.mean)).all()


def test_ahead_is_a_paired_one_sided_test(make_record):
    def cells(offsets):
        return labelled([make_record("poisson", "avo", target, offset) for target, offset in enumerate(offsets)])

    spread = np.geomspace(1e-3, 1e-1, 6)  # wider than the difference: only the pairs show it
    assert ahead(cells(spread * 0.9), cells(spread)) == pytest.approx(1 / 64)
    assert ahead(cells(spread), cells(spread * 0.9)) == pytest.approx(1)
    assert 1 / 64 < ahead(cells([None, *spread[1:] * 0.9]), cells(spread)) < 1


def test_the_mean_of_a_posterior_is_scored_in_place_of_the_estimate(make_record):
    record = make_record("carl", "abc-smc", 0, 0.1)
    record["mean"] = [value + 0.2 for value in record["theta_true"]]
    cells = labelled([record, make_record("carl", "abc-smc", 1, None), make_record("carl", "avo", 0, 0.1)])
    assert by_mean(cells)["squared_error"].tolist()[:2] == [pytest.approx(0.08), np.inf]
    assert np.isnan(by_mean(cells)["squared_error"].iloc[2])  # of a proposal there is none
