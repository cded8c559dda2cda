from types import SimpleNamespace

import numpy as np
import pytest
from measurements import LIGHT

from avobench.diagnosis.goodness_of_fit.gates import cell_gate


@pytest.mark.parametrize("events", [200, 3000])
def test_of_images_one_cell_that_fires_where_none_should_is_seen_and_few_images_suffice(events):
    class Still:
        def simulate(self, params, rng):
            return rng.random((len(params), 64)) < np.where(np.arange(64) < 8, 0.0, 0.002)

    still = SimpleNamespace(model=Still(), params=np.zeros(1))
    rng = np.random.default_rng(0)
    x = Still().simulate(np.zeros((events, 1)), rng)
    assert cell_gate(still, x, rng, LIGHT).p_value > 0.01
    x[:, 3] = rng.random(events) < 0.1
    gate = cell_gate(still, x, rng, LIGHT)
    assert gate.p_value < 1e-9
    assert np.isfinite(gate.statistic)
