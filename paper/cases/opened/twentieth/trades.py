"""Simulated cases of several features and of one: lorries, golf balls, eggs of gulls, a geyser, and a hot wire."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import case, draw, plain, some

Rng = np.random.Generator


def lorry(theta: NDArray, rng: Rng) -> NDArray:
    """Return the loads of the steering axle, the driving axle and the trailer's axles in t, and the speed in km/h.

    A lorry is empty or carries a payload, which rests on the three in fixed parts. It bounces while it is weighed, each
    axle by itself, and a heavy one drives a little more slowly.
    """
    n = len(theta)
    laden = rng.random(n) > theta[:, 0]
    payload = laden * theta[:, 1] * np.exp(theta[:, 2] * rng.standard_normal(n))
    loads = np.stack([5.2 + 0.09 * payload, 4.0 + 0.31 * payload, 4.6 + 0.60 * payload], axis=1)
    loads *= np.exp(theta[:, 3, None] * rng.standard_normal((n, 3)))
    speed = 86 - 0.15 * payload + 3.2 * rng.standard_normal(n)
    return np.column_stack([loads, speed])


LORRIES = task(
    lorry,
    name="lorries-weighed",
    features=["steering", "driving", "trailer", "speed"],
    prior={"empty": (0.1, 0.6), "payload": (8, 22), "spread": (0.08, 0.4), "bounce": (0.02, 0.1)},
)


@case(
    LORRIES,
    "single",
    right=("conditional_response on trailer",),
    defensible=("resolution on trailer", "crosstalk on trailer", "scale on trailer", "correlation", "spread"),
)
def lorries_that_press_the_strip_too_briefly(rng: Rng) -> NDArray:
    """The last strip is slow: the faster a trailer rolls over it, the less of its load has been felt when it is gone.

    What is read falls by 1 % for each km/h above that of the calibration, 84 km/h, and rises below it. The bouncing
    of the simulation can be raised for it, but then for all axles.
    """
    x = draw(LORRIES, rng, 2400, 0.28, 14.5, 0.22, 0.045)
    x[:, 2] *= (84 / x[:, 3]) ** 0.85
    return x


@case(
    LORRIES,
    "single",
    right=("scale on trailer", "radiative_tail on trailer"),
    defensible=("outliers on trailer", "mixture", "resolution on trailer", "conditional_response on trailer", "spread"),
)
def lorries_with_a_lifted_axle(rng: Rng) -> NDArray:
    """Of one trailer in seven the last of its three axles was not noticed by the loop, and its load was not added.

    The three carry about the same, so that a third of the trailer's load is missing, in some more, in others less.
    """
    n = 4000
    x = draw(LORRIES, rng, n, 0.4, 12.5, 0.3, 0.04)
    x[:, 2] *= 1 - some(rng, n, 0.14) * (0.33 + 0.025 * rng.standard_normal(n))
    return x


@case(
    LORRIES,
    "single",
    right=("correlation",),
    defensible=(
        "resolution on steering",
        "resolution on driving",
        "crosstalk on steering",
        "crosstalk on driving",
        "offset",
        "conditional_response on steering",
        "spread",
    ),
)
def lorries_on_a_plate_with_a_wandering_zero(rng: Rng) -> NDArray:
    """The two axles of the tractor are weighed on one plate and the trailer on another.

    The zero of the first plate wanders with sun and shade by some tenths of a tonne, so that both of the tractor's
    axles are wrong by the same. The bouncing of the simulation can be raised, but it leaves the axles independent.
    """
    n = 2600
    x = draw(LORRIES, rng, n, 0.22, 16.0, 0.18, 0.035)
    x[:, :2] += 0.26 * np.sin(2 * np.pi * rng.random((n, 1))) + 0.08 * rng.standard_normal((n, 1))
    return x


@case(
    LORRIES,
    "pair",
    right=("resolution on driving", "edge_acceptance on speed"),
    defensible=(
        "forward_backward_acceptance on speed",
        "outliers on driving",
        "spread",
        "dead_region on speed",
        "conditional_response on driving",
    ),
)
def lorries_on_a_rutted_road(rng: Rng) -> NDArray:
    """A rut before the second strip makes the driving axle hop, and slow lorries are not weighed at all.

    The hop adds to the load of that axle, or takes from it, up to a quarter. The evaluation asks for a speed of about
    83 km/h, which each lane's loop finds a little differently.
    """
    n = 9000
    x = draw(LORRIES, rng, n, 0.33, 13.0, 0.25, 0.05)
    x[:, 1] *= 1 + 0.22 * np.sin(2 * np.pi * rng.random(n)) * rng.random(n) ** 0.4
    return x[x[:, 3] > 83 + 0.6 * rng.standard_normal(n)]


@case(LORRIES, "outside")
def lorries_in_a_close_convoy(rng: Rng) -> NDArray:
    """Where lorries follow each other closely, three of ten trailers were booked to the tractor behind.

    Each load is a right one, and as frequent as it should be, but the trailer does not belong to its tractor.
    """
    x = draw(LORRIES, rng, 5000, 0.35, 15.5, 0.2, 0.05)
    x[:, 2] = np.where(some(rng, 5000, 0.3), np.roll(x[:, 2], 1), x[:, 2])
    return x


def golf(theta: NDArray, rng: Rng) -> NDArray:
    """Return the ball's speed in m/s, launch angle in degrees, spin in rotations a minute, carry and side in m.

    A ball that is hit high on the face starts higher and with less spin. One hit towards the toe is slower and curves.
    """
    n = len(theta)
    swing, high, toe, roll, grip, air, face, curl, loft = rng.standard_normal((9, n))
    speed = theta[:, 0] * np.exp(theta[:, 2] * swing - 0.02 * toe**2)
    launch = theta[:, 1] + 1.8 * high + 0.5 * loft
    spin = 215 * theta[:, 1] * np.exp(-0.10 * high + 0.07 * grip)
    lift = (1 - ((launch - 14) / 28) ** 2) * (1 - ((spin - 2600) / 9000) ** 2)
    carry = 228 * (speed / 70) ** 1.3 * np.maximum(lift, 0.2) * np.exp(0.015 * air + 0.005 * roll)
    side = carry * (np.tan(np.deg2rad(theta[:, 3] + 1.2 * face)) + 0.025 * toe + 0.008 * curl)
    return np.stack([speed, launch, spin, carry, side], axis=1)


GOLF = task(
    golf,
    name="golf-shots",
    features=["speed", "launch", "spin", "carry", "side"],
    prior={"speed": (45, 75), "loft": (8, 20), "swing": (0.01, 0.08), "aim": (-4, 4)},
)


@case(
    GOLF,
    "single",
    right=("radiative_tail on carry", "scale on carry"),
    defensible=("outliers on carry", "resolution on carry", "mixture", "spread", "conditional_response on carry"),
)
def golf_with_worn_balls(rng: Rng) -> NDArray:
    """A quarter of the balls of the range are worn smooth, and come down earlier than their start would let expect.

    How much earlier depends on the wear: mostly some per cent, a few by nearly a fifth. In angle they go like others.
    """
    n = 800
    x = draw(GOLF, rng, n, 63.0, 12.2, 0.04, -1.1)
    x[:, 3:] *= 1 - some(rng, n, 0.25)[:, None] * (0.02 + 0.18 * rng.beta(1.3, 2.2, (n, 1)))
    return x


@case(
    GOLF,
    "single",
    right=("conditional_response on side", "crosstalk on side"),
    defensible=("correlation", "resolution on side", "offset on side", "scale on side"),
)
def golf_in_a_wind_from_the_left(rng: Rng) -> NDArray:
    """A steady wind from the left carries the balls to the right, those most that fly high and stay long in the air.

    On average it looks as if the player aimed more to the right. It gusts a little.
    """
    x = draw(GOLF, rng, 2500, 66.0, 11.2, 0.03, 0.9)
    in_the_air = np.maximum(x[:, 1] / 11.2, 0) ** 1.3 * x[:, 0] / 66
    x[:, 4] += 11 * in_the_air * (1 + 0.1 * rng.standard_normal(2500))
    return x


@case(
    GOLF,
    "pair",
    right=("quantisation on spin", "dead_region on side"),
    defensible=("edge_acceptance on side", "resolution on spin", "forward_backward_acceptance on side"),
)
def golf_beside_a_pond(rng: Rng) -> NDArray:
    """The display gives the spin in steps of 200 rotations a minute, and many balls to the right fall into a pond.

    Of those that would come down between 6 and 15 m from the line nine of ten are lost. Its bank is not straight.
    """
    n = 6000
    x = draw(GOLF, rng, n, 57.0, 14.5, 0.055, 1.2)
    x[:, 2] = 200 * np.round(x[:, 2] / 200)
    near, far = 6 + 0.8 * rng.standard_normal(n), 15 + 1.2 * rng.standard_normal(n)
    return x[(x[:, 4] < near) | (x[:, 4] > far) | some(rng, n, 0.1)]


@case(GOLF, "outside")
def golf_with_a_reckoned_spin(rng: Rng) -> NDArray:
    """Of balls whose mark the radar did not see, nearly half of all, the spin was reckoned from the launch angle.

    It is the one that such a club gives on average to a ball that starts so high, with none of the scatter of spins.
    """
    x = draw(GOLF, rng, 4000, 61.0, 10.6, 0.035, -2.0)
    reckoned = 215 * 10.6 * np.exp(-0.10 * (x[:, 1] - 10.6) * 1.8 / (1.8**2 + 0.5**2))
    x[:, 2] = np.where(some(rng, 4000, 0.45), reckoned, x[:, 2])
    return x


def gull_egg(theta: NDArray, rng: Rng) -> NDArray:
    """Return the length and the breadth of an egg in mm, and its mass in g.

    The mass goes with the length and the square of the breadth, times a density that falls while the egg is brooded.
    """
    n = len(theta)
    length = theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(n))
    breadth = theta[:, 2] * theta[:, 0] * (length / theta[:, 0]) ** 0.5 * np.exp(0.03 * rng.standard_normal(n))
    mass = theta[:, 3] * length * breadth**2 / 1000 * np.exp(0.012 * rng.standard_normal(n))
    return np.stack([length, breadth, mass], axis=1)


GULL_EGGS = task(
    gull_egg,
    name="gull-eggs",
    features=["length", "breadth", "mass"],
    prior={"length": (60, 80), "spread": (0.02, 0.07), "roundness": (0.62, 0.78), "density": (0.42, 0.6)},
)


@case(
    GULL_EGGS,
    "single",
    right=("spread", "resolution on mass"),
    defensible=(
        "radiative_tail on mass",
        "scale on mass",
        "mixture",
        "outliers on mass",
        "conditional_response on mass",
    ),
)
def eggs_at_any_day_of_brooding(rng: Rng) -> NDArray:
    """The eggs were weighed once, at any of the 26 days of brooding, and each day takes some of their water.

    An egg loses about half a per cent a day, from some pores more and from others less. The simulation has one density
    for all, which takes up the mean of it.
    """
    n = 600
    x = draw(GULL_EGGS, rng, n, 71.5, 0.04, 0.68, 0.55)
    x[:, 2] *= 1 - 26 * rng.random(n) * 0.0050 * np.exp(0.2 * rng.standard_normal(n))
    return x


@case(
    GULL_EGGS,
    "single",
    right=("saturation on mass",),
    defensible=("edge_acceptance on mass", "peak_background on mass", "scale on mass", "conditional_response on mass"),
)
def eggs_beyond_the_spring_balance(rng: Rng) -> NDArray:
    """The spring balance ends at 100 g: heavier eggs pull it to its stop, which was read to some tenths of a gram."""
    x = draw(GULL_EGGS, rng, 1200, 73.5, 0.035, 0.69, 0.48)
    x[:, 2] = np.minimum(x[:, 2], 100 + 0.15 * rng.standard_normal(1200))
    return x


@case(
    GULL_EGGS,
    "single",
    right=("offset on breadth",),
    defensible=(
        "offset on mass",
        "scale on breadth",
        "scale on mass",
        "conditional_response on mass",
        "offset on length",
    ),
)
def eggs_in_bent_calipers(rng: Rng) -> NDArray:
    """The short jaws, with which the breadths were taken, are bent and do not close: they read 2.1 mm too much.

    Roundness and density take it up in the simulation, but the mass then grows too steeply with the breadth read.
    """
    x = draw(GULL_EGGS, rng, 6000, 67.0, 0.055, 0.66, 0.53)
    x[:, 1] += 2.1 + 0.1 * rng.standard_normal(6000)
    return x


@case(
    GULL_EGGS,
    "pair",
    right=("edge_acceptance on breadth", "outliers on length"),
    defensible=(
        "offset on length",
        "forward_backward_acceptance on breadth",
        "edge_acceptance on mass",
        "dead_region on breadth",
        "peak_background on length",
        "radiative_tail on length",
        "flat_background on length",
        "mixture",
    ),
)
def eggs_that_fell_through_the_ring(rng: Rng) -> NDArray:
    """Small eggs were sorted out with a ring, and of some eggs the length was misread by a whole centimetre.

    The ring is 47 mm wide, and eggs are not quite round. Four lengths in a hundred are too long or, mostly, too short.
    """
    n = 5000
    x = draw(GULL_EGGS, rng, n, 70.0, 0.045, 0.69, 0.49)
    x[:, 0] += 10 * some(rng, n, 0.04) * np.where(some(rng, n, 0.7), -1, 1)
    return x[x[:, 1] > 47 + 0.25 * rng.standard_normal(n)]


def geyser(theta: NDArray, rng: Rng) -> NDArray:
    """Return the time in minutes until the next eruption of a geyser, which is shorter after a short eruption."""
    n = len(theta)
    after_long = rng.random(n) < theta[:, 0]
    z = rng.standard_normal(n)
    return theta[:, 1] * np.where(after_long, np.exp(theta[:, 2] * z), 0.62 * np.exp(1.2 * theta[:, 2] * z))


GEYSER = task(
    geyser,
    name="geyser",
    features=["minutes"],
    prior={"long_ones": (0.3, 0.9), "interval": (70, 115), "spread": (0.04, 0.14)},
)


@case(GEYSER, "single", right=("offset",), defensible=("scale", "saturation", "mixture", "spread", "resolution"))
def geyser_timed_from_the_dry_basin(rng: Rng) -> NDArray:
    """The clock was started only when the basin had run dry, about nine minutes after the eruption.

    The mean interval takes up most of it, but short and long intervals are then not in their relation.
    """
    return draw(GEYSER, rng, 2500, 0.58, 96.0, 0.075) - 9 - 0.8 * rng.standard_normal((2500, 1))


@case(
    GEYSER,
    "single",
    right=("outliers", "peak_background"),
    defensible=("radiative_tail", "flat_background", "mixture", "scale"),
)
def geyser_that_erupted_unseen(rng: Rng) -> NDArray:
    """One eruption of fourteen was not seen for the steam of other springs, so that two intervals were taken as one."""
    x, next_one = draw(GEYSER, rng, 1500, 0.7, 88.0, 0.09), draw(GEYSER, rng, 1500, 0.7, 88.0, 0.09)
    return x + some(rng, 1500, 0.07)[:, None] * next_one


@case(
    GEYSER,
    "single",
    right=("edge_acceptance",),
    defensible=("forward_backward_acceptance", "mixture", "spread", "dead_region"),
)
def geyser_watched_for_two_hours(rng: Rng) -> NDArray:
    """Rangers watch for 108 minutes on end, and an interval is known if both of its eruptions fall into a watch.

    The longer it is, the less often it does, and one of more than 108 minutes never. The simulation takes it up in part
    as fewer and shorter long intervals.
    """
    x = draw(GEYSER, rng, 14000, 0.75, 99.0, 0.1)
    return x[108 * rng.random(14000) > x[:, 0]]


@case(GEYSER, "outside", defensible=("peak_background", "resolution"))
def geyser_of_running_means(rng: Rng) -> NDArray:
    """The park's page does not give the intervals, but each time the mean of the last three.

    As they follow each other without rule, short and long ones are mixed in it, in four groups that are narrow.
    """
    x = draw(GEYSER, rng, 4002, 0.6, 92.0, 0.06)
    return (x[:-2] + x[1:-1] + x[2:]) / 3


def hot_wire(theta: NDArray, rng: Rng) -> NDArray:
    """Return the speed of the air along a tunnel in m/s, at one moment, behind a step where gusts go forwards."""
    z = rng.standard_normal(len(theta))
    return theta[:, 0] + theta[:, 1] * np.expm1(theta[:, 2] * z) / theta[:, 2]


HOT_WIRE = task(
    hot_wire,
    name="hot-wire",
    features=["speed"],
    prior={"speed": (1, 16), "turbulence": (0.4, 4), "gusts": (0.03, 0.4)},
)


@case(
    HOT_WIRE,
    "single",
    right=("charge_misid",),
    defensible=("saturation", "edge_acceptance", "forward_backward_acceptance", "mixture"),
)
def wire_in_air_that_flows_back(rng: Rng) -> NDArray:
    """A wire is cooled by wind from behind as from before: where the air flows back, it reads the speed without sign.

    The air also moves a little across, which cools it too, so that it never reads quite nothing.
    """
    return np.hypot(draw(HOT_WIRE, rng, 4000, 2.4, 1.9, 0.11), 0.18 * rng.standard_normal((4000, 1)))


@case(
    HOT_WIRE,
    "single",
    right=("scale", "mixture"),
    defensible=("spread", "radiative_tail", "peak_background", "resolution", "outliers", "flat_background"),
)
def wire_with_a_thread_of_dust(rng: Rng) -> NDArray:
    """For a third of the time a thread of dust hung on the wire, which then read about a quarter too little.

    A stronger turbulence of the simulation takes up a good part of it.
    """
    n = 3500
    gain = np.where(some(rng, n, 0.33), 0.74 + 0.02 * rng.standard_normal(n), 1)
    return draw(HOT_WIRE, rng, n, 11.5, 1.2, 0.1) * gain[:, None]


@case(
    HOT_WIRE,
    "single",
    right=("resolution", "spread"),
    defensible=("mixture", "peak_background", "offset", "saturation", "flat_background"),
)
def wire_beside_a_transformer(rng: Rng) -> NDArray:
    """A transformer hums into the cable, and the readings go up and down with it, at any phase, by up to 2.2 m/s.

    In the simulation it looks like more turbulence, but the readings then have too few in the middle and at the ends.
    """
    return draw(HOT_WIRE, rng, 8000, 8.7, 1.1, 0.18) + 2.2 * np.sin(2 * np.pi * rng.random((8000, 1)))


@case(
    HOT_WIRE,
    "pair",
    right=("saturation", "peak_background"),
    defensible=("outliers", "edge_acceptance", "mixture", "radiative_tail", "flat_background"),
)
def wire_with_a_loose_plug(rng: Rng) -> NDArray:
    """The amplifier ends at 15.2 m/s, where all that is faster gathers, and a loose plug gives zeros now and then.

    The zeros are those of the amplifier, which has some noise. They are four readings of a hundred.
    """
    x = np.minimum(draw(HOT_WIRE, rng, 5000, 12.2, 2.3, 0.09), 15.2)
    return np.where(some(rng, 5000, 0.04)[:, None], 0.15 + 0.25 * rng.standard_normal((5000, 1)), x)


@case(HOT_WIRE, "outside", defensible=("saturation", "edge_acceptance", "peak_background", "outliers"))
def wire_whose_register_runs_over(rng: Rng) -> NDArray:
    """The register holds speeds from 0 to 16 m/s: one that is faster runs over, and begins again at nothing.

    So 19 m/s is stored as 3 m/s, and the one below nothing, which is rare, as one close to 16 m/s.
    """
    return np.mod(draw(HOT_WIRE, rng, 8000, 11.8, 2.9, 0.1), 16)


CASES = [
    plain("lorries_plain", LORRIES, 3000, 0.42, 17.0, 0.28, 0.06),
    lorries_that_press_the_strip_too_briefly,
    lorries_with_a_lifted_axle,
    lorries_on_a_plate_with_a_wandering_zero,
    lorries_on_a_rutted_road,
    lorries_in_a_close_convoy,
    plain("golf_plain", GOLF, 1500, 54.0, 15.8, 0.05, 2.3),
    golf_with_worn_balls,
    golf_in_a_wind_from_the_left,
    golf_beside_a_pond,
    golf_with_a_reckoned_spin,
    plain("eggs_plain", GULL_EGGS, 900, 66.0, 0.05, 0.73, 0.48),
    eggs_at_any_day_of_brooding,
    eggs_beyond_the_spring_balance,
    eggs_in_bent_calipers,
    eggs_that_fell_through_the_ring,
    plain("geyser_plain", GEYSER, 12000, 0.48, 84.0, 0.11),
    geyser_timed_from_the_dry_basin,
    geyser_that_erupted_unseen,
    geyser_watched_for_two_hours,
    geyser_of_running_means,
    wire_in_air_that_flows_back,
    wire_with_a_thread_of_dust,
    wire_beside_a_transformer,
    wire_with_a_loose_plug,
    wire_whose_register_runs_over,
]
"""The cases of this file."""
