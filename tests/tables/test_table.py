import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import avobench
from avobench.tables.comparison import Reduced
from avobench.tasks.errors import UsageError

EDGES = [0.0, 1, 2, 4]


def compared(tables, mean):
    """The comparison with a simulator whose mean entries are known, of which an event has one at most."""
    mean = np.array(mean)
    return avobench.compare_tables(tables, Reduced(mean, np.diag(mean) - np.outer(mean, mean), 10**12))


@given(st.lists(st.integers(1, 500), min_size=3, max_size=8), st.data())
def test_counts_have_the_chi_squared_of_pearson(counts, data):
    """Of shapes if the number of events is unknown, with one degree of freedom less; else of those outside too."""
    shares = np.array(data.draw(st.lists(st.integers(1, 50), min_size=len(counts), max_size=len(counts))), float)
    shares /= shares.sum()
    edges = np.arange(len(counts) + 1)
    expected = stats.chisquare(counts, shares * sum(counts))
    shape = compared(avobench.Table(edges, counts), shares / 3)  # whatever share of events is in the bins
    assert shape.chi_squared == pytest.approx(expected.statistic, rel=1e-6, abs=1e-6)
    assert shape.dof == len(counts) - 1
    assert shape.p_value == pytest.approx(expected.pvalue, rel=1e-4)
    rated = compared(avobench.Table(edges, counts, num_events=2 * sum(counts)), 0.6 * shares)
    every = stats.chisquare([*counts, sum(counts)], 2 * sum(counts) * np.append(0.6 * shares, 0.4))
    assert rated.chi_squared == pytest.approx(every.statistic, rel=1e-6)
    assert rated.dof == len(counts)


def test_chi_squared_of_a_right_simulator_is_distributed_as_one():
    """An exponential, simulated with as many events as were measured: half of the covariance is the simulation's."""
    rng, found = np.random.default_rng(1), []
    edges = np.array([0, 0.5, 1, 2, 3])
    for _ in range(300):
        x, simulated = rng.exponential(1, (2, 3000, 1))
        found.append(avobench.compare_tables(avobench.Table(edges, np.histogram(x, edges)[0]), simulated).p_value)
    assert stats.kstest(found, "uniform").pvalue > 0.001


WIDE = [0, 0.3, 1, 1.5, 3, 7, 20]


@pytest.mark.parametrize("kind", ["shape", "number", "errors"])
@pytest.mark.parametrize(
    ("edges", "scale", "measured", "simulated"),
    [(np.arange(13), 1, 2000, 2000), (np.arange(13), 1, 200_000, 10_000), (WIDE, 2, 3000, 30), (WIDE, 2, 3000, 10)],
)
def test_few_simulated_events_and_empty_bins_make_no_false_alarm(kind, edges, scale, measured, simulated):
    rng, found = np.random.default_rng(0), []
    truth = np.diff(stats.expon.cdf(edges, scale=scale))
    for _ in range(100):
        if kind == "errors":
            values = np.abs(truth * (1 + 0.03 * rng.normal(size=len(truth))))
            table = avobench.Table(edges, values, errors=0.03 * truth)
        else:
            counts = np.histogram(rng.exponential(scale, measured), edges)[0]
            table = avobench.Table(edges, counts, num_events=measured if kind == "number" else None)
        found.append(avobench.compare_tables(table, rng.exponential(scale, simulated)).p_value)
    assert np.sum(np.array(found) < 0.001) <= 2


@given(st.data(), st.integers(2, 8), st.booleans())
def test_no_chi_squared_is_larger_than_the_pulls_explain(data, k, known):
    """All events are in the bins, whichever of these are empty: each pull is of a bin against all others."""
    counts = st.lists(st.integers(0, 30), min_size=k, max_size=k).filter(lambda n: sum(n) > 1)
    measured, simulated = data.draw(counts), data.draw(counts)
    table = avobench.Table(np.arange(k + 1), measured, num_events=sum(measured) if known else None)
    found = avobench.compare_tables(table, np.repeat(np.arange(k) + 0.5, simulated))
    assert found.dof == k - 1
    assert found.chi_squared <= (found.rows[0].pulls ** 2).sum() * 1.001


