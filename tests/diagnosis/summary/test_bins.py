import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import measured

from avobench.diagnosis.summary.bins import bins_of, closed
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
