"""What each constant of the score does."""

import numpy as np
import pytest

from avobench.diagnosis import diagnose
from avobench.diagnosis.search.posterior import OUTSIDE
from avobench.effects.catalogue import catalogue
from avobench.studies.weighing import AS_IT_IS, searched, weighed_again
from avobench.tasks.poisson import Poisson

TASK = Poisson()
EFFECTS = [effect for effect in catalogue(TASK) if effect.name in ("zero_inflation", "dead_time")]


def counts(off):
    """A rate of 20, and a share of the events that read nothing."""
    rng = np.random.default_rng(3)
    x = TASK.simulate(np.full((3000, 1), np.log(20.0)), rng)
    x[rng.random(len(x)) < off] = 0
    return x


def test_what_is_weighed_as_it_is_is_what_a_diagnosis_says():
    x = counts(0.02)
    told = diagnose(TASK, x, seed=5, effects=EFFECTS).diagnosis
    found, target = searched(TASK, x, EFFECTS, 5)
    again = dict(weighed_again(found, target, [effect.adapted(x) for effect in EFFECTS]))
    assert again[AS_IT_IS].probability == pytest.approx(found.probability)
    assert [each.probability for each in told.probabilities] == pytest.approx(list(found.included.values()))
    assert told.outside == pytest.approx(found.outside)
    assert again["nothing is outside"].probability[OUTSIDE] < 1e-6
    one, other = [names for names in found.probability if names][:2]
    names = ("one temperature for all", "temperature 1 for all")
    warm, cold = (np.log(again[name].probability[one] / again[name].probability[other]) for name in names)
    assert abs(cold) > abs(warm)


def test_where_nothing_disagrees_there_is_nothing_to_weigh():
    assert searched(TASK, counts(0.0), EFFECTS, 5) is None
