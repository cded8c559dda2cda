"""Effects on counts: the newer families, and all of them on several counts an event or beside real numbers."""

import numpy as np
import pytest
from measurements import BESIDE, WEEKS, applied
from scipy.stats import norm, poisson

from avobench.bench.conformance import effects as suite
from avobench.effects.catalogue import catalogue, chosen, of_domain
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson

N = 200_000


def effect_of(task, name, shape=None, feature=None):
    """Of an effect, by the name of its module, since several may have one name; in any shape if that is None."""
    entries = [effect for effect in chosen(catalogue(task), [name], task.name) if effect.feature == feature]
    return next(one for entry in entries for one in entry.shapes() if shape in (None, one.shape))


def events(task, effects, params, n=N):
    return Model(task, tuple(effects)).simulate(np.tile(params, (n, 1)), np.random.default_rng(0))


def test_a_limit_is_looked_for_among_the_measured_counts():
    x = np.random.default_rng(0).poisson(6, (1000, 1))
    limit = effect_of(Poisson(), "truncation").adapted(x).parameters[1]
    assert (limit.low, limit.high) == (np.median(x), x.max() + 1)


PART = 0.25 * 0.8 / 2
MOMENTS = [  # of a Poisson count of a rate, by the law of total variance
    ("after_pulses", "chain", 3, [0.3], 3 / 0.7, 3 * 1.3 / 0.7**2),
    ("after_pulses", "one_generation", 3, [0.3], 3 * 1.3, 3 * (0.3 + 1.3**2)),
    ("pile_up", "sometimes", 6, [0.8, 0.25], 6 * (1 + PART), 6 * (1 + PART) + 36 * (0.25 * 0.8**2 / 3 - PART**2)),
    ("pile_up", "several", 6, [0.5, 1.5], 6 * 1.75, 6 * 1.75 + 36 * 0.25 * 1.5),
    ("overdispersion", "gamma", 20, [0.04], 20, 20 + 0.04 * 400),
    ("overdispersion", "lognormal", 20, [0.04], 20, 20 + 0.04 * 400),
    ("overdispersion", "skewed", 20, [0.04, 0.5], 20, 20 + 0.04 * 400),
    ("overdispersion", "drift", 20, [0.04], 20, 20 + 0.04 * 400),
    ("overdispersion", "uniform", 20, [0.04], 20, 20 + 0.04 * 400),
    ("overdispersion", "flares", 20, [0.5, 0.05], 20, 20 + 0.5 * 400),
    ("overdispersion", "flares", 20, [0.1, 0.3], 20, 20 + 0.1 * 400),
    ("overdispersion", "decaying", 20, [0.3], 20, 20 + 0.3 * 400),
    ("overdispersion", "decaying", 20, [1e-6], 20, 20),
    ("flat_background", "added", 6, [0.2, 8.0], 6 + 0.2 / np.expm1(1 / 8.0), None),  # a whole part of an exponential
]


@pytest.mark.parametrize(("name", "shape", "rate", "phi", "mean", "variance"), MOMENTS)
def test_counts_have_the_moments_of_what_happened_to_them(name, shape, rate, phi, mean, variance):
    x = events(Poisson(), [effect_of(Poisson(), name, shape)], [np.log(rate), *phi])[:, 0]
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N))
    assert variance is None or x.var() == pytest.approx(variance, rel=0.04)


K = np.arange(25)
PMF, BEYOND = poisson.pmf(K, 6), poisson.sf(8, 6)


def weighed(kept):
    return PMF * kept / (PMF * kept).sum()


def at(shares):
    """Probabilities of counts, of which these are given."""
    return np.array([shares.get(k, PMF[k]) for k in K])