@pytest.mark.parametrize("more", [{}, {"num_events": 300}])
def test_a_right_simulator_of_particles_that_go_together_is_rarely_rejected(more):
    """Ten of each event follow its energy, so that their counts scatter far more than as Poisson says."""
    rng, found, edges = np.random.default_rng(0), [], [0, 0.5, 1, 2, 4, 30]

    def particles(n):
        return rng.exponential(1.0, (n, 1)) * rng.uniform(0.8, 1.2, (n, 10))

    for _ in range(200):
        table = avobench.Table(edges, np.histogram(particles(300), edges)[0], of=lambda events: events, **more)
        found.append(avobench.compare_tables(table, particles(3000)).p_value)
    assert stats.binomtest(int((np.array(found) < 0.05).sum()), 200, 0.05).pvalue > 0.001


def test_how_many_of_known_events_are_in_a_bin_scatters_binomially():
    """Also where it is nearly all of them; no bin is then left to scatter, unless one was measured outside."""
    row = compared(avobench.Table([0, 5], [900], num_events=1000), [0.92]).rows[0]
    assert row.chi_squared == pytest.approx((900 - 920) ** 2 / (1000 * 0.92 * 0.08))
    x = np.repeat([0.5, 1.5, 3], 400)
    within = avobench.compare_tables(avobench.Table(EDGES, [100, 105, 95], num_events=300), x)
    outside = avobench.compare_tables(avobench.Table(EDGES, [93, 93, 93], num_events=300), x)
    assert within.dof == 2
    assert within.p_value > 0.1
    assert outside.p_value < 1e-6


def test_a_normalised_density_is_that_of_its_distribution_whatever_lies_outside():
    edges = np.linspace(0, 2, 9)
    shares = np.diff(stats.expon.cdf(edges))
    truth = shares / shares.sum() / np.diff(edges)
    table = avobench.Table(edges, truth, errors=0.1 * truth, density=True, normalised=True)
    assert compared(table, shares).chi_squared == pytest.approx(0, abs=1e-12)
    assert compared(table, 5 * shares).dof == 7
    tilted = shares * np.linspace(0.9, 1.1, 8)
    away = tilted / tilted.sum() / np.diff(edges) - truth
    # With the free scale that makes it least, which is what a singular covariance means.
    scale = (away / truth).sum() / len(truth)
    expected = (((away - scale * truth) / (0.1 * truth)) ** 2).sum()
    assert compared(table, tilted).chi_squared == pytest.approx(expected)


def test_a_joint_covariance_in_blocks_is_that_of_the_tables_alone():
    """And one across the tables is not: a common shift is then no surprise."""
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 3, 3))
    blocks = [a @ a.T + np.eye(3), b @ b.T + np.eye(3)]
    values, x = [1.0, 2, 3], rng.exponential(1, (500, 1))
    apart = [avobench.Table(EDGES, values, covariance=block, name=str(i)) for i, block in enumerate(blocks)]
    bare = [avobench.Table(EDGES, values, errors=np.ones(3)) for _ in blocks]
    joint = np.block([[blocks[0], np.zeros((3, 3))], [np.zeros((3, 3)), blocks[1]]])
    one, other = avobench.compare_tables(apart, x), avobench.compare_tables(avobench.Tables(bare, covariance=joint), x)
    assert one.chi_squared == pytest.approx(other.chi_squared)
    assert [row.chi_squared for row in one.rows] == pytest.approx([row.chi_squared for row in other.rows])
    alone = [compared(table, [1.5, 2.5, 3.5]) for table in apart]
    both = compared(apart, [1.5, 2.5, 3.5] * 2)
    assert both.chi_squared == pytest.approx(sum(each.chi_squared for each in alone))
    shared = avobench.Tables(bare, covariance=np.eye(6) * 1e-3 + 10)
    assert compared(shared, [2.0, 3, 4] * 2).chi_squared < 1 < compared(shared, [2.0, 2, 4] * 2).chi_squared


