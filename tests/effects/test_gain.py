"""One row or column of an image that records less: what it does, and how it is found."""

import numpy as np
import pytest
from measurements import applied, shape_of

from avobench.effects.images.cells import Gain, odd_line

GRID = (12, 16)


def profile(n, rng, kind):
    """Images whose rows follow a bump, as of a layer that is crossed at different angles: (n, 192)."""
    rate = 0.1 + 0.15 * np.exp(-((np.arange(12) - 4) ** 2) / 20)
    hits = rng.random((n, *GRID)) < rate[:, None]
    return (hits if kind == "hits" else hits * rng.gamma(2, 1, hits.shape)).reshape(n, -1)


@pytest.mark.parametrize(("line", "axis", "at"), [("row", 0, 7), ("column", 1, 0)])
@pytest.mark.parametrize(("kind", "gain"), [("hits", 0.6), ("energies", 0.8), ("energies", 1.3), ("hits", 0.0)])
def test_a_line_records_its_share_and_is_named(line, axis, at, kind, gain):
    n = 20_000
    x = profile(n, np.random.default_rng(0), kind).astype(np.uint8 if kind == "hits" else np.float32)
    effect = shape_of(Gain(GRID, hits=kind == "hits"), line)
    y = applied(effect, x, [gain, at], seed=1)
    assert y.dtype == x.dtype
    before, after = (np.moveaxis(v.reshape(-1, *GRID), 1 + axis, 1) for v in (x, y))
    others = np.arange(GRID[axis]) != at
    np.testing.assert_array_equal(before[:, others], after[:, others])
    if kind == "energies":
        np.testing.assert_allclose(after[:, at], gain * before[:, at], rtol=1e-6)
    else:
        total = before[:, at].sum()
        assert after[:, at].sum() == pytest.approx(gain * total, abs=5 * np.sqrt(gain * (1 - gain) * total))
    adapted = effect.adapted(y)
    assert adapted.odd[axis] == at
    assert adapted.odd[1 - axis] is None
    named = shape_of(adapted, line).parameters[1]
    assert (named.name, named.unit) == (line, line)
    assert round(named.low) == round(named.high) == at
    other = next(s for s in adapted.shapes() if s.shape != line)
    assert len(other.guess(y)) == 0


def test_a_profile_that_bends_is_no_fault():
    x = profile(50_000, np.random.default_rng(0), "hits")
    assert odd_line(x, GRID, 0) is None
    assert odd_line(x, GRID, 1) is None
    assert odd_line(np.zeros((10, 192)), GRID, 0) is None


def test_each_event_may_have_its_own_line():
    rng = np.random.default_rng(0)
    x = np.ones((50, 192), np.uint8)
    rows = rng.integers(12, size=50)
    y = applied(Gain(GRID), x, np.column_stack([np.zeros(50), rows])).reshape(-1, *GRID)
    assert (y.sum(axis=(1, 2)) == 192 - 16).all()
    assert (y[np.arange(50), rows] == 0).all()
