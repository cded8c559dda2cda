from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from measurements import applied, entry, shape_of
from scipy.stats import norm, poisson

from avobench.bench import conformance as check
from avobench.bench.conformance import effects as suite
from avobench.bench.plugins import registry
from avobench.effects.catalogue import catalogue
from avobench.effects.continuous.comb import Comb
from avobench.effects.contract import Parameter
from avobench.effects.images.grid import odd_cells
from avobench.effects.noise import skewed_noise
from avobench.effects.ranges import Range, ends_sharply, ranges
from avobench.effects.rejection import DRAWN, accepted, must_record
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.errors import SimulatorError
from avobench.tasks.function import task as function_task
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


def effect_of(task, name, shape=None):
    return shape_of(entry(task, name), shape)


def events(task, effect, theta, phi, n=40_000, seed=0):
    rng = np.random.default_rng(seed)
    return effect.apply(task.simulate, np.tile(np.atleast_1d(theta), (n, 1)), np.tile(phi, (n, 1)), rng)


CHECKED = (
    "overdispersion double_counting heaping resolution edge_acceptance censoring second_exponential radiative_tail "
    "afterpulses:Afterpulses"
)
"""Of each way to act one or two, since every check simulates; of a family all classes; and an example of the docs."""


@pytest.mark.parametrize("name", CHECKED.split())
def test_effects_keep_their_contract(name, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "examples"))
    results = list(check.run("effect", name))
    assert [f"{r.what}: {r.why}" for r in results if not r.passed] == []
    assert len(results) > 5


@pytest.mark.parametrize("effect", catalogue(Weinberg()), ids=lambda effect: effect.name)
def test_every_shape_keeps_its_contract_on_a_cosine(effect):
    _, checks = suite.rounds(effect.name, [(Weinberg(), effect)])
    for what, check_one in checks:
        if "process" not in what:
            check_one()


def test_the_example_that_alters_a_stage_stops_its_share(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "examples"))
    task = Alignment(response="energy")  # of hits, two in one cell are one
    seen = [events(task, registry.effect("absorber:Absorber"), 0.0, [stopped], n=400).sum() for stopped in (0.0, 0.6)]
    assert seen[1] / seen[0] == pytest.approx(0.4, abs=0.03)


@pytest.mark.parametrize(
    ("name", "what", "why"),
    [
        ("Silent", "says what it is", "sentence must be text"),
        ("NoStage", "says what it is", "the stage must be a whole number from 0 to 5, got 7"),
        ("NoNull", "says what it is", "the strength rate has no null value"),
        ("OtherType", "makes events within its bounds", "returned float32 where int64 was due"),
        ("NeverAbsent", "changes nothing at its null value", "differ from the simulator's"),
        ("OfTheSecondRow", "gives each row its own parameters", "change when others are not"),
        ("OwnGenerator", "draws from its generator only", "does not repeat its events"),
        ("Unsendable", "can be sent to a worker process", "pickle"),
    ],
)
def test_a_faulty_effect_fails_on_what_it_breaks(monkeypatch, name, what, why):
    monkeypatch.setattr(suite, "TASKS", {"counts": ("poisson",)})
    faults = {r.what: r.why for r in check.run("effect", f"faulty_effects:{name}") if not r.passed}
    assert why in faults[f"{what} (poisson)"]


def test_a_users_effect_on_counts_keeps_the_contract_whatever_other_events_are():
    results = list(check.run("effect", "faulty_effects:Sound"))
    assert [f"{r.what}: {r.why}" for r in results if not r.passed] == []
    assert not any("alignment" in result.what for result in results)  # of its hits it makes other numbers


def test_parameter_refuses_a_null_outside_its_bounds():
    with pytest.raises(ValueError, match="outside its bounds"):
        Parameter("x", 0, 1, 2, "1")


def test_range_of_a_cosine_is_exact_and_its_folds_stay_within():
    (span,) = ranges(Weinberg())
    assert span == Range(-1.0, 1.0, True, sharp_low=True, sharp_high=True)
    np.testing.assert_allclose(span.reflect(np.array([-1.2, 0.3, 1.0, 1.5, 3.4])), [-0.8, 0.3, 1.0, 0.5, -0.6])
    assert not any(r.bounded for r in ranges(Carl()))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 40.0])
