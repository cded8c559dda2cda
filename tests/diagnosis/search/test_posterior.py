"""Probabilities of sets of effects."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.search.candidates import Weighed
from avobench.diagnosis.search.evidence import Evidence
from avobench.diagnosis.search.posterior import Posterior, Prior, pooled
from avobench.diagnosis.settings import SCORE
from avobench.effects.catalogue import catalogue
from avobench.tasks.poisson import Poisson

CATALOGUE = catalogue(Poisson())
EFFECTS = {effect.name: effect for effect in CATALOGUE}


def weighed(value, *names, shape=0, error=0.0, excess=0.0):
    effects = tuple(EFFECTS[name].shapes()[shape] for name in names)
    return Weighed(SimpleNamespace(model=SimpleNamespace(effects=effects)), Evidence(value, error, excess))


SOME = st.lists(
    st.tuples(st.floats(-50, 0), st.lists(st.sampled_from(list(EFFECTS)), max_size=3, unique=True)), min_size=1
)


def of(*models):
    return Posterior.of([weighed(value, *names) for value, *names in models], CATALOGUE)


@given(SOME, st.floats(0, 9))
def test_probabilities_are_those_of_exclusive_models(models, beyond):
    found = replace(of(*((value, *names) for value, names in models)), beyond=beyond)
    assert sum(found.probability.values()) + found.others + found.outside == pytest.approx(1)
    for key, share in found.included.items():
        assert share == pytest.approx(sum(p for names, p in found.probability.items() if key in names))
    told, enough = (
        sum(found.probability[each] for each in found.credible),
        SCORE.credible * sum(found.probability.values()),
    )
    assert told >= enough - 1e-9
    assert told - found.probability[found.credible[-1]] < enough + 1e-9


def test_families_share_the_prior_by_the_odds_of_their_classes():
    """Of one effect alone: all families, features and shapes together have its share, two classes twice that of one."""
    prior, total = Prior.of(CATALOGUE), 0.0
    families = {}
    for effect in CATALOGUE:
        each = np.exp(prior.log(frozenset({effect.key}))) * len(effect.shapes())
        families[effect.name] = families.get(effect.name, 0.0) + each
        total += each
    assert total == pytest.approx(SCORE.number[1])
    assert families["double_counting"] == pytest.approx(2 * families["dead_time"])  # of pulses, and of after-pulses
    assert families["mixture"] == pytest.approx(EFFECTS["mixture"].odds * families["dead_time"])


def test_a_fit_of_the_same_shape_counts_once():
    one = Posterior.of([weighed(-1, "zero_inflation"), weighed(-2, "dead_time")], CATALOGUE)
    again = [weighed(-1, "zero_inflation"), weighed(-1.5, "zero_inflation"), weighed(-2, "dead_time")]
    assert Posterior.of(again, CATALOGUE).probability == pytest.approx(one.probability)


def test_a_shape_that_leaves_as_much_makes_its_family_more_probable():
    alone = [weighed(-1, "zero_inflation"), weighed(-1, "dead_time")]
    both = [*alone, weighed(-1, "zero_inflation", shape=1)]
    key = EFFECTS["zero_inflation"].key
    assert Posterior.of(both, CATALOGUE).included[key] > Posterior.of(alone, CATALOGUE).included[key]


def odds(found, one, other):
    return found.included[EFFECTS[one].key] / found.included[EFFECTS[other].key]


def told(excess, *models):
    return Posterior.of([weighed(-excess, excess=excess), *models], CATALOGUE)


def test_the_more_a_model_explains_the_less_what_it_leaves_tells_of_two_names():
    models = [weighed(0, "zero_inflation"), weighed(-12, "dead_time", excess=12)]
    weak, strong = (odds(told(excess, *models), "zero_inflation", "dead_time") for excess in (112, 3012))
    level = odds(told(112, weighed(0, "zero_inflation"), weighed(0, "dead_time")), "zero_inflation", "dead_time")
    assert np.exp(12) * level > weak > strong > level


def test_what_is_free_is_priced_alike_however_much_there_is_to_explain():
    models = [weighed(0, "zero_inflation"), weighed(-12, "dead_time")]
    weak, strong = (odds(told(excess, *models), "zero_inflation", "dead_time") for excess in (30, 3000))
    assert weak == pytest.approx(strong)


def test_a_model_that_explains_nothing_is_no_better_than_the_simulator_as_it_is():
    assert told(500, weighed(-500, "zero_inflation", excess=500)).best is None


@given(SOME, st.floats(0, 9), st.floats(0, 9))
def test_what_is_outside_speaks_against_all_sets_alike_and_is_no_reason_for_another(models, one, other):
    found = of(*((value, *names) for value, names in models))
    less, more = (replace(found, beyond=each) for each in sorted([one, other]))
    assert less.outside <= more.outside
    assert (less.best, less.credible) == (more.best, more.credible)


def test_what_leaves_nothing_and_has_no_rival_is_probable_and_what_has_rivals_less():
    surely, level = of((-60,), (0, "dead_time")), of((-60,), (0, "dead_time"), (0, "pile_up"), (0, "truncation"))
    assert max(level.probability.values()) < 0.5 < max(surely.probability.values()) < 0.9
    assert level.others > surely.others


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
    found = of((-90,), (0, *pair), (-26, *one), (-25, *other))
    assert len(found.best.effects) == 2
    alone = found.without(("dead_time", None))
    assert alone.best.effects == {("zero_inflation", None)}
    assert sum(alone.shares.values()) == pytest.approx(1)
    assert alone.shares[alone.best.effects] > 1 - found.shares[frozenset({("pile_up", None)})] - 1e-9
    assert alone.without(("zero_inflation", None)).best is None  # the simulator as it is has most then


def test_two_effects_must_explain_more_than_one():
    found = of((-5, "dead_time"), (-5, "dead_time", "pile_up"))
    assert len(found.best.effects) == 1


def test_rivals_stand_in_the_place_of_an_effect():
    zeros, dead, noise = ("zero_inflation", "dead_time", "readout_noise")
    found = of((-5, zeros, noise), (-5.5, dead, noise), (-40, "pile_up", noise))
    first = [effect.name for effect in found.best.fit.model.effects].index(zeros)
    assert found.rivals(first) == [EFFECTS[dead].key]
    assert found.rivals(1 - first) == []


OPINIONS = st.dictionaries(
    st.frozensets(st.tuples(st.sampled_from(list(EFFECTS)), st.none()), min_size=1, max_size=2),
    st.tuples(st.floats(-50, 0), st.floats(-5, -0.01)),
    min_size=1,
)


@given(OPINIONS)
def test_what_events_look_like_moves_probability_among_sets_alone(opinions):
    fitted = {names: fit for names, (fit, _) in opinions.items()}
    both = pooled(opinions)
    assert np.logaddexp.reduce(list(both.values())) == pytest.approx(np.logaddexp.reduce(list(fitted.values())))
    assert pooled({names: (fit, 0.0) for names, fit in fitted.items()}) == fitted  # without experience
    alike = pooled({names: (fit, -1.0) for names, fit in fitted.items()})
    for one in alike:  # the order is that of the fits
        for other in alike:
            assert (alike[one] - alike[other]) * (fitted[one] - fitted[other]) >= 0
