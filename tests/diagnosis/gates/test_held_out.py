import numpy as np
import pytest
from measurements import LIGHT, measured, with_effect

from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.gates.held_out import HeldOut
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson


def test_the_gap_of_a_true_model_is_one_on_average():
    """The mean of 25: chi-squared over some ten degrees of freedom scatters by 0.45, the mean by 0.09."""
    gaps = []
    for k in range(25):
        x, rng = measured(Poisson(), [1.5], 4000, k)
        fit, target = fit_null(Model(Poisson()), x[:3000], rng, LIGHT, None)
        gaps.append(HeldOut.of(target, x[3000:]).gap(fit))
    assert np.mean([gap.value for gap in gaps]) == pytest.approx(1, abs=0.3)
    assert all(gap.low <= gap.value <= gap.high for gap in gaps)


def test_an_effect_that_is_there_shrinks_the_gap_and_a_wrong_size_of_it_is_vetoed():
    x = with_effect(Poisson(), "zero_inflation", [1.5], [0.1], 8000)
    rng = np.random.default_rng(0)
    null, target = fit_null(Model(Poisson()), x[:6000], rng, LIGHT, None)
    held_out = HeldOut.of(target, x[6000:])
    zeros = next(e for e in catalogue(Poisson()) if e.name == "zero_inflation")
    model = Model(Poisson(), (zeros,))
    fit = refine(model, target, model.to_cube(np.array([1.5, 0.1])), 0.01, rng, num_events=30_000)
    assert held_out.gap(fit).value < 2 < held_out.gap(null).value
    assert not held_out.grew(fit, null)
    assert held_out.grew(null, fit)
