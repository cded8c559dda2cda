import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import measured
from scipy.stats import spearmanr

from avobench.diagnosis.summary.bins import bin_of, bins_of, closed
from avobench.diagnosis.summary.pixels import pixels_of
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson


def test_bins_hold_all_events_and_no_count_is_split():
    x, _rng = measured(Poisson(), [2.0], 5000, 0)
    bins = bins_of(x, x)
    assert bins.mean(x).sum() == pytest.approx(1)
    assert all(edge % 1 == 0.5 for edge in bins.edges[0])


@pytest.mark.parametrize("table", [(447, 132, 42, 21, 3, 2), (168, 32, 16, 6, 1), (109, 65, 22, 3, 1)])
def test_each_count_of_a_small_table_has_a_bin_down_to_five_events(table):
    """Of accidents, cholera and horse kicks: a bin for each value, but for the rarest, which are merged."""
    x = np.repeat(np.arange(len(table)), table)[:, None]
    (edges,) = bins_of(x, x).edges
    own = sum(times >= 5 for times in table)
    assert len(edges) + 1 in (own, own + 1)
    assert (np.histogram(x, np.r_[-np.inf, edges, np.inf])[0] >= 5).all()


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=30), st.lists(st.integers(-9, 9), max_size=8, unique=True))
def test_edges_grow_also_where_only_simulated_events_lie(values, inner):
    inner = np.sort(np.array(inner, dtype=float))
    edges = closed(inner, np.array(values))
    assert (np.diff(edges) > 0).all()
    assert edges[0] <= min(values) <= max(values) <= edges[-1]
    np.testing.assert_array_equal(edges[1:-1], inner)


@given(
    dtype=st.sampled_from([np.dtype(code) for code in "?bhilqBHILQ"]),
    edges=st.lists(st.integers(-300, 300), unique=True, max_size=12),
    half=st.booleans(),
    whole=st.lists(st.integers(-(2**63), 2**64 - 1) | st.integers(-310, 310), min_size=1, max_size=5),
    repeated=st.sampled_from([1, 2000]),
)
def test_whole_numbers_are_in_the_bins_where_a_search_finds_them(dtype, edges, half, whole, repeated):
    """Of every type of whole numbers, its ends included, and few or many of them: the table is of many alone."""
    low, high = (0, 1) if dtype == np.dtype(bool) else (np.iinfo(dtype).min, np.iinfo(dtype).max)
    x = np.tile(np.array([low, high, *(value for value in whole if low <= value <= high)], dtype), repeated)
    inner = np.sort(np.array(edges, float)) + 0.5 * half
    np.testing.assert_array_equal(bin_of(x, inner), np.searchsorted(inner, x, side="right"))


def several(n, d, seed=0, correlation=0.0):
    """Standard normals (n, d), of which the first two are correlated."""
    x = np.random.default_rng(seed).standard_normal((n, d))
    x[:, 1] = correlation * x[:, 0] + np.sqrt(1 - correlation**2) * x[:, 1]
    return x


@pytest.mark.parametrize("d", [2, 5, 30])
def test_the_vector_of_an_event_is_one_however_it_is_asked_for(d):
    x, rng = several(800, d), np.random.default_rng(1)
    bins = bins_of(x, several(800, d, 2))
    rows = bins.moments(x, np.eye(len(x)))
    np.testing.assert_allclose(bins.mean(x, 4), rows.reshape(4, 200, -1).mean(axis=1), atol=1e-12)
    np.testing.assert_allclose(bins.covariance(x), np.cov(rows.T, bias=True), atol=1e-12)
    direction = rng.standard_normal((bins.size, 2))
    np.testing.assert_allclose(bins.project(x, direction), rows @ direction, atol=1e-9)
    np.testing.assert_array_equal(bins.moved(x, x), 0)


def test_a_product_is_the_rank_correlation_whatever_the_scale():
    x = several(20_000, 2, correlation=0.5)
    for each in (x, np.exp(3 * x)):
        bins = bins_of(each, each)
        assert bins.mean(each)[0, -1] == pytest.approx(spearmanr(*x.T).statistic, abs=0.02)


@pytest.mark.parametrize("constant", [False, True])
def test_of_two_hundred_features_the_covariance_stays_small_and_neighbours_have_their_product(constant):
    x = several(5200, 200)
    x[:, 100] = 0 if constant else x[:, 100]
    bins = bins_of(x, x)
    assert bins.size <= 1040
    assert {(j, j + 1) for j in range(199) if not constant or 100 not in (j, j + 1)} <= set(bins.products)
    assert len(bins.mean(x)[0]) == bins.size
    assert bins.left_out > 15_000


@pytest.mark.parametrize(("n", "d", "said"), [(60, 1000, "leave some out"), (750, 60, "about 1600 events")])
def test_too_many_features_are_refused_in_a_line(n, d, said):
    with pytest.raises(UsageError, match=said):
        bins_of(np.zeros((n, d)), np.zeros((n, d)))


@given(st.integers(0, 30))
def test_the_moments_of_images_add_up_also_where_there_are_none(cut):
    rng = np.random.default_rng(0)
    images, weights = rng.integers(0, 2, (30, 4 * 10)), rng.standard_normal((30, 3))
    summary = pixels_of(images, images, (4, 10))
    first, rest = summary.moments(images[:cut], weights[:cut]), summary.moments(images[cut:], weights[cut:])
    np.testing.assert_allclose(first + rest, summary.moments(images, weights), rtol=1e-5, atol=1e-5)
