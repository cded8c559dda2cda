"""Effects on counts: the newer families, and all of them on several counts an event or beside real numbers."""

import numpy as np
import pytest
from scipy.stats import norm, poisson

from avobench.bench.conformance import effects as suite
from avobench.effects.catalogue import catalogue, chosen, of_domain
from avobench.effects.counts.exposure import RATES
from avobench.effects.model import Model
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson

N = 200_000


def rng():
    return np.random.default_rng(0)


def weeks(theta, rng):
    return rng.poisson(np.exp(theta[:, [0]]) * [1, 2, 4])


def beside(theta, rng):
    return np.column_stack([rng.normal(theta[:, 0]), rng.poisson(np.exp(theta[:, 0]))])


WEEKS = task(weeks, prior={"log_rate": (0, 3)})
BESIDE = task(beside, prior={"log_rate": (0, 3)}, kinds={"x2": "count"})


def effect_of(task, name, shape=None, feature=None):
    """Of an effect, by the name of its module, since several may have one name; in any shape if that is None."""
    entries = [effect for effect in chosen(catalogue(task), [name], task.name) if effect.feature == feature]
    return next(one for entry in entries for one in entry.shapes() if shape in (None, one.shape))


def events(task, effects, params, n=N):
    return Model(task, tuple(effects)).simulate(np.tile(params, (n, 1)), np.random.default_rng(0))