def test_a_covariance_may_be_symmetric_up_to_rounding():
    given = np.diag([400.0, 300, 200])
    given[0, 2] = 2e-18
    cov = avobench.Table(EDGES, [1, 2, 3], covariance=given, normalised=True).covariance
    assert (cov == cov.T).all()


def test_entries_are_counted_for_particles_as_for_events():
    """NaN is none, an event may have none, the last upper edge belongs to its bin, and what lies outside to none."""
    particles = [np.array([0.0, 0.5, 4.0]), np.array([]), np.array([1.0, np.nan, -0.1, 4.1])]
    padded = np.array([[0.0, 0.5, 4.0, np.nan], [np.nan] * 4, [1.0, np.nan, -0.1, 4.1]])
    wanted = [[2, 0, 1], [0, 0, 0], [0, 1, 0]]
    for given_as in (particles, padded):
        table = avobench.Table(EDGES, [1, 1, 1], of=lambda events, found=given_as: found)
        np.testing.assert_array_equal(table.entries(np.empty((3, 1))).toarray(), wanted)


@given(st.lists(st.floats(-9, 9), min_size=2, max_size=50), st.booleans(), st.booleans())
def test_open_bins_hold_all_that_lies_beyond_their_edge(x, below, above):
    """As bins do whose edges are far away."""
    far, wide = (avobench.Table([-end if below else -1, 0, 1, end if above else 2], [3, 4, 5]) for end in (1e3, np.inf))
    np.testing.assert_array_equal(*(table.entries(np.array(x)).toarray() for table in (far, wide)))
    assert wide.drawn.tolist() == [-1, 0, 1, 2]


def test_spectra_of_particles_are_per_event_and_their_noise_knows_that_they_come_together():
    """Ten particles an event in one bin: the mean is exact, however Poisson their sum would scatter."""
    table = avobench.Table([0, 2], [5.0], errors=[0.1], density=True, of=lambda events: [np.ones(10)] * len(events))
    row = avobench.compare_tables(table, np.empty((100, 1))).rows[0]
    assert row.expected == pytest.approx([5])
    assert Reduced.of(avobench.Tables([table]), np.empty((100, 1))).covariance == pytest.approx(0)
    assert row.dof == 1


def test_an_empty_bin_of_counts_does_not_make_chi_squared_infinite():
    """A measured event where none was simulated is far away, but as far as one simulated event says."""
    table = avobench.Table(EDGES, [50, 49, 1])
    x = np.repeat([0.5, 1.5], 500)[:, None]
    assert 5 < avobench.compare_tables(table, x).chi_squared < 50


def test_parts_together_are_the_whole():
    table, x = avobench.Tables([avobench.Table(EDGES, [3, 3, 3])]), np.random.default_rng(0).exponential(1, (90, 1))
    parts = Reduced.together([Reduced.of(table, x[:20]), Reduced.of(table, x[20:])])
    whole = Reduced.of(table, x)
    np.testing.assert_allclose(parts.covariance, whole.covariance, atol=1e-12)
    assert (parts.mean == pytest.approx(whole.mean), parts.num_events) == (True, 90)


def test_the_answer_names_tables_and_their_furthest_bins():
    table = avobench.Table(EDGES, [100, 100, 100], name="near")
    said = str(compared(table, [0.2, 0.35, 0.45]))
    assert "near" in said
    assert "0 to 1: -5.8" in said