SUPPRESSED = PMF * (1 - 0.8 / (1 + np.exp((K - 4) / 0.6)))
PROBABILITIES = [
    ("truncation", "", [0.4, 7.0], weighed(np.where(K > 7, 0.6, 1))),
    ("truncation", "", [1.0, 7.0], weighed(K <= 7)),
    ("truncation", "soft", [0.9, 7.0, 1.5], weighed(1 - 0.9 / (1 + np.exp(-(K - 7) / 1.5)))),
    ("threshold_loss", "suppressed", [0.8, 4.0], np.r_[1 - SUPPRESSED[1:].sum(), SUPPRESSED[1:]]),
    # between two counts a limit is the upper one for its share, and counts beyond it are recorded as one of them
    ("censoring", "above", [1.0, 8.3], np.where(K > 9, 0, at({8: PMF[8] + 0.7 * BEYOND, 9: 0.3 * BEYOND}))),
    (
        *("censoring", "below", [1.0, 3.6]),
        np.where(K < 3, 0, at({3: 0.4 * poisson.cdf(3, 6), 4: PMF[4] + 0.6 * poisson.cdf(3, 6)})),
    ),
]


@pytest.mark.parametrize(("name", "shape", "phi", "expected"), PROBABILITIES)
def test_counts_have_the_probabilities_of_what_is_lost_or_cut(name, shape, phi, expected):
    x = events(Poisson(), [effect_of(Poisson(), name, shape)], [np.log(6.0), *phi])[:, 0]
    np.testing.assert_allclose(np.bincount(x, minlength=25)[:25] / N, expected, atol=5 * 0.5 / np.sqrt(N))


READ = [  # of a reading of `at`: values that may be read, how many are not `at`, and the variance
    ("readout_noise", "sometimes", 50, [6.0, 0.25], None, 0.25 * 2 * norm.sf(0.5 / 6), 0.25 * (6**2 + 1 / 12)),
    ("readout_noise", "upset", 21, [0.3, 4.0], {21, 20, 23, 17, 29}, 0.3, None),
    ("readout_noise", "jumps", 100, [5.0, 0.3], {95, 100, 105}, 0.3, 0.3 * 25),
    ("readout_noise", "hum", 100, [5.0], set(range(93, 108)), None, 25 + 1 / 12),  # a sine wave of rms 5
    ("flat_background", "swept", 0, [1.0, 200.0], None, None, 200**2 / 8 + 100),  # a rate that is a sine as well
]


@pytest.mark.parametrize(("name", "shape", "at", "phi", "values", "changed", "variance"), READ)
def test_readings_are_off_by_what_is_said(name, shape, at, phi, values, changed, variance):
    x = applied(effect_of(Poisson(), name, shape), np.full((N, 1), at), phi)[:, 0]
    assert values is None or set(x) == values
    assert changed is None or (x != at).mean() == pytest.approx(changed, abs=5 * 0.5 / np.sqrt(N))
    assert variance is None or x.var() == pytest.approx(variance, rel=0.05)
    if shape != "upset":
        assert x.mean() == pytest.approx(100 if shape == "swept" else at, abs=5 * x.std() / np.sqrt(N))


@pytest.mark.parametrize(("shape", "limit", "outermost"), [("above", 8, [6, 7, 8]), ("below", 4, [4, 5, 6])])
def test_the_limit_of_censored_counts_is_read_off_the_data(shape, limit, outermost):
    effect = effect_of(Poisson(), "censoring", shape)
    x = events(Poisson(), [effect], [np.log(6.0), 1.0, limit], 20_000)
    shown = effect.adapted(x)
    assert shown.parameters[1].low <= limit <= shown.parameters[1].high
    assert sorted(set(shown.guess(x)[:, 1].tolist())) == outermost


def test_a_limit_far_within_the_counts_is_where_they_gather():
    """A share of half leaves counts beyond the limit, and it may be below the median."""
    for shape, limit in (("above", 24), ("below", 16), ("above", 18), ("below", 22)):
        effect = effect_of(Poisson(), "censoring", shape)
        x = events(Poisson(), [effect], [np.log(20.0), 0.5, limit], 20_000)
        assert limit in effect.adapted(x).guess(x)[:, 1]


