import numpy as np
import pytest
from scipy import stats

import avobench
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.summary.table import TableSummary, table_target
from avobench.effects.model import Model

EDGES = np.array([0, 0.5, 1, 2, 4])
DECAYS = avobench.task(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"lifetime": (0.5, 2)})


def tables():
    """Counts, whose shape alone is told; a density per event; and squares, two entries an event."""
    shares = np.diff(stats.expon.cdf(EDGES))
    return avobench.Tables(
        [
            avobench.Table(EDGES, np.round(5000 * shares), name="counts"),
            avobench.Table(EDGES, shares / np.diff(EDGES), errors=0.01 * np.ones(4), density=True, name="density"),
            avobench.Table(
                [0, 4, 16], [1.729, 0.234], errors=[0.1, 0.1], of=lambda x: np.hstack([x**2, x**2]), name="two"
            ),
        ]
    )


def events(n, seed=0, lifetime=1.0):
    return np.random.default_rng(seed).exponential(lifetime, (n, 1))


def test_the_summary_of_events_is_what_the_tables_compare_with():
    x = events(3000)
    compared = avobench.compare_tables(tables(), x)
    summary = table_target(tables(), x).summary
    np.testing.assert_allclose(summary.mean(x)[0], np.concatenate([row.expected for row in compared.rows]), rtol=1e-2)
    linear = slice(4, 10)  # a normalised table is one to first order
    np.testing.assert_allclose(summary.mean(x)[0, linear], np.concatenate([r.expected for r in compared.rows[1:]]))


def test_a_normalised_table_is_met_exactly_where_its_shape_is():
    table = avobench.Tables([avobench.Table([0, 1, 3], [0.5, 0.25], errors=[0.1, 0.1], density=True, normalised=True)])
    x = np.array([[0.5], [0.5], [2.0], [2.0], [9.0]])
    summary = table_target(table, x).summary
    assert summary.mean(x)[0] == pytest.approx([0.5, 0.25])
    assert summary.mean(x[1:])[0] == pytest.approx([0.5 - 5 / 32, 0.25 + 5 / 64])  # 1/4 of 4/5 against 1/2


def test_vectors_of_events_are_the_same_however_they_are_asked_for():
    x = events(150)
    summary = table_target(tables(), x).summary
    one_by_one = np.vstack([summary.mean(row[None]) for row in x])
    weights = np.random.default_rng(1).normal(size=(150, 2))
    np.testing.assert_allclose(summary.mean(x, 3), one_by_one.reshape(3, 50, -1).mean(axis=1))
    np.testing.assert_allclose(summary.moments(x, weights), weights.T @ one_by_one, atol=1e-9)
    np.testing.assert_allclose(summary.project(x, one_by_one[0]), one_by_one @ one_by_one[0])
    np.testing.assert_allclose(summary.covariance(x), np.cov(one_by_one, rowvar=False, bias=True), atol=1e-9)
    assert summary.moved(x, x).max() == 0
    assert summary.moved(x, events(150, 1)).mean() == pytest.approx(2, rel=0.3)  # two independent events
    assert [span.feature for span in summary.view(x).spans] == ["counts", "density", "two"]
    assert summary.alike(0.1).shape == (10, 10)


def test_chi_squared_is_that_of_the_tables_and_its_noise_that_of_the_simulation():
    """Counts of 5 000 events scatter as 5 000 simulated ones do; a shape has one degree of freedom less."""
    counts = avobench.Tables([tables().tables[0]])
    target = table_target(counts, events(200_000))
    assert target.num_events == pytest.approx(5000, rel=0.03)
    assert target.rank == 3
    x = events(4000, 3, 1.05)
    shares = np.histogram(x, EDGES)[0] / ((x >= 0) & (x <= 4)).sum()
    values = counts.values
    expected = stats.chisquare(shares * values.sum(), values).statistic
    away = target.whiten(target.mean - target.summary.mean(x)[0])
    assert (away**2).sum() == pytest.approx(expected, rel=0.1)
    every = table_target(tables(), events(200_000))
    noise = [(every.whiten(every.summary.mean(events(1000, s))[0] - every.mean) ** 2).sum() for s in range(200)]
    assert np.mean(noise) == pytest.approx(every.rank * every.num_events / 1000, rel=0.15)


def test_theta_is_fitted_to_tables_by_the_fit_of_the_diagnosis():
    target = table_target(tables(), events(20_000, lifetime=1.2))
    fit = refine(Model(DECAYS), target, np.array([0.6]), 0.3, np.random.default_rng(0), num_events=40_000)
    assert abs(fit.params[0] - 1) < 4 * fit.std[0] < 0.1
    assert isinstance(target.summary, TableSummary)
    assert fit.p_value > 0.001
