import numpy as np
import pytest

from avobench.challenge.shape import Place
from avobench.tasks.alignment import Alignment


@pytest.fixture(scope="module")
def tracker():
    """The tracker at 0.4 mm, with events of Pythia that are generated once."""
    (particles,) = Alignment().generate(1000, np.random.default_rng(0))

    class Recorded(Alignment):
        def generate(self, num_events, rng):
            start = rng.integers(1000 - num_events)
            yield particles.events(start, start + num_events)

    return Place(Recorded(), None, Recorded().detect(particles, np.full((1000, 1), 0.4)))