def test_each_end_of_a_range_is_the_end_where_it_is_sharp_and_a_quantile_where_not(scale):
    rng = np.random.default_rng(0)
    prior = {"lifetime": (scale, 2 * scale)}
    (span,) = ranges(function_task(lambda theta, rng: rng.exponential(theta), prior=prior, name="decays"))
    assert (span.low, span.sharp_low, span.sharp_high, span.bounded) == (0, True, False, False)
    times = rng.exponential(scale, 20_000)
    assert span.shown(times) == replace(span, high=np.quantile(times, 0.995))
    window = np.where(rng.random(20_000) < 0.04, rng.uniform(0, 12 * scale, 20_000), times)  # accidentals in a window
    seen = span.shown(window)
    assert seen.low == 0
    assert seen.high == pytest.approx(12 * scale, rel=0.01)
    assert not ends_sharply(rng.standard_normal(20_000))
    assert not ends_sharply(np.minimum(times, scale))  # a spike


@pytest.mark.parametrize(("rate", "tau"), [(5.0, 0.05), (30.0, 0.02), (2.0, 0.3)])
def test_dead_time_is_that_of_a_poisson_process(rate, tau):
    """P(k counts or more) = P(k pulses or more in what k - 1 dead times leave of the window); if lost pulses prolong
    it, the mean is that of pulses with no other in the dead time before them, which the first need not have."""
    task, n = Poisson(), 40_000
    never, always = (events(task, effect_of(task, "dead_time", "hybrid"), np.log(rate), [tau, p], n) for p in (0, 1))
    k = np.arange(1, 80)
    expected = poisson.sf(k - 1, rate * np.maximum(1 - (k - 1) * tau, 0))
    np.testing.assert_allclose((never >= k).mean(axis=0), expected, atol=5 * 0.5 / np.sqrt(n))
    mean = rate * (1 - tau) * np.exp(-rate * tau) - np.expm1(-rate * tau)
    assert always.mean() == pytest.approx(mean, abs=5 * always.std() / np.sqrt(n))
    for shape, same in (("non_paralysable", never), ("paralysable", always)):
        x = events(task, effect_of(task, "dead_time", shape), np.log(rate), [tau], n, seed=1)
        assert abs((x >= k).mean(axis=0) - (same >= k).mean(axis=0)).max() < 5 * 0.5 * np.sqrt(2 / n)


@pytest.mark.parametrize(("pulses", "tau", "counted"), [(5000, 0.0, 5000), (500, 0.0019, None), (500, 0.0021, 0)])
def test_a_counter_that_receives_far_too_much_counts_nothing(pulses, tau, counted):
    """More than 200 pulses, and 1 / tau, where ten counts at most are to be expected; unless it is never blind."""
    effect = effect_of(Poisson(), "dead_time").adapted(np.full((100, 1), 10))
    x = applied(effect, np.full((1000, 1), pulses), [tau])
    if counted is None:
        assert x.mean() == pytest.approx(pulses / (1 + pulses * tau), rel=0.01)
    else:
        assert (x == counted).all()


@pytest.mark.parametrize("skewness", [-2.0, -0.3, 0.0, 1.2])
def test_skewed_noise_has_the_stated_moments(skewness):
    """A share s of a centred exponential beside a Gaussian: excess kurtosis 6 s^4."""
    n = 400_000
    noise = skewed_noise(np.full(n, skewness), np.random.default_rng(0))
    assert noise.mean() == pytest.approx(0, abs=5 / np.sqrt(n))
    assert noise.std() == pytest.approx(1, abs=0.02)
    assert (noise**3).mean() == pytest.approx(skewness, abs=0.12)
    assert (noise**4).mean() - 3 == pytest.approx(6 * abs(skewness / 2) ** (4 / 3), abs=0.6)


@pytest.mark.parametrize("share", [0.1, 0.01])
def test_one_recorded_event_in_ten_is_waited_for_and_what_is_rarer_costs_no_more(share):
    drawn = []

    def simulate(theta, rng):
        drawn.append(len(theta))
        return rng.random((len(theta), 1))

    x = accepted(simulate, np.zeros((20_000, 1)), lambda x, rows: x[:, 0] < share, np.random.default_rng(0))
    assert sum(drawn) <= (DRAWN + 1) * len(x)
    assert (x < share).all()
    assert len(np.unique(x)) > 0.05 * len(x)


