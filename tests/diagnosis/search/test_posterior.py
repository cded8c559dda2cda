"""Probabilities of sets of effects."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.experience.recogniser import OUTSIDE
from avobench.diagnosis.search.candidates import Weighed
from avobench.diagnosis.search.evidence import Evidence
from avobench.diagnosis.search.posterior import Posterior, Prior
from avobench.diagnosis.settings import SCORE
from avobench.effects.catalogue import catalogue
from avobench.tasks.poisson import Poisson

CATALOGUE = catalogue(Poisson())
EFFECTS = {effect.name: effect for effect in CATALOGUE}


def weighed(value, *names, shape=0, likeness=-2.0):
    effects = tuple(EFFECTS[name].shapes()[shape] for name in names)
    fit = SimpleNamespace(model=SimpleNamespace(effects=effects), num_events=1000, noiseless_q=10.0, dof=10)
    return Weighed(fit, Evidence(value, 0.0), likeness)


def posterior(models, outside=-2.0):
    """Of models that were weighed, and how much the events look like what is outside."""
    return Posterior.of(models, CATALOGUE, {OUTSIDE: outside})


def of(*models, outside=-2.0):
    return posterior([weighed(value, *names) for value, *names in models], outside)


SOME = st.lists(
    st.tuples(st.floats(-50, 0), st.lists(st.sampled_from(list(EFFECTS)), max_size=3, unique=True)), min_size=1
)


@given(SOME, st.floats(-3, 0))
def test_probabilities_are_those_of_exclusive_models(models, outside):
    found = of(*((value, *names) for value, names in models), outside=outside)
    assert sum(found.probability.values()) + found.others + found.outside == pytest.approx(1)
    for key, share in found.included.items():
        assert share == pytest.approx(sum(p for names, p in found.probability.items() if key in names))
    told = sum(found.probability[each] for each in found.credible)
    enough = SCORE.credible * sum(found.probability.values())
    assert told >= enough - 1e-9
    assert told - found.probability[found.credible[-1]] < enough + 1e-9


def test_families_share_the_prior_by_the_odds_of_their_classes():
    """Of one effect alone: all families, features and shapes together have its share, two classes twice that of one."""
    prior, families = Prior.of(CATALOGUE), Counter()
    for effect in CATALOGUE:
        families[effect.name] += np.exp(prior.log(frozenset({effect.key}))) * len(effect.shapes())
    assert families.total() == pytest.approx(SCORE.number[1])
    assert families["double_counting"] == pytest.approx(2 * families["dead_time"])  # of pulses, and of after-pulses
    assert families["mixture"] == pytest.approx(EFFECTS["mixture"].odds * families["dead_time"])


def test_a_fit_of_the_same_shape_counts_once():
    one = posterior([weighed(-1, "zero_inflation"), weighed(-2, "dead_time")])
    again = posterior([weighed(-1, "zero_inflation"), weighed(-1.5, "zero_inflation"), weighed(-2, "dead_time")])
    assert again.probability == pytest.approx(one.probability)


def odds(*models):
    """Of zero_inflation against dead_time."""
    found = posterior(models)
    return found.included[EFFECTS["zero_inflation"].key] / found.included[EFFECTS["dead_time"].key]


def test_what_makes_a_set_of_effects_more_probable():
    zeros, dead = weighed(-1, "zero_inflation"), weighed(-1, "dead_time")
    level = odds(zeros, dead)
    assert odds(zeros, dead, weighed(-1, "zero_inflation", shape=1)) > level  # another shape that explains it
    assert odds(weighed(0, "zero_inflation"), dead) > level
    assert odds(weighed(-1, "zero_inflation", likeness=-0.1), dead) > level
    assert odds(weighed(-1, "zero_inflation", shape=1), dead) < level  # a shape that is less plain


def test_a_deficit_counts_less_the_larger_it_is_since_no_shape_is_exact():
    small, large = (odds(weighed(0, "zero_inflation"), weighed(-d, "dead_time")) for d in (10, 1000))
    assert small < large < small**3


def test_a_deficit_of_the_simulator_as_it_is_counts_in_full():
    small, large = (of((-d,), (0, "dead_time")).probability[frozenset()] for d in (10, 100))
    assert large < small * np.exp(-30)


def test_a_model_that_explains_nothing_is_no_better_than_the_simulator_as_it_is():
    assert of((0,), (-5, "zero_inflation")).best is None


@given(SOME, st.floats(-3, 0), st.floats(-3, 0))
def test_what_is_outside_speaks_against_all_sets_alike_and_is_no_reason_for_another(models, one, other):
    sets = [(value, *names) for value, names in models]
    less, more = (of(*sets, outside=each) for each in sorted([one, other]))
    assert less.outside <= more.outside
    assert (less.best and less.best.effects, less.credible) == (more.best and more.best.effects, more.credible)


def test_the_more_rivals_there_are_the_less_probable_is_each():
    surely, level = of((-60,), (0, "dead_time")), of((-60,), (0, "dead_time"), (0, "pile_up"), (0, "truncation"))
    assert max(level.probability.values()) < 0.5 < max(surely.probability.values()) < 0.9
    assert level.others < surely.others


def fitted(strength, std, q):
    """A fit of zero_inflation with this strength and error."""
    effect = EFFECTS["zero_inflation"]
    model = SimpleNamespace(effects=(effect,), columns=lambda k: slice(1, 2))
    params, errors = np.array([0.0, strength]), np.array([0.1, std])
    return SimpleNamespace(model=model, params=params, std=errors, q=q, dof=10, noiseless_q=q)


@pytest.mark.parametrize(
    ("strength", "std", "q", "counts"),
    [
        (0.1, 0.01, 8, True),
        (0.0008, 0.005, 8, False),
        (0.0008, 0.005, 2, True),
        (0.1, 0.03, 11, True),
        (0.1, 0.03, 250, False),
    ],
)
def test_an_effect_counts_by_its_size_or_by_what_it_explains(strength, std, q, counts):
    """Beside a simulator with chi-squared 12. Where a model does not describe the events, its errors are larger."""
    alone = SimpleNamespace(model=SimpleNamespace(effects=()), noiseless_q=12)
    found = Posterior({frozenset(): 1.0}, {frozenset(): [Weighed(alone, Evidence(0, 0))]})
    assert (found.unsupported(fitted(strength, std, q), lambda fit: fit) is None) == counts


def test_what_a_model_has_goes_to_that_without_an_effect_that_does_not_count():
    pair, one, other = ("zero_inflation", "dead_time"), ("zero_inflation",), ("pile_up",)
    found = of((-90,), (0, *pair), (-2000, *one), (-1500, *other))
    assert len(found.best.effects) == 2
    alone = found.without(("dead_time", None))
    assert alone.best.effects == {("zero_inflation", None)}
    assert alone.total == pytest.approx(found.total)
    assert alone.without(("zero_inflation", None)).best is None  # the simulator as it is has most then


def test_two_effects_must_explain_more_than_one():
    assert len(of((-5, "dead_time"), (-5, "dead_time", "pile_up")).best.effects) == 1


def test_rivals_stand_in_the_place_of_an_effect():
    zeros, dead, noise = ("zero_inflation", "dead_time", "readout_noise")
    found = of((-5, zeros, noise), (-5.5, dead, noise), (-1e6, "pile_up", noise))
    first = [effect.name for effect in found.best.fit.model.effects].index(zeros)
    assert found.rivals(first) == [EFFECTS[dead].key]
    assert found.rivals(1 - first) == []
