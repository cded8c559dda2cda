"""Tests of a fitted model: the summary, single cells, the classifier, and its weights."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from measurements import LIGHT, entry, measured, with_effect
from scipy.stats import binom, kstest, spearmanr
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.metrics import roc_auc_score

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import (
    Score,
    cell_gate,
    classifier_gate,
    correction,
    dependence_gate,
    distance_p,
    features_of,
    summary_gate,
    trained,
)
from avobench.diagnosis.goodness_of_fit.regions import disagreeing, regions
from avobench.diagnosis.run import diagnose
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search.search import Search, named
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import Target, target_of
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks import Box, Task
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson
from avobench.tasks.sample import bank
from avobench.tasks.weinberg import Weinberg


def p_values(count, theta=1.0, share=0.0):
    """Of the gate, for so many data sets of 3 000 counts, of which a share was not recorded but counted as zero."""
    found = []
    for k in range(count):
        x, rng = measured(Poisson(), [theta], 3000, 100 + k)
        x[rng.random(len(x)) < share] = 0
        found.append(summary_gate(*fit_null(Model(Poisson()), x, rng, LIGHT, None), rng, LIGHT)[0].p_value)
    return np.array(found)


def require_uniform(p):
    """Of 40: those of a right gate fail once in a thousand times, by either of the two."""
    assert kstest(p, "uniform").pvalue > 5e-4
    assert (np.array(p) < 0.05).sum() <= binom.isf(5e-4, len(p), 0.05)


@pytest.mark.parametrize("theta", [0.0, 2.5])
def test_p_values_of_a_true_model_are_uniform(theta):
    require_uniform(p_values(40, theta))


def test_a_distance_by_a_covariance_of_few_events_is_no_disagreement():
    """Whitened by a covariance that is itself uncertain: 20 numbers of 100 events, and 1 000 draws."""
    rng, p = np.random.default_rng(0), []
    for _ in range(1000):
        distance = rng.standard_normal(20)
        cov = np.cov(rng.standard_normal((100, 20)).T)
        p.append(distance_p(distance @ np.linalg.solve(cov, distance), 20, 99))
    assert kstest(p, "uniform").pvalue > 1e-3


def many(d):
    """A task of so many features, each of which theta moves."""
    slopes = np.linspace(0.5, 1.5, d)
    return task(lambda theta, rng: theta * slopes + rng.normal(size=(len(theta), d)), prior={"s": (-1, 1)}, name="many")


@pytest.mark.parametrize("seed", range(2))
def test_many_features_of_few_events_raise_no_alarm(seed):
    wide = many(30)
    x = wide.simulate(np.full((1000, 1), 0.3), np.random.default_rng(seed))
    found = diagnose(wide, x, seed=seed, effects=[]).diagnosis
    assert min(gate.corrected for gate in found.gates.values()) > 1e-3
    assert found.theta_before["s"].value == pytest.approx(0.3, abs=4 * found.theta_before["s"].std)


def test_a_small_sample_of_right_events_raises_no_alarm():
    """Of 10: ten features by a covariance of the same few events as the mean failed in seven."""
    alarms = 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        sample, x = bank(rng.normal(size=(640, 10))), rng.normal(size=(1000, 10))
        alarms += diagnose(sample, x, seed=seed, effects=[]).diagnosis.gates["summary"].p_value < 0.05
    assert alarms <= binom.isf(1e-3, 10, 0.05)


def test_the_features_that_disagree_are_those_that_are_searched():
    wide = many(40)
    x = wide.simulate(np.full((4000, 1), 0.3), rng := np.random.default_rng(0))
    x[:400, 7] = rng.normal(1.5, 0.1, 400)
    target = target_of(x, bins_of(x, x), x)
    fit = refine(Model(wide), target, np.array([0.65]), 0.01, rng, num_events=10_000)
    found = disagreeing(fit, target, x)
    assert 7 in found
    assert len(found) < 15
    search = Search(target, x, [], 1, rng, Effort(), 1, features=found)
    depending = [effect for effect in catalogue(wide) if effect.name == "conditional_response"]
    tried = [effect for effect in depending if search.looks_at({effect.feature})]
    assert {effect.feature for effect in tried} == set(found)
    shapes = [shape for effect in tried for shape in effect.shapes() if search.looks_at(named(shape))]
    assert {j for shape in shapes for j in named(shape)} == set(found)


def test_the_gate_sees_what_is_plainly_missing():
    """Zeros in excess of 3 % of 3 000 events, of which theta can take up a part: some seven standard errors."""
    assert (p_values(10, 1.5, 0.03) < 0.01).all()


def coins(share, seed=0):
    """Coins of which theta is the share of heads, 0.4 to 0.6: it takes up the one degree of freedom. And a fit."""
    coin = task(lambda theta, rng: rng.binomial(1, theta), prior={"p": (0.4, 0.6)}, name="coin")
    rng = np.random.default_rng(seed)
    x = rng.binomial(1, share, (3000, 1))
    fit, target = fit_null(Model(coin), x, rng, LIGHT, None)
    return x, fit, target, rng


def test_a_distance_that_theta_cannot_bridge_is_seen_also_where_no_degree_of_freedom_is_left():
    _, fit, target, rng = coins(0.1)
    assert fit.p_value < 1e-100
    gate = summary_gate(fit, target, rng, LIGHT)[0]
    assert gate.statistic > 500
    assert gate.p_value < 1e-100


def test_where_theta_takes_up_all_there_is_nothing_disagrees_and_nowhere():
    x, fit, target, rng = coins(0.5)
    gate, own, _ = summary_gate(fit, target, rng, LIGHT)
    assert own.dof == 0
    assert gate.p_value > 1e-3
    assert regions(own, target, target.summary.view(x).spans, rng, 0.05, ()) == []


def test_where_nothing_is_expected_and_nothing_measured_a_fit_makes_nothing():
    """Without counts below 6, the model's own covariance knows none either, and would let the threshold fall."""
    x = np.random.default_rng(41).poisson(9.0, 40_000)
    x = x[x > 5][:5000, None]
    model = Model(Poisson(), (entry(Poisson(), "threshold_loss").adapted(x),))
    at = np.array([np.log(9.0), 1.0, 6.0])
    rng = np.random.default_rng(0)
    simulated = Poisson().simulate(np.tile(at[:1], (20_000, 1)), rng)
    target = target_of(x, bins_of(x, simulated), simulated)
    for seed in range(4):
        fit = refine(model, target, model.to_cube(at), 0.005, np.random.default_rng(seed), num_events=20_000)
        gate, own, _ = summary_gate(fit, target, np.random.default_rng(seed), LIGHT)
        assert own.params[2] > 5.9
        assert gate.dof < target.rank - 3  # what cannot be otherwise is no degree of freedom
        assert gate.p_value > 1e-3


