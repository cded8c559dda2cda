"""What may be said of a fit."""

from types import SimpleNamespace

import numpy as np
import pytest

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import Design


@pytest.mark.parametrize("rank", [2, 20, 300])
def test_slopes_of_noise_alone_identify_nothing(rank):
    """Also where few numbers are fitted, whose noise has a long tail."""
    rng, found = np.random.default_rng(0), 0
    for slopes in rng.normal(0, 100.0, (2000, rank, 1)):
        noise = np.array([[rank * 100.0**2]])
        fit = Fit(SimpleNamespace(dim=1), np.zeros(1), np.zeros(rank), slopes, noise, 1, 0, 0, 0, Design(0, np.eye(1)))
        found += fit.num_identified
    assert found < 10
