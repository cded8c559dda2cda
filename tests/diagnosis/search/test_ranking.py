from types import SimpleNamespace

import numpy as np
import pytest

from avobench.diagnosis.search.ranking import ranking
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.weinberg import Weinberg


@pytest.mark.parametrize(("stretch", "first"), [(-0.01, "scale"), (-0.15, "edge_acceptance")])
def test_of_two_effects_that_fit_alike_an_unusual_strength_is_the_less_likely(stretch, first):
    effects = {effect.name: effect for effect in catalogue(Weinberg())}
    fits = []
    for name, phi in (("scale", [stretch]), ("edge_acceptance", [0.5, 4.0])):
        model = Model(Weinberg(), (effects[name],))
        params = np.array([45.0, 1.0, *phi])
        fits.append(
            SimpleNamespace(
                model=model, params=params, point=model.to_cube(params), noiseless_q=40.0, noiseless_q_error=1.0, dof=40
            )
        )
    assert ranking(fits, 1000.0)[0].effect.name == first
