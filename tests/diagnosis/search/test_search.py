"""The search for what is missing, on counts in which it is known."""

import numpy as np
import pytest
from measurements import with_effect

from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.experience.recogniser import OUTSIDE
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.search.search import Search
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks.poisson import Poisson

SOME = ("zero_inflation", "overdispersion", "flat_background", "dead_time")


EFFECTS = [effect for effect in catalogue(Poisson()) if effect.name in SOME]


@pytest.mark.parametrize("max_effects", [0, 3])
def test_a_hidden_effect_is_the_most_probable_and_none_is_tried_where_none_may_be_added(max_effects):
    x = with_effect(Poisson(), "zero_inflation", [1.5], [0.1], 6000)
    rng, effort = np.random.default_rng(1), effort_for(Poisson(), "counts", None, 20_000).scaled(0.3)
    null, target = fit_null(Model(Poisson(), events=Counted(Poisson())), x, rng, effort, None)
    found = Search(target, x, EFFECTS, max_effects, rng, effort, 1).posterior(null)
    if max_effects:
        assert [effect.name for effect in found.best.fit.model.effects] == ["zero_inflation"]
        assert found.included["zero_inflation", None] > 0.5
    else:
        assert (found.best, found.included) == (None, {})


def test_what_the_events_look_like_is_asked_only_with_experience():
    counts = np.random.default_rng(0).poisson(12, (500, 1))

    def looks(experience):
        search = Search(None, counts, EFFECTS, 1, np.random.default_rng(1), None, 1, experience=experience)
        return search.like(Model(Poisson()), np.array([np.log(12)]))

    assert set(looks(True)) == {*SOME, OUTSIDE}
    assert len(set(looks(False).values())) == 1
