from types import SimpleNamespace

import numpy as np

from avobench.diagnosis.search.pairs import best_pair
from avobench.diagnosis.search.ranking import Ranked
from avobench.diagnosis.search.tested import Step
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson


def test_a_pair_is_accepted_only_if_it_leaves_next_to_nothing():
    """Fits stand for themselves by what they leave: two firsts, and what a second one leaves beside each."""
    effects = {e.name: e for e in catalogue(Poisson())}

    def leaving(left, *names):
        model = Model(Poisson(), tuple(effects[name] for name in names))
        point = np.full(model.dim, 0.5)
        return SimpleNamespace(
            model=model, noiseless_q=left, noiseless_q_error=0.0, dof=10, point=point, params=model.from_cube(point)
        )

    def ranked(fit):
        return Ranked(fit.model.effects[-1], fit, 0.0)

    null = Step(leaving(1010.0), None, {}, [ranked(leaving(610.0, "dead_time")), ranked(leaving(710.0, "pile_up"))])
    beside = {name: leaving(left, name, "quantisation") for name, left in (("dead_time", 200.0), ("pile_up", 40.0))}

    def search(fit, leaves, others):
        return [ranked(beside[fit.model.effects[-1].name])], fit

    steps, known = best_pair([null], search, lambda new, old: False)
    assert steps[-1].ranks[0].fit is beside["pile_up"]
    assert known.model.effects == (effects["pile_up"],)
    assert steps[0].ties == []
    assert best_pair([null], search, lambda new, old: True) is None  # it grew on the events kept aside
    beside["pile_up"] = leaving(150.0, "pile_up", "quantisation")
    assert best_pair([null], search, lambda new, old: False) is None
    beside |= {name: leaving(left, name, "quantisation") for name, left in (("dead_time", 42.0), ("pile_up", 40.0))}
    steps, _ = best_pair([null], search, lambda new, old: False)
    assert [tie.effect.name for tie in steps[0].ties] == ["dead_time"]
    closed = Step(leaving(1010.0), None, {}, [ranked(leaving(8.0, "dead_time"))])  # beside it nothing is left to close
    assert best_pair([closed], search, lambda new, old: False) is None
    # What the first was tied with may be a better first, if with it much less is left than the first left.
    first = Step(leaving(610.0, "dead_time"), None, {}, [])
    steps, _ = best_pair([null, first], search, lambda new, old: False)
    assert [effect.name for effect in steps[-1].added.fit.model.effects] == ["pile_up", "quantisation"]
    assert steps[0].added.effect.name == "pile_up"
    first = Step(leaving(100.0, "dead_time"), None, {}, [])
    assert best_pair([null, first], search, lambda new, old: False) is None
