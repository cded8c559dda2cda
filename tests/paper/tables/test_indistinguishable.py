"""Exact distributions of counts under effects, and what they leave to tell."""

import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.tasks.poisson import Poisson
from paper.tables.indistinguishable import COUNTED, COUNTS, RATE, SEEN, SETTINGS, fitted, missed, seen


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, (shapes, *_) in SETTINGS.items() for name in shapes])
def test_each_is_a_distribution_that_the_simulator_misses_by_as_much(kind, name):
    shapes, simulator, _, (low, high) = SETTINGS[kind]
    pmf = seen(shapes[name], kind)
    assert pmf.sum() == pytest.approx(1, abs=1e-6)
    assert (pmf >= 0).all()
    least = min(missed(pmf, simulator(parameter)) for parameter in np.linspace(low, high, 4000))
    assert SEEN - 0.01 < least < SEEN + 0.5


@pytest.mark.parametrize(
    ("name", "strength", "variance"),
    [
        ("gamma rates", 0.01, RATE + 0.01 * RATE**2),
        ("pairs", 0.1, RATE * 1.3),  # jumps of one and of two
        ("after-pulses", 0.1, RATE * (1.1**2 + 0.1)),  # of 1 + a Poisson number
        ("two events in one", 0.1, 1.1 * RATE + 0.09 * RATE**2),
    ],
)
def test_variances_are_those_that_the_effect_gives(name, strength, variance):
    pmf = COUNTED[name].pmf(RATE, strength)
    assert pmf @ COUNTS**2 - (pmf @ COUNTS) ** 2 == pytest.approx(variance, rel=1e-6)


def test_a_dead_time_is_that_of_the_catalogue():
    effect = next(each for each in catalogue(Poisson()) if each.name == "dead_time")
    n, tau = 400_000, 0.01
    x = effect.apply(Poisson().simulate, np.full((n, 1), np.log(RATE)), np.full((n, 1), tau), np.random.default_rng(1))
    found = np.bincount(x[:, 0], minlength=len(COUNTS))[: len(COUNTS)] / n
    exact = COUNTED["dead time"].pmf(RATE, tau)
    assert np.abs(found - exact).max() < 5 * np.sqrt(exact.max() / n)


def left(truth, shape):
    return fitted(seen(COUNTED[truth], "counts"), COUNTED[shape], (10, 90))


def test_a_rate_that_varies_is_not_told_from_counts_that_are_doubled():
    assert left("pairs", "gamma rates") < 1
    assert left("dead channel", "gamma rates") > 10
