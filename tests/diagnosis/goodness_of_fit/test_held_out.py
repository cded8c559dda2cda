from types import SimpleNamespace

import numpy as np
import pytest
from measurements import LIGHT, entry, measured, with_effect
from scipy.stats import binom, chi2, ncx2

from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import model_metric, summary_gate
from avobench.diagnosis.goodness_of_fit.held_out import HeldOut, interval, null_moments
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.model import Model
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson


def correlated(d):
    """Gaussian features that go together, the last an exponential."""

    def simulate(theta, rng):
        common = rng.standard_normal((len(theta), 1))
        x = theta + 0.6 * common + 0.8 * rng.standard_normal((len(theta), d))
        x[:, -1] = rng.exponential(1 + (common[:, 0] > 1))
        return x

    return task(simulate, prior={"mean": (-1, 1)}, name="correlated")


def held_out(target, x):
    return HeldOut(target, target.summary.mean(x)[0], len(x))


def covers(expected, q, mean, variance):
    """In how many cases, and between how many that is to be: outside once in a thousand times, to either side."""
    ends = np.array([interval(value, mean, variance) for value in q])
    return binom.ppf([0.001, 0.999], len(q), 0.95), ((ends[:, 0] <= expected) & (expected <= ends[:, 1])).sum()


@pytest.mark.parametrize(("d", "sets"), [(1, 300), (5, 200), (10, 60)])
def test_the_interval_of_a_true_model_covers_one_with_any_number_of_features(d, sets):
    """Sets of 750 events at a theta that is known, in the metric that other events of the model make."""
    rng = np.random.default_rng(d)
    model = Model(correlated(d))

    def events(n):
        return model.simulate(np.zeros((n, 1)), rng)

    target = target_of(events(2250), bins_of(events(2250), events(2250)), events(2250))
    fit = SimpleNamespace(model=model, params=[0.0])
    metric, *_ = model_metric(fit, target, target.mean, 750, rng, 30_000)
    mean, variance = null_moments(metric, events(30_000))
    sets_of = target.summary.mean(events(750 * sets), sets)
    q = (metric.whiten(sets_of - sets_of.mean(axis=0)) ** 2).sum(axis=1) / (1 - 1 / sets)
    (least, most), covered = covers(mean, q, mean, variance)
    assert least <= covered <= most


@pytest.mark.parametrize("excess", [0.0, 20.0, 500.0])
def test_the_interval_covers_a_gap_that_is_there(excess):
    q = ncx2.rvs(30, excess, size=400, random_state=1) if excess else chi2.rvs(30, size=400, random_state=1)
    (least, most), covered = covers(30 + excess, q, 30, 60)
    assert least <= covered <= most


def test_the_gap_of_a_true_model_is_one_on_average():
    """The mean of 25: chi-squared over some ten degrees of freedom scatters by 0.45, the mean by 0.09."""
    gaps = []
    for k in range(25):
        x, rng = measured(Poisson(), [1.5], 4000, k)
        fit, target = fit_null(Model(Poisson()), x[:3000], rng, LIGHT, None)
        own = summary_gate(fit, target, rng, LIGHT)[1]
        gaps.append(held_out(target, x[3000:]).gap(own, rng, LIGHT.covariance))
    assert np.mean([gap.value for gap in gaps]) == pytest.approx(1, abs=0.3)
    assert all(gap.low <= gap.value <= gap.high for gap in gaps)


def test_an_effect_that_is_there_shrinks_the_gap_and_its_absence_does_not():
    x = with_effect(Poisson(), "zero_inflation", [1.5], [0.1], 8000)
    rng = np.random.default_rng(0)
    null, target = fit_null(Model(Poisson()), x[:6000], rng, LIGHT, None)
    aside = held_out(target, x[6000:])
    model = Model(Poisson(), (entry(Poisson(), "zero_inflation"),))
    fit = refine(model, target, model.to_cube(np.array([1.5, 0.1])), 0.01, rng, num_events=30_000)
    gap_after, gap_before = (aside.gap(each, rng, LIGHT.covariance) for each in (fit, null))
    assert gap_after.low <= 1 < 2 < gap_before.low
    assert aside.shrank(fit, null)
    assert not aside.shrank(null, fit)
    assert not aside.shrank(fit, fit)