@pytest.mark.parametrize("rate", [0.3, 1.0, 2.0, 6.0, 50.0, 3000.0])
def test_of_counts_that_nothing_censors_only_the_outermost_may_be_a_limit(rate):
    x = np.random.default_rng(0).poisson(rate, (50_000, 1))
    for shape in effect_of(Poisson(), "censoring").shapes():
        limits = np.unique(shape.guess(x)[:, 1])
        assert 1 <= len(limits) <= 3
        away = x.max() - limits if shape.shape == "above" else limits - max(x.min(), 1)
        assert ((away >= 0) & (away < 3)).all()
        low, high = np.quantile(x, [0.1, 0.9])
        assert (limits >= low if shape.shape == "above" else limits <= max(high, 1)).all()


def test_an_excess_of_zeros_stands_beside_another_process():
    """A channel that is off behind a dead time: only no pulse at all makes a dead counter read zero."""
    effects = [effect_of(Poisson(), "zero_inflation", "dead"), effect_of(Poisson(), "dead_time", "non_paralysable")]
    both = events(Poisson(), effects, [np.log(3.0), 0.2, 0.1])[:, 0]
    alone = events(Poisson(), effects[1:], [np.log(3.0), 0.1])[:, 0]
    assert (both == 0).mean() == pytest.approx(0.2 + 0.8 * np.exp(-3), abs=5 * 0.5 / np.sqrt(N))
    assert both.mean() == pytest.approx(0.8 * alone.mean(), rel=0.01)


def test_what_happens_to_an_event_happens_to_all_its_counts_and_to_a_count_by_itself():
    theta = [np.log(5.0)]
    off = events(WEEKS, [effect_of(WEEKS, "zero_inflation", "dead", "all")], [*theta, 0.3])
    assert (off == 0).all(axis=1).mean() == pytest.approx(0.3, abs=0.01)
    scattered = events(WEEKS, [effect_of(WEEKS, "overdispersion", "gamma", "all")], [*theta, 0.1])
    thinned = events(WEEKS, [effect_of(WEEKS, "inefficiency", "", "all")], [*theta, 0.4])
    for x, covariance in ((scattered, 0.1 * np.outer([5, 10, 20], [5, 10, 20])), (thinned, np.zeros((3, 3)))):
        off_diagonal = ~np.eye(3, dtype=bool)
        assert np.cov(x.T)[off_diagonal] == pytest.approx(covariance[off_diagonal], rel=0.1, abs=0.3)
    assert thinned.mean(axis=0) == pytest.approx(0.6 * np.array([5, 10, 20]), rel=0.01)


def test_an_effect_on_one_count_leaves_the_others_as_they_are():
    plain = events(WEEKS, [], [np.log(5.0)], 2000)
    for name in ("readout_noise", "double_counting", "dead_time"):
        effect = effect_of(WEEKS, name, None, 1)
        x = applied(effect, plain, [(p.low + p.high) / 2 for p in effect.parameters])
        assert (x[:, [0, 2]] == plain[:, [0, 2]]).all()
        assert (x[:, 1] != plain[:, 1]).any()


@pytest.mark.parametrize(("which", "feature"), [(WEEKS, 2), (WEEKS, "all"), (BESIDE, 1)], ids=["one", "all", "beside"])
@pytest.mark.parametrize("family", [one for one in of_domain("counts") if one.name not in ("spread", "mixture")])
def test_effects_keep_their_contract_on_any_count(family, which, feature):
    effect = next(entry for entry in catalogue(which) if type(entry) is family and entry.feature == feature)
    family = effect.name
    (described,), checks = suite.rounds(family, [(which, effect)])
    described[1]()
    wanted = effect.shapes()[:: max(1, len(effect.shapes()) // 3)]
    names = {f"({which.name}{', ' + shape.shape if shape.shape else ''})" for shape in wanted}
    tried = [check for what, check in checks if any(what.endswith(name) for name in names) and "process" not in what]
    assert len(tried) == 4 * len(wanted)
    for check in tried:
        check()