def test_a_limit_that_few_events_pass_is_that_of_each_row():
    """Of a standard normal one event in six to a thousand is beyond these limits, which all differ."""
    limits = np.linspace(1, 3, 2000)[:, None]

    def beyond(x, rows):
        return 1.0 * (x[:, 0] > limits[rows, 0])

    x = accepted(lambda theta, rng: rng.normal(size=theta.shape), limits, beyond, np.random.default_rng(0))
    assert (x > limits).all()
    assert x.mean() == pytest.approx((norm.pdf(limits) / norm.sf(limits)).mean(), abs=0.1)


def test_a_model_whose_detector_records_nothing_is_refused_and_a_fit_that_tries_it_goes_on():
    def simulate(theta, rng):
        return rng.random(theta.shape)

    blind = partial(accepted, simulate, np.zeros((3, 1)), lambda x, rows: 0 * x[:, 0], np.random.default_rng(0))
    assert blind().shape == (3, 1)
    with pytest.raises(SimulatorError, match="recorded"), must_record():
        blind()


@pytest.mark.parametrize(("shape", "phi"), [("cut", [1, 0.8]), ("window", [1, -0.7, 0.9])])
def test_a_fiducial_cut_is_sharp_and_changes_nothing_within(shape, phi):
    low, high = np.array([-0.8, 0.8]) if shape == "cut" else phi[1:]
    x = events(Weinberg(), effect_of(Weinberg(), "edge_acceptance", shape), [45.0, 1.0], phi, n=100_000)[:, 0]
    assert low - 0.01 < x.min() < low + 0.01
    assert high - 0.01 < x.max() < high + 0.01

    def below(c):  # no asymmetry: density 3/8 (1 + x^2)
        return c + c**3 / 3

    for c in (low / 2, 0.0, high / 2):
        assert np.mean(x < c) == pytest.approx((below(c) - below(low)) / (below(high) - below(low)), abs=0.008)


def test_an_edge_is_looked_for_where_events_lack():
    family = [effect for effect in catalogue(Weinberg()) if effect.name == "edge_acceptance"]
    shapes = {shape.shape: shape for effect in family for shape in effect.shapes()}
    beyond, inside = (0.8, 1.0), (-0.6, 0.9)
    assert shapes["cut"].within(*beyond, 0) == shapes["cut"].within(-1.0, -0.8, 0) == pytest.approx([0.8])
    assert shapes["cut"].within(*inside, 0) == pytest.approx([0.9])
    assert shapes["cut_low"].within(-1.0, -0.8, 0) == pytest.approx([0.8])
    assert shapes["cut_low"].within(*inside, 0) == pytest.approx([0.6])
    assert shapes["erf_low"].within(-1.0, -0.8, 0) == pytest.approx([-0.9, 0.1])
    assert shapes["exponential_high"].within(0.8, 1.0, 0) == pytest.approx([1.0, 0.2])
    assert shapes["rise_high"].within(0.8, 1.0, 0) == pytest.approx([0.2, 1.0])
    assert shapes["window"].within(*beyond, 0) == pytest.approx([-np.inf, 0.8])
    assert shapes["window"].within(-1.0, -0.8, 0) == pytest.approx([-0.8, np.inf])
    assert shapes["window"].within(*inside, 0) == pytest.approx(inside)
    assert shapes["power"].within(*beyond, 0) is None


def test_bounds_and_guesses_keep_to_the_counts():
    assert effect_of(Poisson(), "threshold_loss").adapted(np.full((10, 1), 7)).parameters[1].high == 7
    wide = effect_of(Poisson(), "quantisation", "16 down")
    assert len(wide.guess(np.random.default_rng(0).poisson(3, (100, 1)))) == 0


