"""Effects that act through the parameters of a simulator: the moments of what they make."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import entry, shape_of
from scipy.stats import truncnorm

from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.site import Site
from avobench.effects.theta import Spread
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

N = 200_000


def itself(theta, rng):
    return theta[:, 0]


COPY = task(itself, prior={"a": (0, 4)}, support={"a": (-1, 6)}, units={"a": "GeV"}, name="copy")


def events(task, effect, theta, phi, n=N):
    return Model(task, (effect,)).simulate(np.tile([*theta, *phi], (n, 1)), np.random.default_rng(0))[:, 0]


@pytest.mark.parametrize("shape", ["gaussian", "uniform", "two_values"])
def test_a_spread_has_the_stated_width_and_changes_no_mean_far_from_the_ends(shape):
    effect = shape_of(entry(COPY, "spread", "a"), shape)
    x = events(COPY, effect, [2.5], [0.5])
    assert x.mean() == pytest.approx(2.5, abs=5 * 0.5 / np.sqrt(N))
    assert x.std() == pytest.approx(0.5, rel=0.01)
    assert events(COPY, effect, [2.5], [0.0], 100) == pytest.approx(2.5, abs=1e-7)
    assert effect.parameters[0].unit == "GeV"


@pytest.mark.parametrize(
    ("shape", "moments"),
    [
        ("gaussian", truncnorm.stats(-0.5, np.inf, loc=-0.5, scale=1.0)),
        ("uniform", ((-1 - 0.5 + np.sqrt(3)) / 2, (np.sqrt(3) + 0.5) ** 2 / 12)),
        ("two_values", ((-1 + 0.5) / 2, 0.75**2)),
    ],
)
def test_what_would_leave_the_support_is_drawn_again_or_ends_there(shape, moments):
    """The support ends half a width below: the moments of a truncated distribution, of two values the end itself."""
    x = events(COPY, shape_of(entry(COPY, "spread", "a"), shape), [-0.5], [1.0])
    assert x.mean() == pytest.approx(float(moments[0]), abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(float(moments[1]), rel=0.02)


@given(st.floats(-1, 6), st.floats(0, 2.4), st.sampled_from(["gaussian", "uniform", "two_values"]))
def test_a_spread_stays_within_the_support_and_is_a_number(at, width, shape):
    x = events(COPY, shape_of(entry(COPY, "spread", "a"), shape), [at], [width], 300)
    assert np.isfinite(x).all()
    assert (x >= -1).all()
    assert (x <= 6).all()


def test_a_log_rate_that_spreads_is_an_overdispersion():
    """A lognormal rate: variance m + m^2 (exp(s^2) - 1), as the shape of overdispersion with that relative variance."""
    theta, width = np.log(8.0), 0.4
    assert Spread.entries(Site(Poisson())) == []  # so that they never tie
    log_rate = Spread(feature="log_rate", support=(Poisson().support.low[0], Poisson().support.high[0]))
    spread = events(Poisson(), log_rate, [theta], [width])
    mean = 8 * np.exp(width**2 / 2)
    assert spread.mean() == pytest.approx(mean, rel=0.01)
    assert spread.var() == pytest.approx(mean + mean**2 * np.expm1(width**2), rel=0.03)
    other = shape_of(entry(Poisson(), "overdispersion", None), "lognormal")
    same = events(Poisson(), other, [np.log(mean)], [np.expm1(width**2)])
    k = np.arange(60)
    assert abs((spread[:, None] > k).mean(axis=0) - (same[:, None] > k).mean(axis=0)).max() < 5 * np.sqrt(0.5 / N)


def test_each_parameter_of_a_task_may_spread_by_itself():
    entries = [effect for effect in catalogue(Weinberg()) if effect.name == "spread"]
    assert [effect.feature for effect in entries] == ["e_beam", "g_f"]
    theta, seen = np.tile([45.0, 1.0], (100, 1)), []
    entries[1].apply(lambda theta, rng: seen.append(theta), theta, np.full((100, 1), 0.1), np.random.default_rng(0))
    assert (seen[0][:, 0] == 45).all()
    assert len(np.unique(seen[0][:, 1])) == 100
    assert (theta == [45.0, 1.0]).all()


def test_a_mixture_has_the_moments_of_two_populations():
    share, rates = 0.3, np.array([4.0, 15.0])
    x = events(Poisson(), shape_of(entry(Poisson(), "mixture", None)), [np.log(rates[0])], [share, np.log(rates[1])])
    mean = (1 - share) * rates[0] + share * rates[1]
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(mean + share * (1 - share) * np.diff(rates)[0] ** 2, rel=0.02)


def test_a_second_population_lies_within_the_support_and_of_many_parameters_differs_in_one():
    both = shape_of(entry(Weinberg(), "mixture", None))
    assert [(p.name, p.unit) for p in both.parameters[1:]] == [("other_e_beam", "GeV"), ("other_g_f", "1")]
    assert [(p.low, p.high) for p in both.parameters[1:]] == [(42.8, 47.2), (-0.2, 2.2)]
    many = task(itself, prior={f"p{k}": (0, 1) for k in range(7)}, name="many")
    one_each = [effect for effect in catalogue(many) if effect.name == "mixture"]
    assert [effect.feature for effect in one_each] == list(many.parameter_names)
    assert {len(effect.parameters) for effect in one_each} == {2}
