"""The effects that a challenge hides: what they do to distributions whose moments are known."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from avobench.bench.plugins import registry
from avobench.challenge.shapes import FAMILIES, SERIES, Place, second, shapes
from avobench.challenge.shapes.first import (
    acceptance,
    backgrounds,
    converter,
    counting,
    distortion,
    images,
    intervals,
    smearing,
    tracker,
)
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

N = 40_000
COUNTS = {"zero_inflation", "overdispersion", "dead_time", "threshold_loss", "flat_background", "double_counting"}
COUNTS |= {"readout_noise", "quantisation", "pile_up", "inefficiency"}
CONTINUOUS = {"resolution", "offset", "scale", "edge_acceptance", "forward_backward_acceptance", "flat_background"}
CONTINUOUS |= {"peak_background", "dead_region", "charge_misid", "outliers", "crosstalk", "quantisation", "saturation"}
IMAGES = {"dead_cells", "noisy_cells", "inefficiency", "random_noise", "pile_up", "transverse_offset", "axial_tilt"}
IMAGES |= {"threshold"}


def place(task, theta, feature=None, n=N):
    at = np.tile(np.array(theta, float), (n, 1))
    return Place(task, feature, task.simulate(at, np.random.default_rng(99))), at


def measured(injection, at, seed=0):
    return injection.measure(injection.place.task.simulate, at, np.random.default_rng(seed))


def drawn(shape, where, seed=0, **fixed):
    return replace(shape.draw(where, np.random.default_rng(seed)), **fixed)


LAMBDA = 6.0
WHERE = {
    "poisson": place(Poisson(), [np.log(LAMBDA)]),
    "weinberg": place(Weinberg(), [44, 1], 0),
    "carl": place(Carl(), [0.5, -0.5], 1),
    "carl, all features": place(Carl(), [0.5, -0.5], "all"),
}
EVERY = [(name, shape) for name, (where, _) in WHERE.items() for shape in shapes(where, tuple(SERIES))]


@pytest.mark.parametrize("series", [1, 2])
def test_every_family_of_the_catalogue_has_a_foreign_shape(series):
    names = {kind: {shape.name for shape in family if shape.series == series} for kind, family in FAMILIES.items()}
    assert names == {"counts": COUNTS, "continuous": CONTINUOUS, "images": IMAGES}


@pytest.mark.parametrize(("name", "shape"), EVERY, ids=[f"{name}-{shape.__name__}" for name, shape in EVERY])
def test_an_injection_keeps_shape_type_and_seed_and_changes_something(name, shape):
    where, at = WHERE[name]
    injection = drawn(shape, where, 3)
    x, same, other = (measured(injection, at, seed) for seed in (1, 1, 2))
    assert x.shape == (N, where.task.num_features)
    assert x.dtype == where.task.dtype
    np.testing.assert_array_equal(x, same)
    assert (x != other).any()
    assert np.isfinite(x).all()
    assert injection.settings["strength"] != 0
    assert injection.__doc__
    assert injection.source
    plain = where.task.simulate(at, np.random.default_rng(1))
    assert (x != plain).any()
    untouched = [column for column in range(x.shape[1]) if column not in where.columns]
    if injection.stage != 3:  # a selection exchanges whole events
        np.testing.assert_array_equal(x[:, untouched], plain[:, untouched])


def moments(x):
    return x.mean(), x.var(), 5 * x.std() / np.sqrt(len(x))


def test_the_answers_know_shapes_by_their_series_and_names():
    names = [(shape.series, shape.__name__) for family in FAMILIES.values() for shape in family]
    assert len(set(names)) == len(names)


VARYING = [intervals.TwoIntensities, intervals.LognormalRate, intervals.Oscillation]
VARYING += [second.counts.Flares, second.counts.DecayingSource]


@pytest.mark.parametrize("shape", VARYING)
def test_a_varying_rate_keeps_the_mean_and_adds_its_variance(shape):
    where, at = WHERE["poisson"]
    mean, variance, error = moments(measured(drawn(shape, where, strength=0.3), at))
    assert mean == pytest.approx(LAMBDA, abs=error)
    assert variance == pytest.approx(LAMBDA + (0.3 * LAMBDA) ** 2, rel=0.05)


def test_pulses_are_lost_to_dead_time_as_the_formulas_say():
    where, at = WHERE["poisson"]
    tau = 0.02
    blind = measured(drawn(counting.HybridDeadTime, where, strength=tau, paralysis=0.0), at).mean()
    paralysed = measured(drawn(counting.HybridDeadTime, where, strength=tau, paralysis=1.0), at).mean()
    # of n pulses in one interval, those at less than tau after another; the first tau of an interval is never blind
    assert paralysed == pytest.approx(LAMBDA * np.exp(-LAMBDA * tau), abs=0.06)
    assert blind == pytest.approx(LAMBDA / (1 + LAMBDA * tau), abs=0.08)
    assert blind > paralysed


def test_false_pulses_and_intervals_add_what_they_should():
    where, at = WHERE["poisson"]
    mean, variance, error = moments(measured(drawn(counting.Afterpulses, where, strength=0.2, chain=0.0), at))
    assert mean == pytest.approx(LAMBDA * 1.2, abs=error)
    assert variance == pytest.approx(LAMBDA * (1 + 3 * 0.2), rel=0.05)
    mean, _, error = moments(measured(drawn(counting.LateReset, where, strength=0.2, least=1.0), at))
    assert mean == pytest.approx(LAMBDA * 1.2, abs=error)
    mean, _, error = moments(measured(drawn(counting.UnevenPileUp, where, strength=0.1, variation=0.1), at))
    assert mean == pytest.approx(LAMBDA * 1.1, abs=error + 0.01)
    mean, _, error = moments(measured(drawn(counting.UnevenInefficiency, where, strength=0.1, variation=0.1), at))
    assert mean == pytest.approx(LAMBDA * 0.9, abs=error)


def test_blanked_and_replaced_intervals_have_the_share_asked_for():
    where, at = WHERE["poisson"]
    x = measured(drawn(intervals.Trips, where, strength=0.2, partial=0.0), at)
    assert (x == 0).mean() == pytest.approx(0.2 + 0.8 * np.exp(-LAMBDA), abs=0.01)
    x = measured(drawn(intervals.Discharges, where, strength=0.1, rate_power=1.0), at)
    assert (x == 0).mean() == pytest.approx(0.1, abs=0.01)
    x = measured(drawn(intervals.StrayIntervals, where, strength=0.3, slope=0.0, end=1.0), at)
    high = np.quantile(where.reference, 0.999)
    assert (x > high * 0.9).mean() == pytest.approx(0.3 * 0.1, abs=0.02)


def test_counter_readouts():
    where, at = WHERE["poisson"]
    x = measured(drawn(converter.StuckBit, where, strength=1.0, bit=0.5), at)
    assert (x % 2 == 0).all()
    x = measured(drawn(converter.CoarseRange, where, strength=0.5, step=4.9), at)
    knee = np.quantile(where.reference, 0.5)
    assert (x[x >= knee + 3] % 4 == 0).all()
    assert (x[x < 4] % 4 != 0).any()
    for shape in (converter.LandauNoise, converter.LaplaceNoise):
        x = measured(drawn(shape, where, strength=0.5), at)
        assert x.min() == 0
        assert x.var() == pytest.approx(LAMBDA * (1 + 0.25), rel=0.08)
    x = measured(drawn(intervals.SoftTrigger, where, strength=0.5, width=0.2), at)
    assert (x <= 3).mean() < 0.01 < (where.reference <= 3).mean()


def test_angles_are_turned_stretched_and_smeared_as_angles():
    where, at = WHERE["weinberg"]
    angle = np.arccos(where.reference)
    x = measured(drawn(smearing.TurnedAxis, where, strength=0.05, drift=0.0), at)
    error = 5 * 0.62 * np.sqrt(2 / N)
    assert x.mean() == pytest.approx(np.cos(angle + 0.05).mean(), abs=error)
    x = measured(drawn(smearing.AngularScale, where, strength=0.1, drift=0.0), at)
    assert x.var() == pytest.approx(np.cos(np.pi / 2 + 1.1 * (angle - np.pi / 2)).var(), rel=0.03)
    x = measured(drawn(smearing.AngularSmearing, where, strength=0.3, tail_share=0.0), at)
    assert x.mean() == pytest.approx(np.exp(-(0.3**2) / 2) * where.reference.mean(), abs=error)
    for shape in shapes(where):
        assert np.abs(measured(drawn(shape, where, 5), at[:5000])).max() <= 1


@pytest.mark.parametrize("shape", [smearing.DoubleGaussian, smearing.SkewedSmearing])
def test_smearing_on_a_line_keeps_the_mean_and_adds_its_variance(shape):
    where, at = WHERE["carl"]
    injection = drawn(shape, where, strength=0.5)
    added = (measured(injection, at) - where.task.simulate(at, np.random.default_rng(0)))[:, 1] / where.std
    tails = injection.settings.get("tail_share", 0) * (injection.settings.get("tail_width", 1) ** 2 - 1)
    assert added.mean() == pytest.approx(0, abs=5 * added.std() / np.sqrt(N))
    assert added.var() == pytest.approx(0.25 * (1 + tails), rel=0.05)


def test_offset_and_scale_on_a_line():
    where, at = WHERE["carl"]
    plain = where.task.simulate(at, np.random.default_rng(0))[:, 1]
    moved = measured(drawn(smearing.DriftingOffset, where, strength=-0.3), at)[:, 1] - plain
    assert moved.mean() == pytest.approx(-0.3 * where.std[0], rel=0.01)
    scaled = measured(drawn(smearing.BentGain, where, strength=0.1, bend=0.0, drift=0.0), at)[:, 1]
    np.testing.assert_allclose(scaled, 1.1 * plain)


def test_acceptances_lose_what_they_should():
    where, at = WHERE["weinberg"]
    selections = [acceptance.ErfTurnOn, acceptance.BeamPipe, acceptance.TwoHalves, acceptance.FadingSide]
    selections += [second.continuous.LayersMissed, second.continuous.AttenuatedLight, second.continuous.TaperedGap]
    for shape in selections:
        injection = drawn(shape, where, 2, strength=0.4)
        efficiency = injection.efficiency(where.reference)
        assert ((efficiency >= 0) & (efficiency <= 1)).all()
        expected = (efficiency * where.reference[:, 0] ** 2).mean() / efficiency.mean()
        assert (measured(injection, at) ** 2).mean() == pytest.approx(expected, abs=0.01)
    gap = drawn(acceptance.SoftGap, where, strength=0.1, location=0.3, residual=0.0, side=0.1)
    x = measured(gap, at)
    assert ((x > 0.25) & (x < 0.35)).mean() == 0


def test_an_acceptance_that_keeps_nothing_is_told(monkeypatch):
    where, at = WHERE["weinberg"]
    monkeypatch.setattr(acceptance.SoftGap, "efficiency", lambda self, x: np.zeros(len(x)))
    with pytest.raises(ValueError, match="keeps next to no event"):
        measured(drawn(acceptance.SoftGap, where), at[:3])


def test_backgrounds_have_their_density():
    where, _ = WHERE["weinberg"]
    rng = np.random.default_rng(0)
    flat = drawn(backgrounds.NearlyFlat, where, slope=0.2, curvature=0.3).foreign(N, rng)
    assert flat.mean() == pytest.approx(0.2 / 3, abs=0.02)
    assert (flat**2).mean() == pytest.approx(1 / 3 + 0.3 * 2 / 15, abs=0.01)
    for shape in (backgrounds.BreitWigner, backgrounds.RadiativePeak):
        peak = drawn(shape, where, location=0.4).foreign(N, rng)
        assert np.abs(peak).max() <= 1
        assert np.median(peak) == pytest.approx(0.4, abs=0.1)
    soft = drawn(backgrounds.SoftEnded, WHERE["carl"][0], slope=0.0).foreign(N, rng)
    assert soft.mean() == pytest.approx(WHERE["carl"][0].centre[0], abs=0.1)


def test_distortions_do_what_they_say():
    where, at = WHERE["carl"]
    plain = where.task.simulate(at, np.random.default_rng(0))[:, 1]
    flipped = measured(drawn(distortion.StraightTracks, where, strength=0.1, rise=0.0), at)[:, 1]
    assert (flipped == -plain).mean() == pytest.approx(0.1, abs=0.01)
    for shape in (distortion.StudentTails, distortion.LandauTails):
        assert (measured(drawn(shape, where, strength=0.1), at)[:, 1] != plain).mean() == pytest.approx(0.1, abs=0.01)
    step = 0.5 * where.std[0]
    cut = measured(drawn(distortion.TruncatingReadout, where, strength=0.5, noise=0.0), at)[:, 1]
    np.testing.assert_allclose(cut, step * (np.floor(plain / step) + 0.5))
    soft = measured(drawn(distortion.SoftSaturation, where, strength=0.2, headroom=0.3), at)[:, 1]
    knee = np.quantile(where.reference[:, 1], 0.8)
    np.testing.assert_array_equal(soft[plain <= knee], plain[plain <= knee])
    assert (soft[plain > knee] < plain[plain > knee]).all()
    assert soft.max() <= knee + 0.3 * where.std[0]
    one = drawn(distortion.RectifiedCrosstalk, where, neighbour=0.99, strength=0.2)
    leaked = measured(one, at)[:, 1] - plain
    other = where.task.simulate(at, np.random.default_rng(0))[:, 4]
    assert np.corrcoef(leaked, other)[0, 1] > 0.9
    x = measured(drawn(distortion.Segments, WHERE["weinberg"][0], strength=0.2), WHERE["weinberg"][1])
    assert len(np.unique(x)) < 20


L = LAMBDA
MOMENTS = [
    (second.counts.LeakyShutter, {"strength": 0.2, "dark": 0.5}, 0.8 * L + 0.1, 0.8 * L + 0.1 + 0.16 * (L - 0.5) ** 2),
    (second.counts.Ringing, {"strength": 0.2, "evenness": 3.0}, 1.2 * L, 1.6 * L + 0.04 * L**2),
    (second.counts.MainsHum, {"strength": 0.5, "hum": 1.0}, L, 1.25 * L + 1 / 12),
    (second.counts.PrescaledScaler, {"strength": 1.0, "step": 4.5}, L, L + 2.5),
    (second.counts.PulsedBeam, {"strength": 0.3, "duty": 0.6}, 1.3 * L, 1.3 * L + (0.3 * L) ** 2 * (1 / 0.6 - 1)),
    (second.counts.ChannelsOff, {"strength": 0.3, "channels": 20.0}, 0.7 * L, 0.7 * L + 0.21 * L**2 / 20),
]


@pytest.mark.parametrize(("shape", "fixed", "mean", "variance"), MOMENTS, ids=[each[0].__name__ for each in MOMENTS])
def test_counts_of_the_second_series_have_their_moments(shape, fixed, mean, variance):
    where, at = WHERE["poisson"]
    x = measured(drawn(shape, where, **fixed), at)
    assert x.min() >= 0
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N) + 0.02)  # the reference's mean errs too
    assert x.var() == pytest.approx(variance, rel=0.05)


@pytest.mark.parametrize(("slots", "lost"), [(1.0, 0.8 / 1.8), (2.0, 0.32 / 2.12)])
@pytest.mark.parametrize("spread", [0.3, 1.0])
def test_a_buffer_loses_what_erlang_says_however_the_times_in_it_spread(slots, lost, spread):
    where, at = place(Poisson(), [np.log(40)], n=5000)
    buffer = drawn(second.counts.ReadoutBuffer, where, strength=0.02, slots=slots, spread=spread)
    share = measured(buffer, at).mean() / 40
    assert share == pytest.approx(1 - lost, abs=0.03)  # the buffer is empty when an interval begins


def test_a_prescaled_trigger_and_a_swept_pulser():
    where, _ = WHERE["poisson"]
    trigger = drawn(second.counts.PrescaledTrigger, where, strength=0.4, below=0.5)
    efficiency = trigger.efficiency(np.arange(30)[:, None])
    assert efficiency[0] == pytest.approx(0.6)
    assert efficiency[-1] == pytest.approx(1, abs=1e-6)
    assert (np.diff(efficiency) >= 0).all()
    sweep = drawn(second.counts.SweptPulser, where, end=1.0).foreign(N, np.random.default_rng(0))
    highest = np.quantile(where.reference, 0.999)
    assert sweep.mean() == pytest.approx(highest / 2, rel=0.02)
    assert sweep.var() == pytest.approx(highest / 2 + highest**2 / 12, rel=0.03)


def test_angles_of_the_second_series():
    where, at = WHERE["weinberg"]
    plain = where.task.simulate(at, np.random.default_rng(0))
    slope = lambda x: x / np.sqrt(1 - x**2)  # noqa: E731
    moved = measured(drawn(second.continuous.DisplacedVertex, where, strength=0.1, bunch=0.0), at)
    np.testing.assert_allclose(slope(moved), slope(plain) + 0.1, rtol=1e-6)
    longer = measured(drawn(second.continuous.StretchedBarrel, where, strength=0.1, sides=0.0), at)
    np.testing.assert_allclose(slope(longer), 1.1 * slope(plain), rtol=1e-6)
    towers = np.arctanh(measured(drawn(second.continuous.EtaTowers, where, strength=0.4), at))
    assert np.abs(towers - np.arctanh(plain)).max() <= 0.2 + 1e-6
    apart = np.diff(np.unique(towers.round(6))) / 0.4
    np.testing.assert_allclose(apart, np.rint(apart), atol=1e-4)
    error = 5 * np.sqrt(2 / N)
    scattered = measured(drawn(second.continuous.NuclearScattering, where, strength=0.3, mean=1.0), at)
    assert scattered.mean() == pytest.approx((0.7 + 0.3 / 2) * plain.mean(), abs=error)
    blurred = measured(drawn(second.continuous.SlantedMaterial, where, strength=0.3, power=1.0), at)
    damped = np.exp(-(0.3**2) / 2 / np.maximum(1 - plain**2, 0.05**2))
    assert blurred.mean() == pytest.approx((damped * plain).mean(), abs=error)


def test_values_of_the_second_series_on_a_line():
    where, at = WHERE["carl"]
    every = where.task.simulate(at, np.random.default_rng(0))
    plain, std = every[:, 1], where.std[0]
    of = lambda shape, **fixed: measured(drawn(shape, where, **fixed), at)[:, 1]  # noqa: E731
    blur = (of(second.continuous.StochasticTerm, strength=0.5, growth=1.0) - plain) / std
    assert blur.mean() == pytest.approx(0, abs=5 * blur.std() / np.sqrt(N))
    assert blur.var() == pytest.approx(0.25 * (1 + np.abs(plain / std).mean()), rel=0.05)
    jump = of(second.continuous.PedestalStep, strength=-0.3, after=0.6) - plain
    assert (jump != 0).mean() == pytest.approx(0.6, abs=0.02)
    np.testing.assert_allclose(jump[jump != 0], -0.3 * std)
    gain = of(second.continuous.LogarithmicGain, strength=0.2, slope=0.3) / plain
    np.testing.assert_allclose(gain, 1.2 + 0.06 * np.log(np.clip(np.abs(plain) / std, 0.1, 10)))
    flipped = of(second.continuous.BitFlips, strength=0.1, lowest=1.0) - plain
    assert (flipped != 0).mean() == pytest.approx(0.1, abs=0.01)
    assert set(np.abs(flipped[flipped != 0] / std).round(6)) == {1, 2, 4}
    cut = of(second.continuous.LogarithmicConverter, strength=0.2, linear=0.5)
    assert len(np.unique(cut)) < 60
    assert (np.abs(cut - plain) <= 0.12 * np.hypot(plain, 0.5 * std) + 1e-9).all()
    clipped = of(second.continuous.UnsteadyRail, strength=0.2)
    assert (clipped <= plain).all()
    assert 0.1 < (clipped < plain).mean() < 0.4
    signs = of(second.continuous.LopsidedFlips, strength=0.1, preference=0.5)
    assert set(np.unique(signs / plain)) == {-1, 1}
    assert (signs != plain)[plain > 0].mean() == pytest.approx(0.15, abs=0.015)
    assert (signs != plain)[plain < 0].mean() == pytest.approx(0.05, abs=0.015)
    leak = of(second.continuous.TwoNeighbours, strength=0.2, other_side=0.5) - plain
    scaled = every / where.reference.std(axis=0)
    np.testing.assert_allclose(leak, 0.2 * std * (scaled[:, 0] + 0.5 * scaled[:, 2]))


def test_losses_and_backgrounds_of_the_second_series_lie_where_they_should():
    where, _ = WHERE["weinberg"]
    grid = np.linspace(-1, 1, 201)[:, None]
    steps = drawn(second.continuous.LayersMissed, where, strength=0.6, begin=0.7, layers=3.5).efficiency(grid)
    np.testing.assert_allclose(np.unique(steps.round(9)), [0.4, 0.6, 0.8, 1])
    assert (steps[np.abs(grid[:, 0]) < 0.7] == 1).all()
    fading = drawn(second.continuous.AttenuatedLight, where, strength=0.6, length=0.5).efficiency(grid)
    np.testing.assert_allclose(1 - fading, 0.6 * np.exp((grid[:, 0] - 1) / 0.5))
    gap = drawn(second.continuous.TaperedGap, where, strength=0.2, location=0.3, depth=0.8).efficiency(grid)
    assert gap.mean() == pytest.approx(1 - 0.8 * 0.2 / 2, abs=1e-3)
    assert (gap < 1).mean() == pytest.approx(0.2, abs=0.01)
    rng = np.random.default_rng(0)
    peak = drawn(second.continuous.JacobianPeak, where, edge=0.3, tail=0.2).foreign(N, rng)
    assert (peak.min(), peak.max()) == (pytest.approx(0.1, abs=0.01), pytest.approx(0.3))
    assert peak.mean() == pytest.approx(0.1 + 0.2 * np.pi / 4, abs=0.002)
    flat = drawn(second.continuous.UnevenNoise, where, channels=8.0, spread=0.0).foreign(N, rng)
    assert (flat.mean(), flat.var()) == (pytest.approx(0, abs=0.02), pytest.approx(1 / 3, abs=0.01))
    assert np.abs(flat).max() <= 1


@pytest.fixture(scope="module")
def collisions():
    task = Alignment()
    (particles,) = task.generate(500, np.random.default_rng(0))
    theta = np.full((500, 1), 0.4)
    return Place(task, None, task.detect(particles, theta)), particles, theta


def test_a_detector_turned_upside_down_sees_the_mirrored_image(collisions):
    where, particles, theta = collisions
    turned = drawn(tracker.TiltedDetector, where, strength=np.pi, azimuth=0.0)
    image = turned.detect(where.task, particles, theta, np.random.default_rng(0)).reshape(-1, 32, 32)
    assert (image == where.reference.reshape(-1, 32, 32)[:, ::-1, ::-1]).mean() > 0.9999
    same = drawn(tracker.TiltedDetector, where, strength=0.0).detect(where.task, particles, theta, None)
    np.testing.assert_array_equal(same, where.reference)


def test_a_moved_beam_gathers_hits_on_its_side(collisions):
    where, particles, theta = collisions
    moved = drawn(tracker.MovedBeam, where, strength=1.0, azimuth=0.0)
    columns = moved.detect(where.task, particles, theta, None).reshape(-1, 32, 32).sum(axis=(0, 1))
    near, far = columns[[*range(4), *range(28, 32)]].sum(), columns[12:20].sum()
    assert near > 1.2 * far
    still = drawn(tracker.MovedBeam, where, strength=0.0)
    np.testing.assert_array_equal(still.detect(where.task, particles, theta, None), where.reference)


def test_a_momentum_threshold_only_loses_hits(collisions):
    where, particles, theta = collisions
    seen = drawn(tracker.SoftParticles, where, strength=0.5).detect(
        where.task, particles, theta, np.random.default_rng(0)
    )
    assert (seen <= where.reference).all()
    assert 0.5 < seen.sum() / where.reference.sum() < 0.95


def test_cells_fail_and_fire_at_the_rates_asked_for(collisions):
    where, _, _ = collisions
    rng, images_of = np.random.default_rng(0), np.tile(where.reference, (4, 1))
    dead = drawn(images.DeadPatch, where, strength=30.0, residual=0.0).change(images_of.copy(), rng)
    assert len(np.flatnonzero((dead != images_of).any(axis=0))) <= 30
    assert (dead <= images_of).all()
    hot = drawn(images.HotCells, where, strength=0.2, cells=5.5, spread=0.0).change(images_of.copy(), rng)
    cells = np.flatnonzero((hot != images_of).any(axis=0))
    assert len(cells) == 5
    np.testing.assert_allclose((hot[:, cells] > images_of[:, cells]).mean(axis=0), 0.2, atol=0.05)
    lossy = drawn(images.UnevenEfficiency, where, strength=0.2).change(images_of.copy(), rng)
    assert lossy.sum() / images_of.sum() == pytest.approx(0.8, abs=0.03)
    noisy = drawn(images.NoiseClusters, where, strength=2.0, pairs=0.0).change(images_of.copy(), rng)
    assert (noisy.sum() - images_of.sum()) / len(images_of) == pytest.approx(2, abs=0.2)
    for x in (dead, hot, lossy, noisy):
        assert x.dtype == np.uint8
        assert set(np.unique(x)) <= {0, 1}


def test_links_chips_timing_and_noise_of_the_second_series(collisions):
    where, _, _ = collisions
    rng, images_of = np.random.default_rng(0), np.tile(where.reference, (4, 1))
    silent = drawn(second.images.SilentLink, where, strength=0.5, columns=2.5).change(images_of.copy(), rng)
    assert (silent <= images_of).all()
    changed = np.flatnonzero((silent != images_of).reshape(-1, 32, 32).any(axis=(0, 1)))
    assert len(changed) == 2
    left = silent.reshape(-1, 32, 32)[..., changed].sum() / images_of.reshape(-1, 32, 32)[..., changed].sum()
    assert left == pytest.approx(0.5, abs=0.06)
    noisy = drawn(second.images.NoisyChip, where, strength=0.2, cells=5.5, together=0.9).change(images_of.copy(), rng)
    more = (noisy > images_of)[:, (noisy != images_of).any(axis=0)]
    assert more.shape[1] == 5
    assert more.any(axis=1).mean() == pytest.approx(0.2, abs=0.04)
    late = drawn(second.images.BadTiming, where, strength=0.2, evenness=2.0).change(images_of.copy(), rng)
    share = 1 - late.sum(axis=1) / np.maximum(images_of.sum(axis=1), 1)
    assert share.mean() == pytest.approx(0.2, abs=0.03)
    assert share.var() > 0.2 * 0.8 / 3  # the beta distribution's, to which that of the hits adds
    graded = drawn(second.images.GradedNoise, where, strength=3.0, gradient=0.7).change(images_of.copy(), rng)
    rows = (graded > images_of).reshape(-1, 32, 32).sum(axis=(0, 2))
    assert rows.sum() / len(images_of) == pytest.approx(3, abs=0.25)
    assert rows[16:].sum() > 1.4 * rows[:16].sum()
    for x in (silent, noisy, late, graded):
        assert x.dtype == np.uint8
        assert set(np.unique(x)) <= {0, 1}


def test_beams_that_wander_or_tilt_turn_nothing_but_the_collision(collisions):
    where, particles, theta = collisions
    rng = np.random.default_rng(0)
    for shape in (second.images.WanderingBeam, second.images.TiltedBeams):
        still = drawn(shape, where, strength=0.0)
        np.testing.assert_array_equal(still.detect(where.task, particles, theta, rng), where.reference)
    moved = drawn(second.images.WanderingBeam, where, strength=1.0, azimuth=0.0)
    columns = moved.detect(where.task, particles, theta, rng).reshape(-1, 32, 32).sum(axis=(0, 1))
    assert columns[[*range(4), *range(28, 32)]].sum() > 1.2 * columns[12:20].sum()
    # half a turn mirrors the collision, but leaves it where it was: as a collision at -theta, mirrored as a whole
    half = drawn(second.images.TiltedBeams, where, strength=np.pi, azimuth=0.0, divergence=0.0)
    image = half.detect(where.task, particles, theta, rng).reshape(-1, 32, 32)
    other = where.task.detect(particles, -theta).reshape(-1, 32, 32)
    assert (image == other[:, ::-1, ::-1]).mean() > 0.9999


@pytest.mark.parametrize(
    ("trigger", "fixed", "rows"),
    [
        (images.MultiplicityTrigger, {"width": 0.1}, slice(None)),
        (second.images.CentralTrigger, {"width": 0.05, "middle": 0.5}, slice(8, 24)),
    ],
)
def test_a_trigger_on_the_number_of_hits_loses_events_with_few(collisions, trigger, fixed, rows):
    where, _, _ = collisions
    trigger = drawn(trigger, where, strength=0.3, **fixed)
    hits = where.reference.reshape(-1, 32, 32)[:, rows].sum(axis=(1, 2))
    efficiency = trigger.efficiency(where.reference)
    assert (np.diff(efficiency[np.argsort(hits)]) >= 0).all()
    assert efficiency.mean() == pytest.approx((hits >= np.quantile(hits, 0.3)).mean(), abs=0.03)


@pytest.mark.parametrize(("shape", "seen"), [(images.SpreadPileUp, 1), (second.images.OutOfTime, 0.5)])
def test_pile_up_adds_collisions(collisions, shape, seen):
    where, _, theta = collisions
    simulate = lambda at, rng: np.ones((len(at), 1024), np.uint8)  # noqa: E731
    calls = []

    def counted(at, rng):
        calls.append(len(at))
        return np.zeros((len(at), 1024), np.uint8) if len(calls) == 1 else simulate(at, rng)

    fixed = {"in_time": seen} if seen < 1 else {}
    x = drawn(shape, where, strength=0.3, **fixed).measure(counted, theta, np.random.default_rng(0))
    assert calls[1] / 500 == pytest.approx(0.3, abs=0.1)
    assert x.any(axis=1).mean() == pytest.approx(1 - np.exp(-0.3), abs=0.08)
    assert x.sum() / 1024 <= calls[1] * seen * 1.05
    assert x.dtype == where.task.dtype


def test_registered_tasks_have_injections_for_their_events():
    for name in registry.names("task"):
        task = registry.build("task", name, {})
        where = Place(task, None if task.event_shape else 0, np.zeros((2, task.num_features)))
        assert shapes(where)


def test_the_page_on_the_challenge_lists_every_shape_with_its_strengths():
    page = (Path(__file__).parents[2] / "docs" / "tables" / "challenge-shapes.md").read_text()
    for shape in (shape for family in FAMILIES.values() for shape in family):
        (drawn,) = (each.metadata for each in fields(shape) if each.name == "strength")
        sign, unit = "± " * drawn["sign"], "" if drawn["unit"] == "1" else f" {drawn['unit']}"
        sentence = " ".join(shape.__doc__.split("\n\n")[0].split())
        strength = f"{sign}{drawn['low']:g} to {drawn['high']:g}{unit}"
        assert f"| {shape.name} | {shape.__name__} | {shape.series} | {strength} | {sentence} |" in page