@pytest.mark.parametrize("events", [200, 3000])
def test_of_images_one_cell_that_fires_where_none_should_is_seen_and_few_images_suffice(events):
    def simulate(params, rng):
        return rng.random((len(params), 64)) < np.where(np.arange(64) < 8, 0.0, 0.002)

    still, rng = SimpleNamespace(model=SimpleNamespace(simulate=simulate), params=np.zeros(1)), np.random.default_rng(0)
    x = simulate(np.zeros((events, 1)), rng)
    assert cell_gate(still, x, rng, LIGHT).p_value > 0.01
    x[:, 3] = rng.random(events) < 0.1
    gate = cell_gate(still, x, rng, LIGHT)
    assert gate.p_value < 1e-9
    assert np.isfinite(gate.statistic)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_classifier_does_not_see_how_a_computer_rounds_whatever_the_unit(unit):
    rng = np.random.default_rng(0)
    x = np.column_stack([rng.integers(0, 9, 2000) * 0.708, rng.standard_normal(2000)]) * unit
    seen = features_of(target_of(x, bins_of(x, x), x))
    np.testing.assert_array_equal(seen(x)[:, 0], seen(x * (1 + 1e-9))[:, 0])
    np.testing.assert_allclose(seen(x), x, atol=1e-5 * unit)
    counts = rng.poisson(4, (2000, 1))
    assert features_of(target_of(counts, bins_of(counts, counts), counts))(counts) is counts


def independent(n, d, rng):
    return rng.standard_normal((n, d))


def correlated(n, d, rng):
    x = rng.standard_normal((n, d))
    x[:, 1] = 0.2 * x[:, 0] + np.sqrt(0.96) * x[:, 1]
    return x


def common_gain(n, d, rng):
    return independent(n, d, rng) * (1 + 0.15 * independent(n, 1, rng))


def common_offset(n, d, rng):
    return independent(n, d, rng) + 0.15 * independent(n, 1, rng)


def untouched(make, n, d, seed):
    """A fit of independent normals, in which nothing is free, to events that are made in another way."""
    rng = np.random.default_rng(seed)
    x, simulated = make(n, d, rng), independent(20 * n, d, rng)
    summary = bins_of(x, simulated[:n])
    target = Target.of(summary, summary.mean(x)[0], n, summary.covariance(simulated))
    residual = target.whiten(target.mean - summary.mean(simulated)[0])
    return SimpleNamespace(residual=residual, noise=1 / 20, projector=lambda: np.eye(len(residual))), target


