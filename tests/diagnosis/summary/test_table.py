import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.linalg import block_diag

import avobench
from avobench.diagnosis.summary.published import TablePart, tables_of
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson

EDGES = np.array([0, 0.5, 1, 2, 4])
DECAYS = avobench.task(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"lifetime": (0.5, 2)})


def tables():
    """Counts, whose shape alone is told; a density per event; and squares, two entries an event."""
    shares, two = np.diff(stats.expon.cdf(EDGES)), {"of": lambda x: np.hstack([x**2, x**2]), "errors": [0.1, 0.1]}
    counts = avobench.Table(EDGES, np.round(5000 * shares), name="counts")
    density = {"errors": 0.01 * np.ones(4), "density": True, "name": "density"}
    density = avobench.Table(EDGES, shares / np.diff(EDGES), **density)
    return avobench.Tables([counts, density, avobench.Table([0, 4, 16], [1.729, 0.234], name="two", **two)])


def events(n, seed=0, lifetime=1.0):
    return np.random.default_rng(seed).exponential(lifetime, (n, 1))


def target_of(published, x):
    return TablePart.whole(tables_of(DECAYS, published), x).target(x)


def test_the_summary_of_events_is_what_the_tables_compare_with():
    x = events(3000)
    compared = avobench.compare_tables(tables(), x)
    summary = target_of(tables(), x).summary
    wanted = np.concatenate([row.expected for row in compared.rows])
    np.testing.assert_allclose(summary.mean(x)[0], wanted)
    parts = summary.mean(x, 3)
    np.testing.assert_allclose(parts[1], summary.mean(x[1000:2000])[0])


def test_values_are_expanded_about_any_mean_of_entries():
    """A normalised table compares ratios: exactly where the expansion begins, to second order beside it."""
    x, away = events(3000), events(3000, 1, 1.3)
    summary = target_of(tables(), x).summary
    m, n = (summary.moments(each, np.full((3000, 1), 1 / 3000))[0] for each in (away, x))
    for step in (0.01, 0.001):
        there, slope = summary.linear(np.stack([m, step * (n - m)]))
        np.testing.assert_allclose(there, summary.mean(away)[0])
        np.testing.assert_allclose(there + slope, summary.values(m + step * (n - m)), rtol=step**2)


def test_no_entries_in_a_normalised_table_do_not_agree_with_it():
    """A model that makes none would else have nothing to disagree by."""
    target = target_of(avobench.Tables([avobench.Table(EDGES, [2000, 1500, 1100, 400])]), events(3000))
    none = target.summary.values(np.zeros(4))
    assert none.sum() == pytest.approx(5000)
    assert (target.whiten(none - target.mean) ** 2).sum() > 1000


def test_vectors_of_events_are_the_same_however_they_are_asked_for():
    x = events(150)
    summary = target_of(tables(), x).summary
    one_by_one = summary.moments(x, np.eye(150))
    weights, along = np.random.default_rng(1).normal(size=(150, 2)), np.arange(summary.size)
    np.testing.assert_allclose(summary.moments(x, weights), weights.T @ one_by_one, atol=1e-9)
    near = summary.linear(np.vstack([one_by_one.mean(axis=0), one_by_one]))[1:]
    np.testing.assert_allclose(summary.project(x, along), near @ along)
    np.testing.assert_allclose(summary.covariance(x), np.cov(near, rowvar=False, bias=True), atol=1e-9)
    assert summary.moved(x, x).max() == 0
    assert summary.moved(x, events(150, 1)).mean() == pytest.approx(2, rel=0.3)  # two independent events
    spans = [(span.feature, span.name) for span in summary.view(x).spans]
    assert spans == [(0, "counts"), (0, "density"), ("two", "two")]


def test_chi_squared_is_that_of_the_tables_and_its_noise_that_of_the_simulation():
    """Counts of 5 000 events scatter as 5 000 simulated ones do; a shape has one degree of freedom less."""
    counts = avobench.Tables([tables().tables[0]])
    target = target_of(counts, events(200_000))
    assert target.num_events == pytest.approx(5000, rel=0.03)
    assert target.rank == 3
    x = events(4000, 3, 1.05)
    shares = np.histogram(x, EDGES)[0] / ((x >= 0) & (x <= 4)).sum()
    values = counts.values
    expected = stats.chisquare(shares * values.sum(), values).statistic
    away = target.whiten(target.mean - target.summary.mean(x)[0])
    assert (away**2).sum() == pytest.approx(expected, rel=0.1)
    every = target_of(tables(), events(200_000))
    noise = [(every.whiten(every.summary.mean(events(1000, s))[0] - every.mean) ** 2).sum() for s in range(200)]
    assert np.mean(noise) == pytest.approx(every.rank * every.num_events / 1000, rel=0.15)