@pytest.mark.parametrize(
    ("shape", "mean", "variance"),
    [
        ("chain", lambda p: 1 / (1 - p), lambda p: (1 + p) / (1 - p) ** 2),
        ("one_generation", lambda p: 1 + p, lambda p: p + (1 + p) ** 2),
    ],
)
def test_afterpulses_have_the_moments_of_their_generations(shape, mean, variance):
    """Of a Poisson count both moments are in proportion to its rate (law of total variance)."""
    x = events(Poisson(), [effect_of(Poisson(), "after_pulses", shape)], [np.log(3.0), 0.3])[:, 0]
    assert x.mean() == pytest.approx(3 * mean(0.3), abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(3 * variance(0.3), rel=0.02)


@pytest.mark.parametrize("lost", [0.4, 1.0])
def test_truncated_counts_are_those_up_to_the_limit(lost):
    x = events(Poisson(), [effect_of(Poisson(), "truncation", "")], [np.log(6.0), lost, 7.0])[:, 0]
    k = np.arange(25)
    kept = poisson.pmf(k, 6) * np.where(k > 7, 1 - lost, 1)
    np.testing.assert_allclose(np.bincount(x, minlength=25)[:25] / N, kept / kept.sum(), atol=5 * 0.5 / np.sqrt(N))


def test_a_soft_limit_loses_a_logistic_share():
    x = events(Poisson(), [effect_of(Poisson(), "truncation", "soft")], [np.log(6.0), 0.9, 7.0, 1.5])[:, 0]
    k = np.arange(25)
    kept = poisson.pmf(k, 6) * (1 - 0.9 / (1 + np.exp(-(k - 7) / 1.5)))
    np.testing.assert_allclose(np.bincount(x, minlength=25)[:25] / N, kept / kept.sum(), atol=5 * 0.5 / np.sqrt(N))


def test_a_limit_is_looked_for_among_the_measured_counts():
    x = np.random.default_rng(0).poisson(6, (1000, 1))
    limit = effect_of(Poisson(), "truncation").adapted(x).parameters[1]
    assert (limit.low, limit.high) == (np.median(x), x.max() + 1)


@pytest.mark.parametrize(("shape", "limit", "piled"), [("above", 8, poisson.sf(7, 6)), ("below", 4, poisson.cdf(4, 6))])
def test_censored_counts_are_a_spike_at_the_limit_which_is_read_off_the_data(shape, limit, piled):
    effect = effect_of(Poisson(), "censoring", shape)
    x = events(Poisson(), [effect], [np.log(6.0), 1.0, limit], 20_000)
    assert (x == limit).mean() == pytest.approx(piled, abs=5 * 0.5 / np.sqrt(20_000))
    assert (x.max() if shape == "above" else x.min()) == limit
    shown = effect.adapted(x)
    assert shown.parameters[1].low <= limit <= shown.parameters[1].high
    outermost = [6, 7, 8] if shape == "above" else [4, 5, 6]
    assert sorted(set(shown.guess(x)[:, 1].tolist())) == outermost


def test_a_limit_between_two_counts_is_the_upper_one_for_its_share():
    """Of counts beyond 8.3, three in ten are recorded as 9, or as themselves if they are, and the others as 8."""
    x = events(Poisson(), [effect_of(Poisson(), "censoring", "above")], [np.log(6.0), 1.0, 8.3])[:, 0]
    beyond, error = poisson.sf(8, 6), 5 * 0.5 / np.sqrt(N)
    assert x.max() == 9
    assert (x == 9).mean() == pytest.approx(0.3 * beyond, abs=error)
    assert (x == 8).mean() == pytest.approx(poisson.pmf(8, 6) + 0.7 * beyond, abs=error)
    x = events(Poisson(), [effect_of(Poisson(), "censoring", "below")], [np.log(6.0), 1.0, 3.6])[:, 0]
    assert x.min() == 3
    assert (x == 3).mean() == pytest.approx(0.4 * poisson.cdf(3, 6), abs=error)
    assert (x == 4).mean() == pytest.approx(poisson.pmf(4, 6) + 0.6 * poisson.cdf(3, 6), abs=error)


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


def test_what_a_threshold_suppresses_reads_zero():
    x = events(Poisson(), [effect_of(Poisson(), "threshold_loss", "suppressed")], [np.log(6.0), 0.8, 4.0])[:, 0]
    k = np.arange(25)
    kept = 1 - 0.8 / (1 + np.exp((k - 4) / 0.6))
    expected = poisson.pmf(k, 6) * kept
    expected[0] = 1 - expected[1:].sum()
    np.testing.assert_allclose(np.bincount(x, minlength=25)[:25] / N, expected, atol=5 * 0.5 / np.sqrt(N))


def test_a_noise_that_comes_sometimes_leaves_the_other_readings():
    effect, phi = effect_of(Poisson(), "readout_noise", "sometimes"), np.tile([6.0, 0.25], (N, 1))
    x = effect.apply(lambda theta, rng: np.full((N, 1), 50), phi, phi, rng())[:, 0]
    changed = 0.25 * (2 * norm.sf(0.5 / 6))
    assert (x != 50).mean() == pytest.approx(changed, abs=5 * 0.5 / np.sqrt(N))
    assert x.var() == pytest.approx(0.25 * (6**2 + 1 / 12), rel=0.05)


def test_a_background_that_is_added_has_its_moments():
    x = events(Poisson(), [effect_of(Poisson(), "flat_background", "added")], [np.log(6.0), 0.2, 8.0])[:, 0]
    mean = 1 / np.expm1(1 / 8.0)  # of a whole part of an exponential
    assert x.mean() == pytest.approx(6 + 0.2 * mean, abs=5 * x.std() / np.sqrt(N))


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
        phi = [(p.low + p.high) / 2 for p in effect.parameters]
        x = effect.apply(
            lambda theta, rng: plain[: len(theta)].copy(), plain, np.tile(phi, (2000, 1)), np.random.default_rng(0)
        )
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


def test_pile_up_that_comes_sometimes_adds_any_part_of_another_event():
    x = events(Poisson(), [effect_of(Poisson(), "pile_up", "sometimes")], [np.log(6.0), 0.8, 0.25])[:, 0]
    part, square = 0.25 * 0.4, 0.25 * 0.8**2 / 3
    assert x.mean() == pytest.approx(6 * (1 + part), abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(6 * (1 + part) + 36 * (square - part**2), rel=0.02)


@pytest.mark.parametrize(("variance", "share"), [(0.1, 0.3), (0.5, 0.05), (1.0, 0.5)])
def test_flares_keep_the_mean_rate_and_have_the_variance(variance, share):
    phi = np.tile([variance, share], (N, 1))
    rates = RATES["flares"].drawn(phi[:, 0], phi, rng())
    assert rates.mean() == pytest.approx(1, abs=5 * rates.std() / np.sqrt(N))
    assert rates.var() == pytest.approx(variance, rel=0.06)
    assert (rates > rates.min() + 1e-9).mean() == pytest.approx(share, abs=5 * 0.5 / np.sqrt(N))


def test_a_source_that_decays_keeps_the_mean_rate_and_has_the_variance():
    for variance in (1e-6, 0.01, 0.3, 1.0):
        phi = np.tile([variance], (N, 1))
        rates = RATES["decaying"].drawn(phi[:, 0], phi, rng())
        assert rates.mean() == pytest.approx(1, abs=5 * rates.std() / np.sqrt(N))
        assert rates.var() == pytest.approx(variance, rel=0.02)
        assert rates.max() / rates.min() == pytest.approx(np.exp(np.ptp(np.log(rates))))


def test_pile_up_of_several_adds_a_part_of_each():
    x = events(Poisson(), [effect_of(Poisson(), "pile_up", "several")], [np.log(6.0), 0.5, 1.5])[:, 0]
    mean, variance = 6 * (1 + 0.75), 6 * (1 + 0.75) + 36 * 0.25 * 1.5
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(variance, rel=0.02)


def test_a_swept_background_gathers_at_both_ends_of_its_range():
    phi = np.tile([1.0, 200.0], (N, 1))
    x = effect_of(Poisson(), "flat_background", "swept").apply(
        lambda theta, rng: np.zeros((N, 1), int), phi, phi, rng()
    )
    assert x.mean() == pytest.approx(100, abs=5 * x.std() / np.sqrt(N))
    assert x.var() == pytest.approx(200**2 / 8 + 100, rel=0.02)


def test_an_upset_flips_one_bit_of_some_readings():
    effect, phi = effect_of(Poisson(), "readout_noise", "upset"), np.tile([0.3, 4.0], (N, 1))
    x = effect.apply(lambda theta, rng: np.full((N, 1), 21), phi, phi, rng())[:, 0]
    assert set(x) == {21, 20, 23, 17, 29}
    assert (x != 21).mean() == pytest.approx(0.3, abs=5 * 0.5 / np.sqrt(N))


@pytest.mark.parametrize(("shape", "phi"), [("jumps", [5.0, 0.3]), ("hum", [5.0])])
def test_a_readout_that_jumps_or_hums_has_the_moments_of_that(shape, phi):
    effect = effect_of(Poisson(), "readout_noise", shape)
    phi = np.tile(phi, (N, 1))
    x = effect.apply(lambda theta, rng: np.full((N, 1), 100), phi, phi, rng())[:, 0]
    assert x.mean() == pytest.approx(100, abs=5 * x.std() / np.sqrt(N))
    if shape == "jumps":
        assert set(x) == {95, 100, 105}
        assert (x != 100).mean() == pytest.approx(0.3, abs=5 * 0.5 / np.sqrt(N))
    else:
        assert x.max() - 100 == 100 - x.min() == 7  # the crest of a sine wave of rms 5
        assert x.var() == pytest.approx(25 + 1 / 12, rel=0.02)