GOOD = {"edges": EDGES, "values": [1.0, 2, 3]}


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({"values": [1, 2]}, "4 edges make 3 bins, but there are 2 values"),
        ({"edges": [0, 1, 1, 2]}, "increase"),
        ({"edges": [0, np.nan, 1, 2]}, "NaN"),
        ({"edges": [0, 1, np.inf, np.inf]}, "increase"),
        ({"edges": [0, 1, 2, np.inf], "density": True}, "no open bins"),
        ({"values": ["a", 1, 2]}, "numbers"),
        ({"values": [1, -2, 3]}, "negative"),
        ({"values": [1, np.nan, 3]}, "finite"),
        ({"values": [0, 0, 0]}, "zero"),
        ({"values": [0.1, 0.2, 0.3]}, "no counts: .* root of the sum of squared weights"),
        ({"values": [2_000_000.5, 3, 4]}, "no counts"),
        ({"errors": [1, 0, 1]}, "bin 2 must be positive"),
        ({"errors": [1, 1]}, "2 errors for 3 values"),
        ({"errors": [1, 1, 1], "covariance": np.eye(3)}, "not both"),
        *[({name: np.ma.masked_greater(GOOD["values"], 2)}, "masked") for name in ("values", "errors")],
        ({"edges": np.ma.masked_greater(EDGES, 3)}, "masked"),
        ({"covariance": np.ma.masked_less(np.eye(3), 1)}, "masked"),
        ({"covariance": np.eye(2)}, "shape"),
        ({"covariance": np.diag([1.0, 0, 1])}, "variance of 0"),
        ({"covariance": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "not positive"),
        ({"covariance": [[1, 0.5, 0], [0.4, 1, 0], [0, 0, 1]]}, "symmetric"),
        ({"covariance": np.full((3, 3), np.nan)}, "finite"),
        ({"normalised": True, "num_events": 5}, "num_events or normalised"),
        ({"num_events": -1}, "positive"),
        ({"num_events": 5}, "6 entries are more than num_events=5"),
        ({"values": [10, 20, 30], "errors": [3, 4, 5]}, "normalised=True"),
    ],
)
def test_what_cannot_be_a_table_is_told_in_one_line(changed, word):
    with pytest.raises(UsageError, match=word) as raised:
        avobench.Tables([avobench.Table(**{**GOOD, **changed}, name="t")])
    assert "\n" not in str(raised.value)
    assert "table t" in str(raised.value)


@pytest.mark.parametrize(
    ("events", "read", "word"),
    [
        (np.ones((3, 1)), {"of": lambda events: np.ones(2)}, "2 for 3 events"),
        (np.ones((3, 1)), {"of": lambda events: np.ones((3, 1, 1))}, "list of arrays"),
        (np.ones((3, 1)), {"of": lambda events: np.full(3, 99.0)}, "no simulated event has an entry"),
        (np.ones((3, 1)), {"feature": 1}, "no feature 1"),
        (np.ones((3, 2, 2)), {"feature": 0}, "shape of"),
        ([[1, 2], [3, 4]], {"feature": "a"}, "no column 'a'"),
        (np.ones((0, 1)), {"feature": 0}, "got 0"),
    ],
)
def test_what_cannot_be_binned_is_told_in_one_line(events, read, word):
    with pytest.raises(UsageError, match=word):
        avobench.compare_tables(avobench.Table(**GOOD, **read), events)


def test_a_feature_is_a_column_by_number_or_name():
    x = np.random.default_rng(0).exponential(1, (50, 2))
    frame = pd.DataFrame(x, columns=["a", "b"])
    for events, feature in [(x, 1), (frame, 1), (frame, "b"), (x[:, 1], 0)]:
        got = avobench.Table(**GOOD, feature=feature).entries(events).sum(axis=0)
        assert got.tolist() == np.histogram(x[:, 1], EDGES)[0].tolist()


def test_sums_are_refused_where_their_joint_covariance_tells_that_they_are_no_entries_per_event():
    tables, cov = [avobench.Table(EDGES, [10.5, 20, 30], name="sums")], 9 * np.eye(3)
    with pytest.raises(UsageError, match="table sums"):
        avobench.Tables(tables, covariance=cov)
    assert avobench.Tables([avobench.Table(EDGES, [10.5, 20, 30], normalised=True)], covariance=cov)


@pytest.mark.parametrize("tables", [[], [GOOD]])
def test_tables_that_do_not_fit_together_are_told_in_one_line(tables):
    with pytest.raises(UsageError, match=r"give one at least|shape"):
        avobench.Tables([avobench.Table(**each) for each in tables], covariance=np.eye(5))