@pytest.mark.parametrize(
    ("make", "d", "features"),
    [(correlated, 2, "x1 and x2"), (correlated, 15, "x1 and x2"), (common_gain, 15, "all"), (common_offset, 15, "all")],
)
def test_a_dependence_is_seen_where_every_feature_alone_is_right_and_told_where_it_is(make, d, features):
    fit, target = untouched(make, 1500, d, 0)
    assert dependence_gate(fit, target).p_value < 1e-5
    told = regions(fit, target, [], np.random.default_rng(0), 0.01, tuple(f"x{j + 1}" for j in range(d)))
    assert (told[0].feature, told[0].kind) == (features, "dependence")


@pytest.mark.parametrize("d", [2, 4])
def test_of_independent_features_a_dependence_is_seen_as_seldom_as_alpha_says(d):
    """In 60 sets each. A right gate fails once in two thousand times."""
    p = np.array([dependence_gate(*untouched(independent, 500, d, 10 + k)).p_value for k in range(60)])
    assert (p < 0.05).sum() <= binom.isf(5e-4, len(p), 0.05)


class Signs(Task):
    """Three Gaussians of width theta. In the measured events the product of their signs is a little more often +."""

    name, parameter_names, parameter_units, source = "signs", ("width",), ("1",), "test"
    prior, support = Box((0.5,), (1.5,)), Box((0.2,), (3.0,))
    num_features = 3
    summary = floor = None

    def simulate(self, theta, rng):
        return theta * np.abs(rng.standard_normal((len(theta), 3))) * rng.choice([-1, 1], (len(theta), 3))


def both_gates(task, x, rng):
    """The p-values of both gates."""
    fit, target = fit_null(Model(task), x, rng, LIGHT, None)
    gate, own, own_target = summary_gate(fit, target, rng, LIGHT)
    return gate.p_value, classifier_gate(own, own_target, x, rng, Effort()).p_value


def test_p_values_of_the_classifier_are_uniform_for_a_true_model():
    require_uniform([both_gates(Poisson(), *measured(Poisson(), [1.5], 1000, k))[1] for k in range(40)])


def test_it_sees_what_lives_in_three_features_together_where_no_bins_do():
    x, rng = measured(Signs(), [1.0], 12_000, 0)
    x[(rng.random(len(x)) < 0.3) & (x.prod(axis=1) < 0), 0] *= -1
    summary, classifier = both_gates(Signs(), x, rng)
    assert summary > 1e-3
    assert classifier < 1e-6


def area(measured, simulated, weights):
    """Under the ROC curve of a new classifier, on the half of the events that it did not learn from."""
    x, labels = np.concatenate([measured, simulated]), np.repeat([1, 0], [len(measured), len(simulated)])
    w = np.concatenate([np.ones(len(measured)), weights])
    learn = np.random.default_rng(0).random(len(x)) < 0.5
    trees = HistGradientBoostingClassifier(max_iter=30, random_state=0).fit(x[learn], labels[learn], w[learn])
    return roc_auc_score(labels[~learn], trees.decision_function(x[~learn]), sample_weight=w[~learn])


def test_weights_make_simulated_events_look_like_measured_ones():
    """To a classifier that knows nothing of them, on other measured events."""
    x = with_effect(Weinberg(), "dead_region", [45.5, 1.0], [0.8, 0.3, 0.3], 40_000)
    rng = np.random.default_rng(0)
    fit, target = fit_null(Model(Weinberg()), x[:20_000], rng, LIGHT, None)
    found = correction(fit, target, x[:20_000], rng)
    assert found.x.shape == (20_000, 1)
    assert found.weights.mean() == pytest.approx(1)
    assert (found.weights > 0).all()
    other = x[20_000:]
    assert area(other, found.x, np.ones(20_000)) > 0.53
    assert area(other, found.x, found.weights) == pytest.approx(0.5, abs=0.015)  # three standard errors of an area


def test_the_draft_lottery_of_1970_contradicts_a_fair_one():
    """The table of its ranks is held against the published correlation."""
    table = Path(__file__).with_name("lottery.txt").read_text().splitlines()[2:]
    days, ranks = np.arange(1, 367), np.array(" ".join(table).split(), int)
    assert sorted(ranks) == days.tolist()
    assert spearmanr(days, ranks).statistic == pytest.approx(-0.226, abs=5e-4)  # as published
    fair = task(lambda theta, rng: rng.integers(1, 367, (len(theta), 2)), prior={"none": (0, 1)}, name="fair")
    found = diagnose(fair, np.column_stack([days, ranks]), effects=[], num_simulations=100_000).diagnosis
    assert found.verdict == Verdict.UNEXPLAINED
    assert found.gates["dependence"].corrected == pytest.approx(found.p_value_before)


def test_a_score_of_no_events_is_empty():
    """As where an effect changes none of the events that were simulated."""
    score = Score(trained(np.zeros((9, 2)), np.ones((9, 2)), 0), lambda x: x)
    assert score.moments(np.empty((0, 2)), np.empty((0, 3))).tolist() == [[0], [0], [0]]
