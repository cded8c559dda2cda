from types import SimpleNamespace

import numpy as np

from avobench.diagnosis.search.alike import distinct
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.weinberg import Weinberg


def test_of_a_family_fits_of_other_shapes_are_repeated_first():
    """The right shape may be seen worse than two fits of a wrong one, as long as events are few."""
    scale = next(e for e in catalogue(Weinberg()) if e.name == "scale")
    shapes = {s.shape: s for s in scale.shapes()}

    def fitted(shape, gap):
        model = Model(Weinberg(), (shapes[shape],))
        return SimpleNamespace(model=model, noiseless_q=gap, point=np.full(model.dim, gap / 100))

    fits = [fitted("cubic", 10.0), fitted("cubic", 10.1), fitted("cubic", 20.0), fitted("linear", 40.0)]
    assert [fit.noiseless_q for fit in distinct(fits)] == [10.0, 20.0, 40.0]
    assert [fit.noiseless_q for fit in distinct(fits, 2)] == [10.0, 40.0]
