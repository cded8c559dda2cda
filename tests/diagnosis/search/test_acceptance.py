from types import SimpleNamespace

import pytest

from avobench.diagnosis.search.acceptance import accepted, shown
from avobench.diagnosis.search.ranking import Ranked
from avobench.diagnosis.search.tested import Step
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.carl import Carl


@pytest.mark.parametrize(
    ("left", "p_value", "rejected", "expected"),
    [(105.0, 0.3, True, False), (150.0, 0.001, True, True), (150.0, 0.3, False, False), (150.0, 0.03, False, True)],
)
def test_what_only_the_classifier_sees_beside_an_effect_has_no_name(left, p_value, rejected, expected):
    gates = {"summary": SimpleNamespace(p_value=p_value), "classifier": SimpleNamespace(p_value=0.0001)}
    assert shown(Step(SimpleNamespace(noiseless_q=left, dof=100), None, gates), rejected, 0.05) == expected


def test_a_feature_that_is_cleared_counts_where_nothing_closes_the_whole_gap():
    effects = {e.key: e for e in catalogue(Carl())}

    def fit(gap, *keys):
        model = Model(Carl(), tuple(effects[key] for key in keys))
        return SimpleNamespace(model=model, noiseless_q=gap, noiseless_q_error=0.0, dof=100)

    keys = [("saturation", 4), ("resolution", 0), ("offset", 0), ("scale", 1)]
    ranks = [
        Ranked(effects[key], fit(700.0, key), score) for key, score in zip(keys, (0.0, 5.0, 9.0, 9.0), strict=True)
    ]
    null = Step(fit(1000.0), None, {}, ranks)

    def added(cleared, grew=()):
        step = accepted(
            [null],
            lambda new, old: new.model.effects[-1].key in grew,
            lambda new, old: new.model.effects[-1].key in cleared,
            True,
        )
        return step and (step.added.effect.key, [tie.effect.key for tie in step.ties])

    assert added([]) is None
    assert added(keys[1:]) == (keys[1], [keys[2]])  # a tie of another feature is none
    assert added(keys[1:], grew=[keys[1]]) == (keys[2], [keys[1]])
