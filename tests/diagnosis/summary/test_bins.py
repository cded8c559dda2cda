import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import measured

from avobench.diagnosis.summary.bins import bin_of, bins_of, closed
from avobench.tasks.poisson import Poisson


def test_bins_hold_all_events_and_no_count_is_split():
    x, _rng = measured(Poisson(), [2.0], 5000, 0)
    bins = bins_of(x, x)
    assert bins.mean(x).sum() == pytest.approx(1)
    assert all(edge % 1 == 0.5 for edge in bins.edges[0])
    pieces = bins.mean(x, 5)
    np.testing.assert_allclose(pieces.mean(axis=0), bins.mean(x)[0])


@given(
    st.lists(st.floats(-10, 10), min_size=1, max_size=30),
    st.lists(st.integers(-9, 9), max_size=8, unique=True),
)
def test_edges_grow_also_where_only_simulated_events_lie(values, inner):
    inner = np.sort(np.array(inner, dtype=float))
    edges = closed(inner, np.array(values))
    assert (np.diff(edges) > 0).all()
    assert edges[0] <= min(values)
    assert edges[-1] >= max(values)
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


@pytest.mark.parametrize("edge", [-1.0, 0.0, 0.5, 3.0])
def test_a_count_at_an_edge_is_above_it(edge):
    x = np.tile(np.arange(-3, 6), 10)
    np.testing.assert_array_equal(bin_of(x, np.array([edge])), x >= edge)
