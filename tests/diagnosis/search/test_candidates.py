from types import SimpleNamespace

import numpy as np

from avobench.diagnosis.search.candidates import on_all
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.carl import Carl


def test_what_acts_on_one_feature_is_tried_on_all():
    effects = {e.key: e for e in catalogue(Carl())}

    def fit(name, feature, shape, phi):
        chosen = next(e for e in effects[name, feature].shapes() if e.shape == shape)
        return SimpleNamespace(model=Model(Carl(), (chosen,)), params=np.array([0.5, -1.0, *phi]))

    def starts(*arguments):
        return on_all([fit(*arguments)], list(effects.values()))

    (start,) = starts("saturation", 2, "below", (0.04, 0.25))
    assert [(*effect.key, effect.shape) for effect in start.model.effects] == [("saturation", "all", "below")]
    np.testing.assert_allclose(start.model.from_cube(start.point), [0.5, -1.0, 0.04, 0.25])
    assert starts("saturation", "all", "below", (0.04, 0.25)) == []
    assert starts("dead_region", 2, "box", (0.5, 1.0, 0.5)) == []  # places are in units of each range where all
