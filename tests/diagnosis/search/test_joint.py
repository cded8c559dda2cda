import numpy as np

from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.search.joint import reshaped
from avobench.diagnosis.search.ranking import TIE
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson


def test_beside_a_second_effect_the_first_is_tried_in_its_other_shapes():
    """Alone, rounding down imitates rounding to the nearest and zeros beside it. Together both have their size."""
    effects, rng = {e.name: e for e in catalogue(Poisson())}, np.random.default_rng(1)
    zeros, shapes = effects["zero_inflation"], {s.shape: s for s in effects["quantisation"].shapes()}
    x = Model(Poisson(), (zeros, shapes["4 nearest"])).simulate(np.tile([1.5, 0.05, 0.1], (10_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)

    def fitted(*chosen, start):
        model = Model(Poisson(), chosen)
        return refine(model, target, model.to_cube(np.array(start)), 0.02, rng, num_events=30_000)

    down, nearest = (fitted(shapes[name], start=[1.5, 0.1]) for name in ("4 down", "4 nearest"))
    assert down.noiseless_q < nearest.noiseless_q
    pair = fitted(shapes["4 down"], zeros, start=[1.5, 0.1, 0.01])
    known = down.known(target, 100_000, rng)
    ((better, beside),) = reshaped([pair], known, (nearest,), target, rng, effort_for(Poisson(), "counts", None), 1e4)
    assert [effect.shape for effect in better.model.effects] == ["4 nearest", "dead"]
    assert beside.model.effects == (shapes["4 nearest"],)
    assert better.noiseless_q < better.dof + 4 * np.sqrt(2 * better.dof)
    assert better.noiseless_q < pair.noiseless_q - TIE
    np.testing.assert_allclose(better.params[1:], [0.1, 0.05], atol=0.02)
