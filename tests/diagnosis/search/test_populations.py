"""Where two populations are looked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.search.populations import best_pairs, populations
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.function import task


def heights(theta, rng):
    return rng.normal(theta[:, 0], theta[:, 1])


HEIGHTS = task(heights, prior={"mean": (-10, 10), "width": (0.2, 8)}, features=["height"], name="heights")


@given(st.floats(0.05, 0.45), st.integers(0, 1000))
def test_the_pair_of_which_a_mean_is_the_mixture_is_found_with_its_share(share, seed):
    rng = np.random.default_rng(seed)
    means = rng.standard_normal((8, 20))
    mixed = (1 - share) * means[2] + share * means[5]
    pairs, shares, q = best_pairs(mixed - means, 0.0, np.ones(8, bool))
    assert pairs[0].tolist() == [2, 5]
    assert shares[0] == pytest.approx(share)
    assert q[0] == pytest.approx(0, abs=1e-9)


def test_two_narrow_populations_far_from_where_one_wide_one_fits_are_found():
    rng = np.random.default_rng(1)
    x = np.concatenate([rng.normal(-4, 0.5, 1400), rng.normal(3, 0.5, 600)])[:, None]
    null, target = fit_null(Model(HEIGHTS), x, rng, Effort(rounds=3), None)
    effect = next(effect for effect in catalogue(HEIGHTS) if effect.name == "mixture")
    start = populations(null, target, effect, rng, Effort())[0]
    np.testing.assert_allclose(start.model.from_cube(start.point), [-4, 0.5, 0.3, 3, 0.5], atol=0.3)
    assert start.expected < 0.1 * null.noiseless_q
