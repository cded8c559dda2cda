from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.answer.quoted import Move, ambiguity, covering, identified, theta_values
from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.fit import Fit, fit_at
from avobench.diagnosis.fit.surrogate import Design, surrogate
from avobench.diagnosis.gates.classifier import features_of
from avobench.diagnosis.search.features import clears_feature, excess_by_feature, open_features
from avobench.diagnosis.search.joint import continued, joint
from avobench.diagnosis.search.ranking import Ranked, ranking
from avobench.diagnosis.search.starts import Sample, hidden, screen
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import Target, target_of
from avobench.effects import Effect, Parameter
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


class Thinned(Effect):
    """Each of n counts survives with probability 1 / (1 + tau n): a dead time in rough, with a second solution."""

    name = "dead_time"
    parameters = (Parameter("tau", 0, 1, 0, "of the window, a count"),)
    sentence, source = "High counts are reduced most.", "test"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        x[:, 0] = rng.binomial(x[:, 0], 1 / (1 + phi[:, 0] * x[:, 0]))
        return x


DEAD = Thinned()
WEAK, STRONG = [0.39, 0.062], [2.38, 0.675]
"""Log rate and dead time, which give nearly the same counts: a counter near its highest rate."""


def fitted(model: Model, params: list[float], target: Target) -> Fit:
    unit = model.to_cube(np.array(params))
    half = np.minimum(model.reach(unit), 0.01)
    return refine(model, target, unit, half, np.random.default_rng(2), num_events=30_000)


@pytest.fixture(scope="module")
def counter() -> SimpleNamespace:
    rng = np.random.default_rng(1)
    model = Model(Poisson(), (DEAD,))
    x = model.simulate(np.tile(STRONG, (8000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)
    return SimpleNamespace(x=x, target=target, weak=fitted(model, WEAK, target), strong=fitted(model, STRONG, target))


def test_theta_s_error_covers_another_solution_that_the_data_allow(counter):
    weak, strong = counter.weak, counter.strong
    assert strong.params[0] - weak.params[0] > 1.5
    chosen = Ranked(DEAD, weak, 0.0, others=(strong,))
    moves = ambiguity(weak, chosen, [], counter.target, np.random.default_rng(0), 300_000)
    (before,), (after,) = theta_values(weak).values(), theta_values(weak, moves).values()
    assert before.value == after.value
    assert abs(STRONG[0] - before.value) > 2 * before.std
    assert abs(STRONG[0] - after.value) < 2 * after.std
    (known,) = identified(weak, moves)
    width = weak.model.high[0] - weak.model.low[0]
    assert known.std * width == pytest.approx(after.std)
    assert known.coefficients["log_rate"] == pytest.approx(1 / width)


def test_a_shape_that_the_data_exclude_does_not_widen_the_error(counter):
    model, target = counter.strong.model, counter.target
    unit = model.to_cube(np.array([1.0, 0.9]))
    s = surrogate(model, target, Design.box(unit, np.full(2, 0.01)), 20_000, np.random.default_rng(0))
    excluded = fit_at(model, s, target, unit)
    assert excluded.gap > counter.strong.noiseless_q + 100
    chosen = Ranked(DEAD, counter.strong, 0.0, others=(excluded,))
    assert ambiguity(counter.strong, chosen, [], target, np.random.default_rng(0), 20_000) == []


def test_what_theta_hides_is_also_begun_where_it_is_strong(counter):
    rng, effort = np.random.default_rng(3), Effort()
    null = fitted(Model(Poisson()), [0.24], counter.target)
    sample = Sample(null, counter.target, effort.sample, rng)
    starts = hidden(sample, screen(sample, DEAD, counter.x, rng, effort)[0], rng, effort)
    known = null.known(counter.target, int(effort.known * counter.target.num_events), rng)
    fits = [joint(start, known, counter.target, rng, effort.fit // 2) for start in starts]
    fits = [continued(fit, known, counter.target, rng, effort.fit, effort) for fit in fits]
    strong = min(fits, key=lambda fit: abs(fit.params[1] - STRONG[1]))
    np.testing.assert_allclose(strong.params, STRONG, atol=0.5)  # a valley: a longer dead time at a higher rate
    assert strong.noiseless_q < strong.dof + 3 * np.sqrt(2 * strong.dof)


@given(st.floats(0.01, 2), st.floats(-3, 3), st.floats(0, 3.99), st.floats(0, 0.25))
def test_errors_only_grow_and_reach_every_allowed_value(std, shift, worse, own):
    move = Move(np.array([shift]), worse, np.array([[own**2]]))
    (covered,) = covering(np.array([std]), np.eye(1), [move])
    assert covered >= std
    assert 2 * covered >= abs(shift)
    assert 2 * covered <= max(2 * std, abs(shift) + 2 * own) + 1e-9


def test_an_effect_on_one_feature_clears_that_feature_whatever_is_wrong_with_another():
    task, rng = Carl(), np.random.default_rng(0)
    theta = np.tile(task.prior.sample(1, rng), (4000, 1))
    x, simulated = task.simulate(theta, rng), task.simulate(theta, rng)
    x[:, 3] += 0.3 * x[:, 3].std()
    x[:, 0] *= 2
    target = target_of(x, bins_of(x, simulated), x)

    def fit(events, *features):
        effects = tuple(SimpleNamespace(feature=feature) for feature in features)
        return SimpleNamespace(
            predicted=target.summary.mean(events)[0], noise=1.0, model=SimpleNamespace(effects=effects)
        )

    mended = simulated.copy()
    mended[:, 3] += 0.3 * x[:, 3].std()
    before, found = fit(simulated), excess_by_feature(fit(simulated), target)
    assert sorted(found, key=found.get)[-2:] == [3, 0]
    assert clears_feature(fit(mended, 3), before, target)
    assert not clears_feature(fit(mended, 0), before, target)
    assert not clears_feature(fit(mended, 1), before, target)  # shows nothing that could be cleared
    assert not clears_feature(fit(mended, "all"), before, target)
    assert not clears_feature(fit(mended, "all", 3), fit(simulated, "all"), target)  # may be left by the effect on all
    assert clears_feature(fit(mended, 0, 3), fit(simulated, 0), target)
    assert list(open_features(before, target)) == [0, 3]
    assert list(open_features(fit(simulated, 0), target)) == [3]


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


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_classifier_does_not_see_how_a_computer_rounds_whatever_the_unit(unit):
    rng = np.random.default_rng(0)
    x = np.column_stack([rng.integers(0, 9, 2000) * 0.708, rng.standard_normal(2000)]) * unit
    seen = features_of(target_of(x, bins_of(x, x), x))
    np.testing.assert_array_equal(seen(x)[:, 0], seen(x * (1 + 1e-9))[:, 0])
    np.testing.assert_allclose(seen(x), x, atol=1e-5 * unit)
    counts = rng.poisson(4, (2000, 1))
    assert features_of(target_of(counts, bins_of(counts, counts), counts))(counts) is counts