@given(st.lists(st.integers(0, 400), min_size=3, max_size=12).filter(lambda n: sum(n) > 60), st.integers(0, 99))
def test_bins_of_few_counts_are_merged_and_no_count_is_lost(counts, seed):
    x = np.random.default_rng(seed).uniform(0, len(counts), (500, 1))
    target = target_of(avobench.Tables([avobench.Table(np.arange(len(counts) + 1), counts)]), x)
    assert target.mean.sum() == pytest.approx(sum(counts))
    (table,) = target.summary.tables
    simulated = np.histogram(x, table.edges)[0] * sum(counts) / 500
    assert len(target.mean) == 1 or np.maximum(simulated, target.mean / 3).min() >= 12 - 1e-9
    assert set(table.edges) <= set(range(len(counts) + 1))


@pytest.mark.parametrize(
    ("more", "entries"),
    [({}, 1), ({"num_events": 4000}, 1), ({"num_events": 4000, "of": lambda x: np.hstack([x, x, x])}, 3)],
)
def test_both_parts_of_tables_are_independent_and_scatter_as_their_shares_do(more, entries):
    """Of counts, one or three of each event, and of a density with correlated errors, a quarter kept aside."""
    rng, published = np.random.default_rng(0), []
    shares, x = np.diff(stats.expon.cdf(EDGES)), events(20_000)
    cov = 1e-4 * np.diag(shares) + 0.003**2
    every = np.append(shares, 1 - shares.sum()) if more else shares / shares.sum()
    for _ in range(400):
        counts = entries * rng.multinomial(4000, every)[:4]
        density = rng.multivariate_normal(shares, cov)
        both = [avobench.Table(EDGES, counts, **more), avobench.Table(EDGES, density, covariance=cov)]
        published.append(TablePart.whole(tables_of(DECAYS, avobench.Tables(both)), x).split(0.25, rng))
    values = np.array([np.concatenate([fitted.values, aside.values]) for fitted, aside in published])
    scatter, p = np.cov(values, rowvar=False), every[:4]
    exact = block_diag(entries**2 * 4000 * (np.diag(p) - np.outer(p, p)), cov)
    error = np.sqrt(np.outer(np.diag(exact), np.diag(exact)) * 2 / 400)
    for part, expected in ((scatter[:8, :8], exact / 0.75), (scatter[8:, 8:], 4 * exact), (scatter[:8, 8:], 0)):
        assert np.abs((part - expected) / (4 * error)).max() < 4.5
    assert values[:, :8].mean(axis=0) == pytest.approx(values[:, 8:].mean(axis=0), rel=0.02)


def test_rare_counts_of_any_number_of_events_are_kept_aside():
    table = avobench.Table(EDGES, [4000, 2000, 1000, 400], num_events=10**12)
    part = TablePart.whole(tables_of(DECAYS, avobench.Tables([table])), events(2000))
    for each in part.split(0.25, np.random.default_rng(0)):
        assert np.abs((each.values - table.values) / np.sqrt(4 * table.values)).max() < 4.5


def test_events_as_a_table_shows_them_have_its_counts():
    """For what effects read off events: whole numbers, or values within the bins, without steps that are none."""
    task, x = Poisson(), Poisson().simulate(np.full((3000, 1), 1.5), np.random.default_rng(0))
    counts = np.bincount(x[:, 0])
    table = tables_of(task, avobench.Tables([avobench.Table(np.arange(len(counts) + 1) - 0.5, counts)]))
    part = TablePart.whole(table, x)
    shown = part.as_events(task, x[:100], np.random.default_rng(1))
    assert shown.dtype == x.dtype
    share = np.bincount(shown[:, 0], minlength=len(counts)) / len(shown)
    assert share == pytest.approx(counts / 3000, abs=2 / len(shown))
    real = TablePart.whole(tables_of(DECAYS, avobench.Tables([avobench.Table(EDGES, [50, 30, 20, 10])])), events(500))
    shown = real.as_events(DECAYS, events(500), np.random.default_rng(1))[:, 0]
    assert np.histogram(shown, EDGES)[0] / len(shown) == pytest.approx(np.array([50, 30, 20, 10]) / 110, abs=0.02)
    assert len(np.unique(shown)) == len(shown)


@pytest.mark.parametrize(
    ("table", "word"),
    [
        ({"feature": "energy"}, "no feature energy; it has: x1"),
        ({"feature": 1}, "no feature 1"),
        ({"unit": "keV"}, "in keV, and decays makes x1 in s"),
        ({"values": [9, 8, 7, 6]}, "30 entries are too few"),
    ],
)
def test_tables_that_are_not_of_the_task_are_told_in_one_line(table, word):
    decays = avobench.task(DECAYS.function, name="decays", prior={"lifetime": (0.5, 2)}, feature_units={"x1": "s"})
    with pytest.raises(UsageError, match=word):
        tables_of(decays, avobench.Tables([avobench.Table(**{"edges": EDGES, "values": [90, 80, 70, 60], **table})]))
