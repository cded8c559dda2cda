"""The simulated sample of two muons: a Z boson, narrower than what was measured."""

import numpy as np
from dimuon_samples import simulated
from real.dimuons import HIGH, LOW, measured


def test_it_is_a_z_boson_and_narrower_than_what_was_measured():
    mass = simulated(1000)
    mass = mass[(mass > LOW) & (mass < HIGH)]
    assert len(mass) > 700
    assert abs(np.median(mass) - 91.0) < 0.3
    (low, high), (measured_low, measured_high) = (np.percentile(each, [25, 75]) for each in (mass, measured))
    assert 1.5 < high - low < measured_high - measured_low
