"""Simulated cases of several features: a beam line, a gas chromatograph, an engine, oil drops and a PET scanner."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator
BETA = np.array([9.0, 4.0, 12.0, 6.0, 10.0])
PHASE = np.radians([0, 50, 95, 150, 200])


def pulse(theta: NDArray, rng: Rng) -> NDArray:
    """Return where a pulse of protons passes the five monitors of a transfer line, in mm.

    The kicker throws it with a position and an angle that jitter from pulse to pulse; the magnets then make it swing
    about the axis. Each monitor reads to 0.2 mm.
    """
    kick = theta[:, :2] + theta[:, 2:] * rng.standard_normal((len(theta), 2))
    path = np.sqrt(BETA) * (kick[:, :1] * np.cos(PHASE) + kick[:, 1:] * np.sin(PHASE))
    return path + 0.2 * rng.standard_normal(path.shape)


BEAM = task(
    pulse,
    features=["m1", "m2", "m3", "m4", "m5"],
    name="beam-monitors",
    prior={"position": (-1, 1), "angle": (-1, 1), "jitter": (0.05, 0.5)},
)


@case(
    BEAM, "single", right=("scale on m3",), defensible=("offset on m3", "crosstalk on m3", "conditional_response on m3")
)
def beam_worn_contact(rng: Rng) -> NDArray:
    """The contact of one plate of the third monitor has got loose, and all that it shows is about 6 % too large.

    How much it is changes by a few tenths of a per cent while the contact warms up and cools down.
    """
    x = draw(BEAM, rng, 1500, 0.35, 0.45, 0.14)
    x[:, 2] *= 1.06 + 0.003 * np.sin(np.arange(1500) / 90)
    return x


@case(
    BEAM, "single", right=("crosstalk on m4",), defensible=("conditional_response on m4", "scale on m4", "offset on m4")
)
def beam_cables_side_by_side(rng: Rng) -> NDArray:
    """The cable of the fourth monitor lies beside that of the fifth, and picks up a part of its signal.

    The larger the signal, the better it gets across, as the screen of the cable is a little less tight then.
    """
    x = draw(BEAM, rng, 2200, 0.55, -0.3, 0.21)
    x[:, 3] += 0.03 * x[:, 4] * (1 + 0.1 * np.abs(x[:, 4]))
    return x


@case(BEAM, "single", right=("correlation",), defensible=("resolution on m2", "resolution on m3", "resolution on m4"))
def beam_hum_in_a_crate(rng: Rng) -> NDArray:
    """The electronics of the three monitors in the middle stand in one crate, whose ground swings with the mains.

    The pulses come at any phase of the mains; the three readings are moved together, by up to 0.18 mm.
    """
    x = draw(BEAM, rng, 1300, -0.4, 0.25, 0.11)
    x[:, 1:4] += 0.18 * np.sin(2 * np.pi * rng.random(1300))[:, None]
    return x


@case(
    BEAM,
    "pair",
    right=("saturation on m5", "outliers on m2"),
    defensible=(
        "peak_background on m5",
        "edge_acceptance on m5",
        "radiative_tail on m2",
        "resolution on m2",
        "flat_background on m2",
        "peak_background on m2",
    ),
)
def beam_spray_and_short_scale(rng: Rng) -> NDArray:
    """The converter of the fifth monitor ends at -2.6 mm, which nearly a tenth of the pulses pass.

    Besides, lost protons hit a plate of the second monitor in 1.2 % of the pulses, and its reading is far off.
    """
    n = 1600
    x = draw(BEAM, rng, n, 0.6, 0.2, 0.12)
    x[:, 4] = np.maximum(x[:, 4], -2.6)
    x[:, 1] += some(rng, n, 0.012) * (0.4 + rng.exponential(0.8, n))
    return x


@case(BEAM, "outside")
def beam_stale_readings(rng: Rng) -> NDArray:
    """In 8 % of the pulses the last two monitors were not read in time: they show the pulse before once again."""
    n = 1800
    x = draw(BEAM, rng, n, -0.3, -0.55, 0.18)
    late = some(rng, n, 0.08)
    x[:, 3:] = either(late, np.roll(x[:, 3:], 1, axis=0), x[:, 3:])
    return x


def peak(theta: NDArray, rng: Rng) -> NDArray:
    """Return the time in min, the width at half height in s, the area in mV s, and the height in mV of a peak.

    A gas needs 1.2 min to pass the column, the substance longer by how much it is retained. The width follows from the
    number of plates, the height from the area and the width; the samples hold different amounts.
    """
    g = rng.standard_normal((4, len(theta)))
    time = 1.2 * (1 + theta[:, 0]) * np.exp(0.004 * g[0])
    width = 141.3 * time / np.sqrt(theta[:, 1]) * np.exp(0.04 * g[1])
    area = theta[:, 2] * np.exp(theta[:, 3] * g[2])
    return np.stack([time, width, area, area / (1.064 * width) * np.exp(0.03 * g[3])], axis=1)


PEAKS = task(
    peak,
    features=["time", "width", "area", "height"],
    name="gas-chromatograph",
    prior={"retention": (1, 8), "plates": (3000, 60000), "amount": (20, 400), "spread": (0.05, 0.7)},
)


@case(
    PEAKS, "single", right=("saturation on height",), defensible=("scale on height", "conditional_response on height")
)
def peaks_bent_amplifier(rng: Rng) -> NDArray:
    """The amplifier does not follow high peaks up to their tops: towards 60 mV it bends, and it never gets beyond.

    The area is reckoned from the flanks, and is right.
    """
    x = draw(PEAKS, rng, 1200, 3.2, 12000.0, 100.0, 0.45)
    x[:, 3] /= (1 + (x[:, 3] / 60) ** 4) ** 0.25
    return x


@case(
    PEAKS,
    "single",
    right=("peak_background on time", "mixture"),
    defensible=("outliers on time", "radiative_tail on time"),
)
def peaks_of_an_isomer(rng: Rng) -> NDArray:
    """In 2.5 % of the samples the peak of an isomer was taken, which comes 1.6 % later, and of which there is less."""
    n = 2600
    x = draw(PEAKS, rng, n, 5.6, 21000.0, 90.0, 0.22)
    isomer = draw(PEAKS, rng, n, 6.6 * 1.016 - 1, 21000.0, 70.0, 0.3)
    return either(some(rng, n, 0.025), isomer, x)


@case(
    PEAKS,
    "single",
    right=("radiative_tail on time",),
    defensible=("resolution on time", "offset on time", "outliers on time", "spread", "mixture"),
)
def peaks_slow_hand(rng: Rng) -> NDArray:
    """The samples are injected by hand: in a quarter of them the clock was started before the plunger was down.

    It then runs for some seconds before the sample is on its way. The column knows nothing of it: the width is right.
    """
    n = 900
    x = draw(PEAKS, rng, n, 2.7, 8000.0, 240.0, 0.3)
    x[:, 0] += some(rng, n, 0.25) * rng.gamma(2, 0.012, n)
    return x


@case(
    PEAKS,
    "pair",
    right=("offset on area", "quantisation on width"),
    defensible=(
        "offset on height",
        "scale on area",
        "resolution on width",
        "conditional_response on area",
        "conditional_response on height",
    ),
)
def peaks_low_baseline(rng: Rng) -> NDArray:
    """The baseline was drawn too low, which adds some 2 mV s to each area; the height is taken above the true one.

    Besides, the detector is read out twice a second, and the width is the number of readings above half height.
    """
    n = 1500
    x = draw(PEAKS, rng, n, 3.9, 16000.0, 85.0, 0.5)
    x[:, 1] = np.floor(2 * x[:, 1] + 0.5) / 2
    x[:, 2] += rng.gamma(9, 0.22, n)
    return x


def cycle(theta: NDArray, rng: Rng) -> NDArray:
    """Return of one cycle of an engine the highest pressure in bar, its angle in degrees, the torque and the exhaust.

    Half of the fuel is burnt at an angle that differs from cycle to cycle, with more late ones. A late cycle has less
    pressure, a little less torque (in N m, measured at the brake), and hotter exhaust (in degrees Celsius).
    """
    g = rng.standard_normal((5, len(theta)))
    half = theta[:, 0] + theta[:, 1] * (rng.gamma(4, 0.5, len(theta)) - 2)
    load = theta[:, 2] * np.exp(0.02 * g[0])
    late = half - 8
    pressure = 6.2 * load * np.exp(-late / 28 + 0.02 * g[1])
    torque = 14 * load / (1 + (late / 45) ** 2) * np.exp(0.012 * g[2])
    return np.stack([pressure, half + 6 + 0.8 * g[3], torque, 560 + 14 * load + 4.5 * late + 6 * g[4]], axis=1)


ENGINE = task(
    cycle,
    features=["pressure", "angle", "torque", "exhaust"],
    name="engine-cycles",
    prior={"burning": (0, 25), "cyclic": (0.8, 6), "load": (3, 14)},
)


@case(ENGINE, "single", right=("offset on angle",), defensible=("scale on angle", "conditional_response on angle"))
def engine_dead_centre(rng: Rng) -> NDArray:
    """The disc that tells the angle was put on 0.6 degrees early, and has some play of a twentieth of a degree."""
    x = draw(ENGINE, rng, 1100, 9.0, 2.4, 6.5)
    x[:, 1] -= 0.6 + 0.05 * rng.standard_normal(1100)
    return x


@case(
    ENGINE,
    "single",
    right=("mixture",),
    defensible=("spread", "peak_background on angle", "radiative_tail on angle", "radiative_tail on exhaust"),
)
def engine_lean_cylinder(rng: Rng) -> NDArray:
    """The cycles of two cylinders got into one file: those of the second, a tenth of all, burn late.

    Its nozzle is clogged, so that it gets 3 % less fuel, and a mixture that burns slowly.
    """
    n = 1700
    lean = draw(ENGINE, rng, n, 13.5, 2.7, 7.0)
    return either(some(rng, n, 0.1), lean, draw(ENGINE, rng, n, 10.0, 2.2, 7.2))


@case(
    ENGINE,
    "single",
    right=("spread",),
    defensible=("correlation", "mixture", "resolution on torque", "resolution on pressure"),
)
def engine_hunting_governor(rng: Rng) -> NDArray:
    """The governor hunts: the load swings to and fro by 3.5 % about what was set, once in some 60 cycles."""
    n = 1400
    swing = np.sin(2 * np.pi * (np.arange(n) / 60 + 0.3 * np.cumsum(rng.standard_normal(n)) / np.sqrt(n)))
    theta = np.stack([np.full(n, 7.5), np.full(n, 1.9), 9.8 * (1 + 0.035 * swing)], axis=1)
    return ENGINE.simulate(theta, rng)


@case(
    ENGINE,
    "pair",
    right=("radiative_tail on pressure", "resolution on angle"),
    defensible=("outliers on pressure", "resolution on pressure", "scale on pressure", "peak_background on pressure"),
)
def engine_knocks(rng: Rng) -> NDArray:
    """A tenth of the cycles knock, and the ringing of the gas lies on top of the highest pressure.

    Besides, the belt that drives the disc for the angle flaps, which blurs the angle by some 0.8 degrees.
    """
    n = 1300
    x = draw(ENGINE, rng, n, 5.5, 2.0, 11.0)
    x[:, 0] += some(rng, n, 0.1) * 5 * rng.weibull(1.2, n)
    x[:, 1] += 1.0 * np.sin(2 * np.pi * rng.random(n)) + 0.4 * rng.standard_normal(n)
    return x


@case(ENGINE, "outside")
def engine_slow_thermocouple(rng: Rng) -> NDArray:
    """The thermocouple in the exhaust is slow: what it shows is still a half of what it showed in the cycle before."""
    n = 1000
    x = draw(ENGINE, rng, n + 11, 11.0, 2.8, 5.6)
    weights = 0.5 ** np.arange(1, 13)
    slow = np.convolve(x[:, 3], weights / weights.sum(), mode="valid")
    return np.column_stack([x[11:, :3], slow])


def drop(theta: NDArray, rng: Rng) -> NDArray:
    """Return how fast a drop of oil falls without a field, and rises with it, in micrometres a second.

    The radius (in micrometres) differs between drops, and so does the number of the charges, of which each has at least
    one. The field pulls with a push for each charge. A drop with few charges goes on falling in the field.
    """
    n = len(theta)
    radius = theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(n))
    fall = 118 * radius**2
    rise = theta[:, 3] * (1 + rng.poisson(theta[:, 2])) / radius - fall
    v = np.stack([fall, rise], axis=1)
    return v * (1 + 0.02 * rng.standard_normal((n, 2))) + rng.standard_normal((n, 2))


DROPS = task(
    drop,
    features=["fall", "rise"],
    name="oil-drops",
    prior={"radius": (0.4, 1.3), "spread": (0.05, 0.4), "charges": (0.5, 8), "push": (20, 80)},
)


@case(
    DROPS,
    "single",
    right=("charge_misid on rise",),
    defensible=("outliers on rise", "flat_background on rise", "peak_background on rise"),
)
def drops_upside_down(rng: Rng) -> NDArray:
    """The microscope shows the drops upside down, and now and then up was written for down in the field.

    It happens more with slow drops, in up to one of ten, as they are hardly seen to move.
    """
    n = 2400
    x = draw(DROPS, rng, n, 0.92, 0.12, 1.3, 43.0)
    x[:, 1] *= np.where(some(rng, n, 0.1) & (rng.random(n) < np.exp(-np.abs(x[:, 1]) / 150)), -1, 1)
    return x


@case(
    DROPS,
    "single",
    right=("edge_acceptance on fall",),
    defensible=("forward_backward_acceptance on fall", "dead_region on fall", "edge_acceptance on rise"),
)
def drops_too_fast(rng: Rng) -> NDArray:
    """Drops that fall fast are past the marks before the watch is in the hand, and are not taken into the list."""
    x = draw(DROPS, rng, 5000, 0.73, 0.25, 3.2, 36.0)
    return x[rng.random(5000) < np.exp(-((np.maximum(x[:, 0], 0) / 95) ** 7))]


@case(DROPS, "single", right=("conditional_response",), defensible=("scale", "spread", "offset on fall"))
def drops_slip(rng: Rng) -> NDArray:
    """The air is no smooth fluid for a small drop, which slips between its molecules: it moves faster than was thought.

    Both speeds are larger by 0.08 micrometres over the radius. For drops of one size it would be one more factor of the
    push; here it depends on how fast the drop falls.
    """
    n = 600
    radius = 0.75 * np.exp(0.2 * rng.standard_normal(n))
    fall = 118 * radius**2
    v = np.stack([fall, 34 * (1 + rng.poisson(1.6, n)) / radius - fall], axis=1) * (1 + 0.08 / radius)[:, None]
    return v * (1 + 0.02 * rng.standard_normal((n, 2))) + rng.standard_normal((n, 2))


@case(DROPS, "outside")
def drops_that_do_not_fit(rng: Rng) -> NDArray:
    """Drops whose charge, reckoned from the two speeds, is not close to a whole number were held for bad ones.

    They were left out of the list, so that the charges are sharper than the watch allows.
    """
    x = draw(DROPS, rng, 6500, 0.78, 0.15, 3.4, 57.0)
    charge = x.sum(axis=1) * np.sqrt(np.maximum(x[:, 0], 0) / 118) / 57
    return x[np.abs(charge - np.round(charge)) < 0.07]


def annihilation(theta: NDArray, rng: Rng) -> NDArray:
    """Return the energies in keV of the two photons in a PET scanner, and the time in ns between them.

    A photon leaves all of its 511 keV in a crystal, or a part by a collision. The time tells where the source stands.
    """
    n = len(theta)
    left = np.where(rng.random((n, 2)) < theta[:, 1:2], 511, 60 + 281 * np.sqrt(rng.random((n, 2))))
    left = left + theta[:, 2:3] * np.sqrt(511 * left) * rng.standard_normal((n, 2))
    return np.column_stack([left, theta[:, 0] / 150 + theta[:, 3] * rng.standard_normal(n)])


PET = task(
    annihilation,
    features=["energy_a", "energy_b", "delay"],
    name="pet-scanner",
    prior={"place": (-200, 200), "stopped": (0.2, 0.9), "blur": (0.03, 0.12), "jitter": (0.1, 0.6)},
)


@case(
    PET,
    "single",
    right=("flat_background on delay",),
    defensible=("outliers on delay", "peak_background on delay", "resolution on delay", "mixture"),
)
def pet_random_coincidences(rng: Rng) -> NDArray:
    """In 3 % of the pairs the photons are of two nuclei that decayed within the window of 3 ns by chance."""
    n = 4000
    x = draw(PET, rng, n, 45.0, 0.62, 0.06, 0.31)
    x[:, 2] = np.where(some(rng, n, 0.03), rng.uniform(-1.5, 1.5, n), x[:, 2])
    return x[np.abs(x[:, 2]) < 1.5]


@case(
    PET,
    "single",
    right=("dead_region on delay",),
    defensible=("forward_backward_acceptance on delay", "edge_acceptance on delay"),
)
def pet_bad_taps(rng: Rng) -> NDArray:
    """Two taps of the delay line that measures the time have gone bad: one loses most pairs, and the next one some."""
    x = draw(PET, rng, 5500, -60.0, 0.45, 0.09, 0.24)
    lost = np.select([np.abs(x[:, 2] + 0.23) < 0.04, np.abs(x[:, 2] + 0.15) < 0.04], [0.75, 0.35], 0)
    return x[rng.random(5500) >= lost]


@case(
    PET,
    "pair",
    right=("conditional_response on delay", "edge_acceptance on energy_a"),
    defensible=("dead_region on energy_a", "forward_backward_acceptance on energy_a", "radiative_tail on delay"),
)
def pet_late_small_signals(rng: Rng) -> NDArray:
    """A small signal of the second crystal takes longer to get over its threshold, and its time is late.

    Besides, the threshold of the first crystal was set too high: below some 140 keV it starts to lose photons.
    """
    x = draw(PET, rng, 3500, 80.0, 0.4, 0.055, 0.22)
    x[:, 2] += 0.12 * (np.sqrt(511 / np.maximum(x[:, 1], 20)) - 1)
    return x[rng.logistic(140, 12, 3500) < x[:, 0]]


@case(PET, "outside")
def pet_one_converter_twice(rng: Rng) -> NDArray:
    """In 12 % of the pairs the converter of the first photon was read twice: its energy stands for both."""
    n = 3000
    x = draw(PET, rng, n, 110.0, 0.46, 0.05, 0.28)
    x[:, 1] = np.where(some(rng, n, 0.12), x[:, 0] + rng.normal(0, 1.5, n), x[:, 1])
    return x


CASES: list[Case] = [
    plain("beam_plain", BEAM, 3000, -0.6, 0.35, 0.2),
    beam_worn_contact,
    beam_cables_side_by_side,
    beam_hum_in_a_crate,
    beam_spray_and_short_scale,
    beam_stale_readings,
    plain("peaks_plain", PEAKS, 1000, 6.1, 24000.0, 130.0, 0.25),
    peaks_bent_amplifier,
    peaks_of_an_isomer,
    peaks_slow_hand,
    peaks_low_baseline,
    plain("engine_plain", ENGINE, 12000, 9.5, 2.1, 7.0),
    engine_dead_centre,
    engine_lean_cylinder,
    engine_hunting_governor,
    engine_knocks,
    engine_slow_thermocouple,
    plain("drops_plain", DROPS, 700, 0.7, 0.17, 2.8, 41.0),
    drops_upside_down,
    drops_too_fast,
    drops_slip,
    drops_that_do_not_fit,
    plain("pet_plain", PET, 20000, 75.0, 0.7, 0.055, 0.28),
]
CASES += [pet_random_coincidences, pet_bad_taps, pet_late_small_signals, pet_one_converter_twice]
"""The cases of this file."""
