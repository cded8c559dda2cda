"""Effects on one feature that cut, censor, turn on, or add a tail: moments and distributions known exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from measurements import applied, shape_of
from scipy.stats import beta, crystalball, expon, kstest, lomax, norm

from avobench.effects.catalogue import catalogue
from avobench.effects.continuous.acceptance import (
    AnalysisWindow,
    DeadRegion,
    ForwardBackwardAcceptance,
    Truncation,
    TurnOn,
)
from avobench.effects.continuous.background import FlatBackground, PeakBackground, SecondExponential
from avobench.effects.continuous.ends import sharp_end
from avobench.effects.continuous.recording import Censoring, Quantisation, Saturation
from avobench.effects.continuous.response import ChargeMisid, Offset, Outliers, RadiativeTail, Resolution, Scale
from avobench.effects.model import Model
from avobench.effects.ranges import Range
from avobench.tasks.carl import Carl
from avobench.tasks.function import task

N = 40_000
LIFETIME = 2.0
WIDE, UNIT = Range(-4.0, 12.0, False), Range(0.0, 1.0, True)
CHANCE = 1e-6
"""With which a test of a distribution blames a sound effect."""


def decays(theta, rng):
    return LIFETIME * rng.standard_exponential((len(theta), 1))


def uniform(theta, rng):
    return rng.random((len(theta), 1))


def normal(theta, rng):
    return rng.standard_normal((len(theta), 1))


def made(effect, phi, simulate=decays, n=N, seed=0):
    return effect.apply(simulate, np.zeros((n, 1)), np.tile(phi, (n, 1)), np.random.default_rng(seed))[:, 0]


def shape(family, name, span=WIDE):
    return shape_of(family(0, (span,)), name)


def five_errors(x):
    return 5 * x.std() / np.sqrt(len(x))


@pytest.mark.parametrize("width", [0.3, 1.0, 4.0])
def test_a_turn_on_has_the_mean_that_its_curve_gives(width):
    """An exponential with an exponential turn-on is the sum of two; a normal with an erf is skew; a power on an even
    density is one."""
    x = made(shape(TurnOn, "exponential_low"), [1, 0, width])
    assert x.mean() == pytest.approx(LIFETIME + 1 / (1 / LIFETIME + 1 / width), abs=five_errors(x))
    for side, sign in (("low", 1), ("high", -1)):
        x = made(shape(TurnOn, f"erf_{side}"), [1, 0, width], normal)
        assert x.mean() == pytest.approx(sign * np.sqrt(2 / np.pi / (1 + width**2)), abs=five_errors(x))
    x = made(shape(TurnOn, "rise_low", UNIT), [1, 1, width], uniform)
    assert x.mean() == pytest.approx((width + 1) / (width + 2), abs=five_errors(x))


@given(place=st.floats(-0.5, 0.5), width=st.floats(0.05, 0.5), lost=st.floats(0.1, 1))
def test_of_a_turn_on_one_side_is_the_mirror_of_the_other(place, width, lost):
    span = Range(-1.0, 1.0, True)
    x, phi = np.linspace(-1, 1, 51), np.tile([lost, place, width], (51, 1))
    mirrored = phi * [1, -1, 1]
    for curve in ("erf", "exponential"):
        low = shape(TurnOn, f"{curve}_low", span).kept(x, span, phi)
        high = shape(TurnOn, f"{curve}_high", span).kept(-x, span, mirrored)
        np.testing.assert_allclose(low, high)
        assert (np.diff(low) >= 0).all()
        assert low.min() >= 1 - lost - 1e-12


@pytest.mark.parametrize(("side", "limit"), [("below", 1.3), ("above", 3.0)])
def test_truncation_leaves_what_is_within_its_limit_and_reads_it_off_the_data(side, limit):
    effect = shape(Truncation, f"truncated_{side}")
    x = made(effect, [limit])
    ends = (limit, np.inf) if side == "below" else (0, limit)
    low, high = expon.cdf(ends, scale=LIFETIME)
    assert kstest(x, lambda v: (expon.cdf(v, scale=LIFETIME) - low) / (high - low)).pvalue > CHANCE
    adapted = shape_of(effect.adapted(x[:, None]), effect.shape)
    (found,) = adapted.guess(x[:, None])
    assert found == pytest.approx([limit], abs=20 * LIFETIME / N)
    assert adapted.parameters[0].low < limit < adapted.parameters[0].high
    assert (adapted.guess(x[:, None]) == effect.guess(x[:, None])).all()


def test_at_the_end_of_the_range_a_limit_is_none():
    for effect in (*Truncation(0, (UNIT,)).shapes(), AnalysisWindow(0, (UNIT,))):
        null, *rest = effect.parameters
        phi = [null.null, *((p.low + p.high) / 2 for p in rest)]
        expected = normal(np.zeros((N, 1)), np.random.default_rng(0))[:, 0]
        np.testing.assert_array_equal(made(effect, phi, normal), expected)  # though the range is from 0 to 1


@pytest.mark.parametrize(("kind", "sharp"), [("uniform", True), ("normal", False), ("triangular", False)])
def test_an_end_is_sharp_where_the_density_is_a_step(kind, sharp):
    rng = np.random.default_rng(0)
    x = {"uniform": rng.random(N), "normal": rng.standard_normal(N), "triangular": rng.random((N, 2)).sum(axis=1)}[kind]
    for side in ("below", "above"):
        assert (sharp_end(x, side) is not None) == sharp
    assert sharp_end(np.round(x), "below") is None
    assert sharp_end(x[:30], "below") is None


@pytest.mark.parametrize(
    ("side", "limit", "value"), [("below", 0.7, 0.35), ("below", 0.7, 0.7), ("above", 3.0, 9.0), ("above", 3.0, 3.0)]
)
def test_censoring_records_one_value_for_all_beyond_and_names_both(side, limit, value):
    effect = shape(Censoring, f"censored_{side}")
    plain, x = (made(effect, [fraction, limit, value]) for fraction in (0, 1))
    beyond = plain < limit if side == "below" else plain > limit
    np.testing.assert_array_equal(x, np.where(beyond, value, plain))
    adapted = shape_of(effect.adapted(x[:, None]), effect.shape)
    _, at, spike = adapted.parameters
    assert spike.low < value < spike.high < spike.low + 1e-6
    assert at.low == pytest.approx(limit, abs=20 * LIFETIME / N)
    assert at.high < at.low + 1e-6
    assert adapted.guess(x[:, None]) is effect.guess(x[:, None]) is None
    for without in (plain, np.round(x, 1)):
        assert len(effect.guess(without[:, None])) == 0


def test_each_side_has_its_own_spike_and_no_limit_is_known_where_values_are_censored_in_part():
    part = Censoring(0, (WIDE,)).adapted(made(shape(Censoring, "censored_above"), [0.5, 3.0, 40.0])[:, None])
    assert (part.spikes, part.limits) == ((None, 40.0), (None, None))
    both = Censoring(0, (WIDE,)).adapted(np.clip(decays(np.empty(N), np.random.default_rng(0)), 0.5, 3.0))
    assert both.spikes == (0.5, 3.0)
    assert both.limits == pytest.approx((0.5, 3.0), abs=20 * LIFETIME / N)


def test_censoring_at_the_limit_is_a_saturation():
    saturated = made(shape(Saturation, "above"), [0.6, 0.5])  # half the range above its centre
    np.testing.assert_array_equal(saturated, made(shape(Censoring, "censored_above"), [0.6, 8.0, 8.0]))


@pytest.mark.parametrize(("side", "inner", "outer"), [("above", 3.0, 3.4), ("below", 0.7, 0.5)])
def test_of_two_limits_a_share_has_the_outer_one_and_the_data_show_both(side, inner, outer):
    plain = made(Offset(0, (WIDE,)), [0.0])
    beyond = plain > inner if side == "above" else plain < inner
    takes_outer = np.random.default_rng(1).random(N) < 0.3
    ends = np.where(takes_outer, outer, inner)
    x = np.minimum(plain, ends) if side == "above" else np.maximum(plain, ends)
    adapted = Censoring(0, (WIDE,)).adapted(x[:, None])
    assert adapted.two[side == "above"] == (inner, outer)
    assert adapted.two[side == "below"] == ()
    (effect,) = (one for one in adapted.shapes() if one.shape.startswith("two_limits"))
    assert effect.shape == f"two_limits_{side}"
    assert effect.guess(x[:, None]) is None
    np.testing.assert_array_equal(made(effect, [0.0, 0.3]), plain)
    y, far = made(effect, [1.0, 0.3]), np.mean(plain > outer if side == "above" else plain < outer)
    error = 5 * 0.5 / np.sqrt(N)
    assert (y == outer).mean() == pytest.approx(0.3 * far, abs=error)
    assert (y == inner).mean() == pytest.approx(0.7 * np.mean(beyond), abs=error)
    (again,) = (one for one in adapted.adapted(y[:, None]).shapes() if one.shape.startswith("two_limits"))
    assert again.two == effect.two
    assert not [s for s in adapted.adapted(plain[:, None]).shapes() if s.shape.startswith("two_limits")]


def test_a_window_acts_after_everything_else_whichever_was_added_first():
    masses = task(lambda theta, rng: 1.5 + rng.random(len(theta)), prior={"unused": (0, 1)}, name="masses")
    span = (Range(1.0, 3.0, False),)
    smearing, window = Resolution(0, span), AnalysisWindow(0, span)
    params = np.tile([0.5, 0.3, 1.0, 2.0], (N, 1))
    x = Model(masses, (smearing, window)).simulate(params, np.random.default_rng(0))[:, 0]
    other = Model(masses, (window, smearing)).simulate(params[:, [0, 2, 3, 1]], np.random.default_rng(0))[:, 0]
    np.testing.assert_array_equal(x, other)
    # a uniform with normal errors, cut where the uniform ends

    def below(v):
        u = (v - np.array([[1.5], [2.5]])) / 0.3
        return 0.3 * np.diff((u * norm.cdf(u) + norm.pdf(u))[::-1], axis=0)[0]

    ends = below(np.array([1.5, 2.5]))
    assert kstest(x, lambda v: (below(v) - ends[0]) / (ends[1] - ends[0])).pvalue > CHANCE
    adapted = window.adapted(x[:, None])
    assert adapted.guess(x[:, None])[0] == pytest.approx([1, 2], abs=1e-3)
    smeared = Model(masses, (smearing,)).simulate(params[:, :2], np.random.default_rng(0))
    assert window.adapted(smeared) == window
    assert len(window.guess(smeared)) == 0


@given(low=st.floats(-3, 5), width=st.floats(0.5, 8))
def test_the_window_of_any_data_is_within_its_bounds_and_can_be_absent(low, width):
    x = low + width * np.random.default_rng(0).random((2000, 1))
    effect = AnalysisWindow(0, (WIDE,)).adapted(x)
    phi = effect.guess(x)[0]
    for value, parameter in zip(phi, effect.parameters, strict=True):
        assert parameter.low < value < parameter.high
    wide, centre = effect.parameters
    for at in (centre.low, centre.high):
        assert at - wide.null / 2 <= min(WIDE.low, x.min())
        assert at + wide.null / 2 >= max(WIDE.high, x.max())


FROM_1_TO_7 = Range(1.0, 7.0, False, positive=True)
LAWS = [  # of events that are all at one value: the share that is moved, and where to
    (RadiativeTail, "exponential_below", WIDE, [0.3, 1.5], 0.0, 0.3, expon(scale=1.5), -1),
    (RadiativeTail, "exponential_above", WIDE, [0.3, 1.5], 0.0, 0.3, expon(scale=1.5), 1),
    (RadiativeTail, "power_below", WIDE, [0.3, 1.5], 0.0, 0.3, lomax(2, scale=1.5), -1),
    (RadiativeTail, "power_above", WIDE, [0.3, 1.5], 0.0, 0.3, lomax(2, scale=1.5), 1),
    (RadiativeTail, "radiator", FROM_1_TO_7, [0.2], 5.0, 1.0, beta(0.2, 1, loc=-5, scale=5), -1),  # a power is lost
    (SecondExponential, "falling", FROM_1_TO_7, [0.4, 0.8], 4.0, 0.4, expon(1, 0.8), 1),  # from the end of the range
    (SecondExponential, "rising", FROM_1_TO_7, [0.4, 0.8], 4.0, 0.4, expon(-7, 0.8), -1),
    (PeakBackground, "tail_below", WIDE, [0.9, 3.0, 0.5], 100.0, 0.9, crystalball(1, 3, 3, 0.5), 1),
    (PeakBackground, "tail_above", WIDE, [0.9, 3.0, 0.5], 100.0, 0.9, crystalball(1, 3, -3, 0.5), -1),
    (FlatBackground, "domed", WIDE, [0.95], 100.0, 0.95, beta(1.5, 1.5, loc=-4, scale=16), 1),  # a semicircle
]


@pytest.mark.parametrize(("family", "name", "span", "phi", "at", "share", "law", "sign"), LAWS)
def test_a_share_of_the_events_is_moved_to_where_a_law_says(family, name, span, phi, at, share, law, sign):
    x = applied(shape(family, name, span), np.full((N, 1), at), phi)
    new = x[x != at]
    assert len(new) / N == pytest.approx(share, abs=5 * np.sqrt(share * (1 - share) / N) + 1e-3)
    assert kstest(sign * new, law.cdf).pvalue > CHANCE


def test_an_offset_of_a_part_is_one_of_whole_events_and_one_that_creeps_has_the_mean_of_its_exponential():
    x, y = applied(shape_of(Offset("all", (WIDE, WIDE)), "part"), np.zeros((N, 2)), [3.0, 0.2]).T
    np.testing.assert_array_equal(x, y)
    assert set(x) == {0.0, 3.0}
    assert (x == 3).mean() == pytest.approx(0.2, abs=five_errors(x / 3))
    x = applied(shape(Offset, "creeping"), np.zeros((N, 1)), [-3.0, 0.5])
    assert x.mean() == pytest.approx(-3 * (1 - 0.5 * (1 - np.exp(-2))), abs=five_errors(x))


def test_a_needle_comes_back_from_its_stop():
    x = applied(shape(Saturation, "rebound"), np.full((N, 1), 11.0), [1.0, 0.5, 0.1])
    assert 8 - x.mean() == pytest.approx(0.1 * WIDE.half, rel=0.03)


def test_these_act_on_one_feature_only():
    families = (TurnOn, Truncation, Censoring, AnalysisWindow)
    found = [(type(e), e.feature) for e in catalogue(Carl()) if isinstance(e, families)]
    assert sorted(found, key=str) == sorted(((family, j) for family in families for j in range(5)), key=str)


@given(centre=st.floats(-1, 1), width=st.floats(0.02, 0.8), which=st.sampled_from(["one", "all"]))
def test_a_dead_region_has_events_on_both_sides(centre, width, which):
    """Wherever it is said to be, a fortieth of the range at either end is outside of it, and its width is the same."""
    span = Range(2.0, 6.0, True)
    scale = 1.0 if which == "all" else span.half  # of all features places are in half ranges
    effect = DeadRegion(0 if which == "one" else "all", (span,), "box")
    x = np.linspace(span.low, span.high, 4001)
    at = centre if which == "all" else span.centre + span.half * centre
    kept = effect.kept(x, span, np.tile([1.0, at, width * scale], (len(x), 1)))
    ends = np.abs(span.unit(x)) > 1 - 0.05 + 1e-9
    assert (kept[ends] == 1).all()
    assert (kept == 0).mean() == pytest.approx(width / 2, abs=2 / 4000)


def test_a_dead_region_of_an_angle_may_lie_where_that_comes_round_again():
    once = Range(0.0, 2 * np.pi, False, periodic=True)
    x = np.array([0.01, 1.0, 6.0])
    kept = DeadRegion(0, (once,), "box").kept(x, once, np.tile([1.0, 0.0, 0.5], (3, 1)))
    assert kept.tolist() == [0, 1, 1]


@given(asymmetry=st.floats(-0.95, 0.95), power=st.floats(0.3, 3))
def test_a_growing_acceptance_loses_on_one_side_alone_and_most_at_its_end(asymmetry, power):
    span = Range(-1.0, 1.0, True)
    x, phi = np.linspace(-1, 1, 81), np.tile([asymmetry, power], (81, 1))
    kept = shape(ForwardBackwardAcceptance, "growing", span).kept(x, span, phi)
    side = np.sign(asymmetry) * x
    assert kept[side >= 0] == pytest.approx(1)
    worse = kept[np.argsort(side)][: (side < 0).sum()]
    assert (np.diff(worse) >= 0).all()
    assert kept.min() == pytest.approx((1 - abs(asymmetry)) / (1 + abs(asymmetry)))
    half = np.argmin(np.abs(side + 0.5))  # lost there: so much less as the power says
    assert 1 - kept[half] == pytest.approx((1 - kept.min()) * 0.5**power)


AT = np.array([-8.0, -4, 0, 4, 8, 12, 16])
EXACT = [  # the range is from -4 to 12, with 4 at its centre
    (Scale, "bowed", [0.2], AT + 0.2 * (AT - 4) * np.maximum(1 - ((AT - 4) / 8) ** 2, 0)),
    (Scale, "bowed_low", [0.2, 0.5], AT + np.array([0, 0, 0.2 * 0.5 * -4 * 0.75, 0, 0.2 * 4 * 0.75, 0, 0])),
    (Scale, "above", [0.2, 2.0], np.where(AT > 2, AT + 0.2 * (AT - 2), AT)),
    (Scale, "below", [0.2, 2.0], np.where(AT < 2, AT + 0.2 * (AT - 2), AT)),
    (Scale, "two_gains_low", [-0.3, 0.4], 4 + (AT - 4) * np.where(AT < 4, 1 - 0.12, 0.7)),
    (Scale, "two_gains_high", [0.3, 0.4], 4 + (AT - 4) * np.where(AT > 4, 1.12, 1.3)),
    (Scale, "cubic", [0.3], AT * (1 + 0.3 * (AT / 12) ** 2)),  # in units of the largest magnitude in the range
    (Saturation, "knee", [4.0, 0.5], np.where(AT > 8, 8 + (AT - 8) / (1 + 4 * (AT - 8) / 8), AT)),
    (Saturation, "knee_below", [4.0, 0.5], np.where(AT < 0, AT / (1 + 4 * -AT / 8), AT)),
    (Saturation, "soft", [2.0], 4 + (AT - 4) / np.sqrt(1 + (2 * (AT - 4) / 8) ** 2)),
    (Saturation, "both", [1.0, 0.5], AT.clip(0, 8)),
]


@pytest.mark.parametrize(("family", "name", "phi", "expected"), EXACT)
def test_a_response_without_chance_is_exact_and_can_be_absent(family, name, phi, expected):
    effect = shape(family, name)
    for values, result in ((phi, expected), ([effect.parameters[0].null, *phi[1:]], AT)):
        np.testing.assert_allclose(applied(effect, AT[:, None], values)[:, 0], result, atol=1e-12)


def test_of_an_event_all_features_may_be_far_off_together():
    spans = (WIDE, UNIT)
    x = applied(shape_of(Outliers("all", spans), "above together"), np.zeros((N, 2)), [0.1, 2.0])
    assert ((x[:, 0] > 0) == (x[:, 1] > 0)).all()
    assert (x[:, 0] > 0).mean() == pytest.approx(0.1, abs=5 * 0.3 / np.sqrt(N))
    assert np.corrcoef(x[x[:, 0] > 0].T)[0, 1] == pytest.approx(0, abs=0.1)
    np.testing.assert_allclose(x[x[:, 0] > 0].mean(axis=0), [2 * WIDE.half, 2 * UNIT.half], rtol=0.1)
    assert not any("together" in s.shape for s in Outliers(0, spans).shapes())


@pytest.mark.parametrize(("sign", "name"), [(1, "of_positive"), (-1, "of_negative")])
def test_the_sign_of_one_half_alone_may_be_lost(sign, name):
    at = sign * np.r_[np.full(N // 2, 3.0), np.full(N // 2, -2.0)]
    x = applied(shape(ChargeMisid, name), at[:, None], [0.3])[:, 0]
    np.testing.assert_array_equal(x[N // 2 :], at[N // 2 :])
    assert (x[: N // 2] != at[: N // 2]).mean() == pytest.approx(0.3, abs=5 * 0.5 / np.sqrt(N / 2))


@pytest.mark.parametrize(("name", "far"), [("rising", 8.0), ("falling", 0.0)])
def test_a_smearing_may_grow_from_one_end_to_the_other(name, far):
    for at in (far, 4.0):
        x = applied(shape(Resolution, name), np.full((N, 1), at), [2.0])
        share = (at + 4) / 16 if name == "rising" else (12 - at) / 16
        assert x.std() == pytest.approx(2 * np.sqrt(share), rel=5 / np.sqrt(2 * N))


@given(st.floats(0.05, 0.6), st.floats(-0.3, 0.3))
@settings(max_examples=20)
def test_values_of_few_digits_are_read_in_steps_that_grow_with_them(step, off):
    """The logarithm of the size is rounded; the border between two values then lies below the middle."""
    x = np.random.default_rng(0).normal(4, 8, 20_000)
    unit = np.log1p(step)
    measured = np.sign(x) * np.exp(unit * (np.rint(np.log(np.abs(x)) / unit + off) - off))
    effect = shape_of(Quantisation(0, (WIDE,)).adapted(measured[:, None]), "by_size")
    border = (np.sqrt(1 + step) - 1) / step
    read = applied(effect, x[:, None], [1.0, border])[:, 0]
    levels = np.array(effect.levels)
    inside = (np.abs(x) > 2 * np.abs(levels).min()) & (x > levels[0]) & (x < levels[-1])
    assert np.isclose(read, measured)[inside].mean() > 0.98