@given(st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_a_stuck_bit_is_never_what_it_should_be(bit, seed):
    x = np.random.default_rng(seed).poisson(9, (200, 1))
    for at, wrong in (("low", 1), ("high", 0)):
        if (bit, at) == (0, "low"):
            continue  # rounded down to even counts, a shape of its own
        stuck = effect_of(Poisson(), "quantisation", f"bit {bit} {at}")
        y = applied(stuck, x, [1])
        assert not (y >> bit & 1 == wrong).any()
        assert np.array_equal(y | 1 << bit, x | 1 << bit)
    assert np.array_equal(applied(stuck, x, [0]), x)


def test_quantisation_reads_its_step_off_the_data():
    task = Weinberg()
    for shape, at in (("nearest", 0), ("angle", 1)):
        effect = effect_of(task, "quantisation", shape)
        x = events(task, effect, [46.0, 1.0], [0.3, 0.05], n=3000)
        adapted = effect.adapted(x)
        assert adapted.steps[at] == pytest.approx(0.05, rel=1e-6)
        assert adapted.guess(x) is None
        low, high = adapted.parameters[1].low, adapted.parameters[1].high
        assert low < 0.05 < high < 1.00001 * low
    assert len(effect.guess(task.simulate(np.tile([46.0, 1.0], (3000, 1)), np.random.default_rng(0)))) == 0


def test_saturation_reads_its_limit_off_the_data():
    task = Weinberg()
    plain = task.simulate(np.tile([46.0, 1.0], (9000, 1)), np.random.default_rng(0))
    shown = [
        (shape, events(task, effect_of(task, "saturation", shape), [46.0, 1.0], [0.5, 0.6], n=3000), 0.6)
        for shape in ("above", "below", "both")
    ]
    for shape, x, at in (*shown, ("above", np.minimum(np.round(plain, 1), 0.75), 0.75)):
        limit = shape_of(effect_of(task, "saturation", shape).adapted(x), shape).parameters[1]
        assert limit.low < at < limit.high < 1.00001 * limit.low
    assert effect_of(task, "saturation", "both").adapted(plain).parameters[1].high == 1


def test_saturation_of_all_features_reads_the_limits_of_each_off_the_data():
    task = Carl()
    x = task.simulate(np.tile([0.1, -0.5], (5000, 1)), np.random.default_rng(0))
    both = shape_of(entry(task, "saturation", "all", x), "both")
    y = applied(both, x, [1.0, 0.6])
    again = both.adapted(y)
    assert applied(again, x, [1, np.mean([again.parameters[1].low, again.parameters[1].high])]) == pytest.approx(y)
    assert (x != y).any(axis=0).all()


def test_values_are_the_middles_of_their_bins_however_uneven():
    task = Weinberg()
    borders = np.array([0, 0.2, 0.5, 0.7, 1.3, 1.6, 1.8, 2.4, 2.6, 3.0, np.pi])
    angle = np.arccos(task.simulate(np.tile([46.0, 1.0], (4000, 1)), np.random.default_rng(0))[:, 0])
    into = np.searchsorted(borders, angle) - 1
    binned = np.cos((borders[:-1] + borders[1:])[into] / 2)
    adapted = effect_of(task, "quantisation").adapted(binned[:, None])
    levels = np.sort(np.arccos(adapted.levels))
    k = (len(levels) - 1) // 2
    share = (borders[k + 1] - levels[k]) / (levels[k + 1] - levels[k])
    x = np.cos(angle)[:, None]
    assert applied(shape_of(adapted, "bins_in_angle"), x, [1, share])[:, 0] == pytest.approx(binned, abs=1e-9)
    assert "bins" not in {s.shape for s in effect_of(task, "quantisation").adapted(x).shapes()}


@given(
    step=st.floats(0.02, 1.0),
    origin=st.floats(-0.5, 0.5),
    noise=st.floats(0.01, 0.15),
    share=st.floats(0.6, 1),
    seed=st.integers(0, 2**32 - 1),
)
def test_blurred_steps_are_read_off_their_spectrum(step, origin, noise, share, seed):
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(20_000)
    read = step * (np.rint(x / step - origin) + origin + noise * rng.standard_normal(len(x)))
    comb = Comb.shown(np.where(rng.random(len(x)) < share, read, x))
    assert comb is not None
    assert comb.step == pytest.approx(step, rel=5 * comb.error)
    off = (comb.origin - step * origin) / step
    assert off - np.rint(off) == pytest.approx(0, abs=0.02)
    assert comb.noise == pytest.approx(noise, abs=0.03)
    assert comb.share == pytest.approx(share, abs=0.1)


@given(st.sampled_from(["normal", "uniform", "standard_exponential", "standard_cauchy"]), st.integers(0, 2**32 - 1))
@example("uniform", 923100398)  # a side lobe of the sharp ends, with luck
def test_smooth_values_show_no_steps(kind, seed):
    assert Comb.shown(getattr(np.random.default_rng(seed), kind)(size=3000)) is None
    assert Comb.shown(np.full(10, 0.3)) is None


def test_steps_that_are_blurred_are_those_of_each_feature():
    task, rng = Carl(), np.random.default_rng(0)
    x = task.simulate(np.tile([0.1, -0.5], (20_000, 1)), rng)
    width = 0.3 * x.std(axis=0)
    read = width * (np.floor(x / width) + 0.5 + 0.05 * rng.standard_normal(x.shape))
    adapted = entry(task, "quantisation", "all", read).adapted(read)
    shape = shape_of(adapted, "blurred")
    (guess,) = shape.guess(read)
    again = applied(shape, x, [1, *guess[1:]])
    line = np.abs(np.exp(2j * np.pi * again / width).mean(axis=0))
    assert line == pytest.approx(np.exp(-2 * np.pi**2 * 0.05**2), abs=0.02)
    assert (np.abs(again - read) < 0.5 * width).mean() > 0.98
    assert np.array_equal(applied(shape, x, [0, *guess[1:]]), x)
    assert "blurred" not in {s.shape for s in adapted.adapted(x).shapes()}


def test_outliers_in_the_angle_stay_within_the_range():
    x = np.full((20_000, 1), np.cos(1.0))
    y = applied(effect_of(Weinberg(), "outliers", "angle"), x, [0.3, 0.4])
    moved = np.arccos(y[y != x])
    assert len(moved) / len(x) == pytest.approx(0.3, abs=0.02)
    assert (moved.mean(), moved.std()) == pytest.approx((1.0, 0.4), abs=0.03)


def test_a_background_event_is_one_in_all_features_and_as_wide_as_what_was_measured():
    task = Carl()
    x = task.simulate(np.tile([0.1, -0.5], (20_000, 1)), np.random.default_rng(0))
    y = applied(entry(task, "flat_background", "all").adapted(x), x, [0.2], seed=1)
    replaced = y != x
    assert (replaced.all(axis=1) | ~replaced.any(axis=1)).all()
    rows = replaced[:, 0]
    assert rows.mean() == pytest.approx(0.2, abs=0.01)
    low, high = np.quantile(x, [0.005, 0.995], axis=0)
    assert y[rows].min(axis=0) == pytest.approx(low, abs=0.02)
    assert y[rows].max(axis=0) == pytest.approx(high, abs=0.02)
    assert np.corrcoef(y[rows].T) == pytest.approx(np.eye(5), abs=0.06)


@given(place=st.floats(-0.8, 0.8), width=st.floats(0.02, 0.3))
def test_a_place_is_read_in_the_units_of_its_feature(place, width):
    for effect in (entry(Carl(), "dead_region", feature) for feature in (1, "all")):
        span = effect.ranges[1]
        low, high = (span.centre + span.half * (place + side * width / 2) for side in (-1, 1))
        phi = np.r_[1.0, effect.within(low, high, 1)]
        x = span.centre + span.half * np.linspace(-1, 1, 201)
        kept = effect.kept(x, span, np.tile(phi, (len(x), 1)))
        inside = (x > low + 1e-9) & (x < high - 1e-9)
        outside = (x < low - 1e-9) | (x > high + 1e-9)
        assert (kept[inside] == 0).all()
        assert (kept[outside] == 1).all()


def test_odd_cells_are_those_that_stand_out_even_where_next_to_none_is_expected():
    rng, grid, n = np.random.default_rng(0), (32, 32), 15_000
    rate = np.full(grid, 1.5 / n)  # one or two hits a cell: the largest of a thousand such counts is no odd cell
    rate[10:20] = 0.02
    x = rng.random((n, 1024)) < rate.ravel()
    assert len(odd_cells(x, grid, few=False)) == len(odd_cells(x, grid, few=True)) == 0
    noisy, dead = [5, 700], [400, 401]
    x[:, noisy] |= rng.random((n, 2)) < 0.02
    x[:, dead] = False
    assert odd_cells(x, grid, few=False).tolist() == noisy
    assert odd_cells(x, grid, few=True).tolist() == dead
