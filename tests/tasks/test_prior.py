"""Priors by distributions of SciPy's."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import avobench
from avobench.bench.cells.prior_shares import in_shares, raw
from avobench.methods import Estimate, WeightedSample
from avobench.methods.abc_smc import AbcSmc
from avobench.tasks import Box
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed, Law

LAWS = {"mu": stats.norm(1, 0.5), "tau": stats.gamma(2, scale=3.0), "n": stats.poisson(3)}


def simulate(theta, rng):
    return theta[:, 0] + rng.normal(size=len(theta))


def made(prior, **more):
    return avobench.task(simulate, prior=prior, name="prior", **more)


HALF_AT_ZERO = SimpleNamespace(ppf=lambda q: np.maximum(np.asarray(q) - 0.5, 0), cdf=lambda x: np.clip(x + 0.5, 0, 1))
BROKEN = SimpleNamespace(ppf=lambda q: {}["q"], cdf=HALF_AT_ZERO.cdf)
MIXED = made({**LAWS, "flat": (2, 4)}, kinds={"n": "integer"}).prior


@given(st.lists(st.floats(0, 1), min_size=2, max_size=20))
def test_shares_of_a_prior_are_those_below_its_quantiles(shares):
    share = np.tile(np.array(shares)[:, None], (1, 4))
    theta = MIXED.at(share)
    np.testing.assert_allclose(MIXED.shares(theta), share, atol=1e-9)
    assert MIXED.contains(theta).all()
    np.testing.assert_allclose(theta[:, 3], 2 + 2 * share[:, 3])


def test_draws_are_of_the_distribution():
    x = made({"mu": LAWS["mu"], "tau": LAWS["tau"]}).prior.sample(4000, np.random.default_rng(0))
    assert all(stats.kstest(x[:, j], LAWS[name].cdf).pvalue > 1e-3 for j, name in enumerate(("mu", "tau")))


@pytest.mark.parametrize(
    "law",
    [
        *(stats.bernoulli(0.9), stats.binom(3, 0.1), stats.geom(0.5), stats.poisson(1), stats.poisson(300)),
        *(stats.randint(0, 3), stats.nbinom(2, 0.01), stats.hypergeom(20, 7, 12), stats.poisson(3, loc=-5)),
    ],
    ids=lambda law: law.dist.name,
)
def test_draws_made_whole_have_the_probabilities_of_the_law(law):
    """A draw at every share, of which the part above a whole number is the probability to be rounded up."""
    prior = made({"a": law}, kinds={"a": "integer"}).prior
    draws = prior.at((np.arange(200_000)[:, None] + 0.5) / 200_000)[:, 0]
    values = np.arange(prior.low[0], prior.high[0] + 1)
    up, index = draws % 1, np.floor(draws - values[0]).astype(int)
    found = np.bincount(index, 1 - up, len(values)) + np.bincount(index + 1, up, len(values) + 1)[:-1]
    wanted = law.pmf(values) / law.pmf(values).sum()
    np.testing.assert_allclose(found / 200_000, wanted, atol=1e-4)


def test_parameters_at_random_and_the_posterior_of_no_events_have_the_probabilities_of_the_law():
    """Of 2 000 truths, and of an inference from events that do not depend on the parameter."""
    prior = {"a": stats.bernoulli(0.9)}
    task = avobench.task(lambda theta, rng: rng.normal(size=len(theta)), prior=prior, kinds={"a": "integer"}, name="a")
    drawn = task.at_whole(task.prior.sample(2000, rng := np.random.default_rng(0)), rng)
    for whole in (task.targets(2000), drawn):
        assert stats.binomtest(int((whole == 1).sum()), 2000, 0.9).pvalue > 1e-4
    fit = avobench.infer(task, np.random.default_rng(0).normal(size=20), "abc-smc", budget=60_000, progress=False)
    assert fit.estimate.mean[0] == pytest.approx(0.9, abs=0.07)


@pytest.mark.parametrize(
    ("prior", "kind", "said"),
    [
        (stats.norm, None, "lacks its parameters"),
        (stats.multivariate_normal([0, 0]), None, "a distribution of one number such as"),
        (stats.norm([0, 1], 1), None, "distribution of one number"),
        (stats.norm(0, -1), None, "no finite width"),
        (stats.rv_histogram(np.histogram([1, 2, 3])), "integer", "by name"),
        (HALF_AT_ZERO, None, "must be a continuous distribution"),
        (BROKEN, None, "cannot be used: KeyError"),
        (stats.poisson(3), None, "kinds={'a': 'integer'}"),
        (stats.norm(0, 1), "integer", "of whole numbers"),
        (stats.randint(0, 10**9), "integer", "more than"),
    ],
)
def test_what_is_no_distribution_of_one_number_is_refused_in_a_line(prior, kind, said):
    with pytest.raises(UsageError, match=said):
        made({"a": prior}, kinds=kind and {"a": kind})


def test_an_answer_by_shares_is_told_in_the_units_of_the_parameter():
    """Of a lognormal parameter: points one by one, an error by the slope of its quantiles."""
    task = made({"size": stats.lognorm(1.0)})
    prior = task.prior
    points = np.linspace(0.2, 0.8, 7)[:, None]
    told = Estimate(np.array([0.5]), "", "posterior", np.array([0.5]), np.array([0.2]), error=np.array([1e-4]))
    posed = in_shares(task, AbcSmc())
    known, sample = raw(told, posed), raw(replace(told, error=None, sample=WeightedSample.equal(points)), posed)
    assert known.theta == pytest.approx([1.0], rel=1e-3)
    assert known.error == pytest.approx(1e-4 / stats.lognorm(1.0).pdf(1.0), rel=1e-2)
    assert sample.mean == pytest.approx(prior.at(points).mean(axis=0))
    assert sample.std == pytest.approx(prior.at(points).std(axis=0))


def test_a_uniform_prior_is_left_alone():
    task = made({"a": (0, 1)})
    assert in_shares(task, AbcSmc()) is task
    assert not isinstance(task.prior, Distributed)


@pytest.mark.parametrize("law", [stats.norm(1, 0.5), stats.gamma(2, scale=3.0), stats.beta(2, 8), stats.uniform(1, 2)])
def test_a_prior_has_the_moments_of_its_law(law):
    prior = made({"a": law, "b": (0, 1)}).prior
    np.testing.assert_allclose(prior.mean, [law.mean(), 0.5], rtol=2e-3)
    np.testing.assert_allclose(prior.std, [law.std(), np.sqrt(1 / 12)], rtol=6e-3)


@pytest.mark.parametrize(("truth", "num"), [(2.5, 1000), (1.0, 1000), (0.5, 5), (0.5, 2)])
def test_moments_with_a_gaussian_prior_find_its_conjugate_posterior(truth, num):
    """Of 40 000 simulated events in eight rounds the estimate has 0.2 standard deviations of scatter of its own."""
    task, variance = made({"mu": stats.norm(0, 1)}), 1 / (num + 1)
    for seed in range(3):
        x = np.random.default_rng(seed).normal(truth, 1, num)
        fit = avobench.infer(task, x, "smm", budget=40_000, seed=seed, progress=False)
        assert abs(fit.theta["mu"] - x.sum() * variance) < np.sqrt(variance)
        assert fit.std["mu"] == pytest.approx(np.sqrt(variance), rel=0.15)


NARROW = 20_000**-0.5
"""The standard error of the mean of so many normal numbers."""


def narrow(support=None):
    """A normal mean of which the prior knows as much as 20 000 events do."""
    return avobench.task(
        lambda theta, rng: rng.normal(theta[:, 0]), prior={"mu": stats.norm(0, NARROW)}, support=support, name="normal"
    )


@pytest.mark.parametrize(
    ("method", "settings"),
    [("smm", {}), ("rank-moments", {}), ("avo", {"iterations": 20, "statistic_steps": 50, "hidden": (8,)})],
)
def test_a_prior_as_narrow_as_the_errors_of_the_events_hides_nothing(method, settings):
    """The conjugate posterior is half way between, and smaller by the root of two; with the noise of simulation."""
    x = np.random.default_rng(3).normal(3 * NARROW, 1, 20_000)
    fit = avobench.infer(narrow({"mu": (-1, 1)}), x, method, budget=60_000, settings=settings, seed=1, progress=False)
    error = NARROW / np.sqrt(2)
    assert abs(fit.theta["mu"] - x.mean() / 2) < error
    assert fit.std["mu"] == pytest.approx(1.1 * error, rel=0.15)
    assert fit.estimate.doubt == ""
    assert fit.left_open == []


@pytest.mark.parametrize("method", ["smm", "rank-moments"])
def test_a_narrow_prior_beyond_which_nothing_can_be_simulated_is_a_doubt(method):
    x = np.random.default_rng(3).normal(3 * NARROW, 1, 20_000)
    fit = avobench.infer(narrow(), x, method, budget=20_000, progress=False)
    assert "wider than the prior" in fit.estimate.doubt


def test_the_prior_of_a_later_fit_has_the_support_of_the_first():
    first = narrow({"mu": (-1, 2)})
    fit = avobench.infer(first, np.random.default_rng(0).normal(size=200), "smm", budget=2000, progress=False)
    make = partial(avobench.task, first.function, prior=fit.as_prior())
    assert make().support == first.support
    assert make(support={"mu": (-3, 3)}).support == Box((-3.0,), (3.0,))


def test_what_events_do_not_tell_keeps_its_prior_and_is_said(tmp_path):
    """Events know the sum of two parameters to 0.03, so what they leave open has the width of one prior or of both."""
    both = made({"mu": stats.norm(0, 1), "b": stats.norm(0.2, 0.1), "c": stats.gamma(4)})
    task = avobench.task(lambda theta, rng: rng.normal(theta[:, 0] + theta[:, 1]), prior=both.arguments["prior"])
    x = np.random.default_rng(0).normal(1, 1, 1000)
    fit = avobench.infer(task, x, "smm", budget=40_000, progress=False)
    assert fit.std["b"] == pytest.approx(0.1, rel=0.03)
    assert fit.std["mu"] == pytest.approx(0.105, rel=0.25)
    assert fit.std["c"] == pytest.approx(2, rel=0.03)
    assert fit.theta["c"] == pytest.approx(4, abs=0.1)
    assert all(any(f"{name} =" in said for said in fit.left_open) for name in "bc")
    assert avobench.load(fit.save(tmp_path / "fit.json")).left_open == fit.left_open


def test_whole_numbers_with_a_law_are_fitted_by_moments():
    task, x = made({"n": LAWS["n"]}, kinds={"n": "integer"}), np.random.default_rng(0).normal(6, 1, 500)
    assert avobench.infer(task, x, "smm", budget=20_000, progress=False).theta["n"] == 6


def test_a_fit_and_its_model_keep_the_prior(tmp_path):
    task = made({"mu": LAWS["mu"]})
    far = np.random.default_rng(0).normal(2, 1, 300)
    assert avobench.infer(task, far, "smm", budget=8000).theta["mu"] == pytest.approx(2, abs=0.3)
    avobench.diagnose(task, far, effects=[], simulations=40_000, progress=False).save(tmp_path)
    again = avobench.load(tmp_path / "model.json", trust=True)
    assert again.prior.laws == task.prior.laws == (Law("norm", (1.0, 0.5)),)
    assert again.model.task.prior == task.prior


def test_a_law_of_a_file_names_a_distribution_alone():
    with pytest.raises(ValueError, match="no distribution"):
        Law("os", ())


def test_a_histogram_is_a_prior_and_is_kept_as_text():
    counts, edges = [1, 3, 4], [0.0, 1.0, 2.0, 5.0]
    prior = made({"a": stats.rv_histogram((counts, edges), density=False)}).prior
    np.testing.assert_allclose(prior.shares(np.array([[1.0], [2.0]])).ravel(), [1 / 8, 1 / 2], atol=0.01)
    again = made({"a": eval(repr(prior.laws[0]), {"scipy": __import__("scipy")})}).prior
    share = np.linspace(0, 1, 11)[:, None]
    np.testing.assert_allclose(again.at(share), prior.at(share), atol=1e-9)


@pytest.mark.parametrize("method", ["abc-smc", "smm"])
def test_what_was_learned_is_the_prior_of_the_next_fit(method):
    task = made({"mu": stats.norm(1, 0.5), "b": (0, 1)})
    x = np.random.default_rng(0).normal(1.3, 1, 2000)
    fit = avobench.infer(task, x, method, budget=60_000, progress=False)
    later = made(fit.as_prior()).prior
    draws = later.sample(20_000, np.random.default_rng(1))
    known = fit.samples(20_000)
    np.testing.assert_allclose(draws.mean(axis=0), known.mean(), atol=0.1 * known.std().max())
    assert (draws.std(axis=0) > 0.9 * known.std()).all()
    assert task.support.contains(draws).all()
