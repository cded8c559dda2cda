import numpy as np
import pytest
from measurements import measured

from avobench.diagnosis.fit.descent import scan
from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson


@pytest.mark.parametrize("around", [None, 0.7, 0.3])
def test_a_scan_comes_near_the_best_or_as_near_as_it_may(around):
    task = Poisson()
    x, rng = measured(task, [2.0], 20_000, 4)
    model, target = Model(task), target_of(x, bins_of(x, x), x)
    (u,), near = scan(model, target, rng, around=None if around is None else np.array([around]))
    at = 0.6  # of log rates from -10 to 10
    within = at if around is None else np.clip(at, around - FIT.searched, around + FIT.searched)
    assert u == pytest.approx(within, abs=0.01)
    assert near < 0.01
