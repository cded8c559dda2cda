"""Effects that make the very same events cannot be told apart, by no amount of data."""

import numpy as np

from avobench.diagnosis import diagnose
from avobench.effects.catalogue import catalogue
from avobench.tasks.function import task


def test_a_shift_of_an_exponential_is_tied_with_a_lower_cut_of_it():
    """An exponential has no memory: above any value it is the whole of it, moved there."""
    decay = task(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"tau": (1, 4)}, name="decay")
    x = 0.5 + np.random.default_rng(0).exponential(2, (4000, 1))
    chosen = [effect for effect in catalogue(decay) if effect.name in ("offset", "edge_acceptance")]
    found = diagnose(decay, x, effects=chosen, max_effects=1).diagnosis
    (first,) = found.effects
    assert {first.name, *(rival.name for rival in first.tied_with)} == {"offset", "edge_acceptance"}
