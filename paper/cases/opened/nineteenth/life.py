"""Simulated cases out of life: newborn babies, ski jumps and used cars; heart beats, wages and litters of sows."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator


def newborn(theta: NDArray, rng: Rng) -> NDArray:
    """Return the age of a newborn since the last period in weeks, its weight in g, and the girth of its head in cm."""
    n = len(theta)
    age = theta[:, 0] + 1.2 * rng.standard_normal(n) - theta[:, 1] * rng.standard_exponential(n)
    late = age - 40
    weight = theta[:, 2] * np.exp(0.06 * late - 0.0025 * late**2 + theta[:, 3] * rng.standard_normal(n))
    head = 34.8 * (weight / 3500) ** 0.3 * np.exp(0.028 * rng.standard_normal(n))
    return np.stack([age, weight, head], axis=1)


NEWBORNS = task(
    newborn,
    prior={"term": (38, 42), "early": (0.2, 2.2), "weight": (2600, 4300), "scatter": (0.06, 0.22)},
    features=["age", "weight", "head"],
    name="newborns",
)


@case(
    NEWBORNS,
    "single",
    right=("resolution on age",),
    defensible=("spread", "outliers on age", "conditional_response on age", "conditional_response on weight"),
)
def newborns_dated_by_hand(rng: Rng) -> NDArray:
    """No scan was made: the midwife felt how high the womb stood, and reckoned the age of the child from that.

    She is wrong by some eleven days either way. More early births take up a part, but the weight follows less well.
    """
    x = draw(NEWBORNS, rng, 1000, 40.6, 0.8, 3250.0, 0.12)
    x[:, 0] += np.where(some(rng, 1000, 0.4), 1.9, 1.4) * rng.standard_normal(1000)
    return x


@case(
    NEWBORNS,
    "single",
    right=("edge_acceptance on age",),
    defensible=("edge_acceptance on weight", "edge_acceptance on head", "dead_region on age"),
)
def newborns_sent_to_the_city(rng: Rng) -> NDArray:
    """Women about to give birth before the 36th week or so are driven to the city, and nearly none is listed here."""
    x = draw(NEWBORNS, rng, 9000, 40.9, 1.7, 3750.0, 0.11)
    return x[~some(rng, len(x), 0.92 / (1 + np.exp((x[:, 0] - 36.0) / 0.5)))]


@case(
    NEWBORNS,
    "pair",
    right=("quantisation on weight", "offset on age"),
    defensible=("outliers on age", "radiative_tail on age", "peak_background on age", "resolution on age", "mixture"),
)
def newborns_in_the_old_book(rng: Rng) -> NDArray:
    """In the old book half the weights are whole half-pounds, and one age of eight is too short by about four weeks.

    A bleeding early in pregnancy had been taken for the last period, so that the child seemed a month younger.
    """
    x = draw(NEWBORNS, rng, 5000, 40.5, 0.6, 3450.0, 0.13)
    x[:, 1] = np.where(some(rng, 5000, 0.5), 250 * np.round(x[:, 1] / 250), x[:, 1])
    x[:, 0] -= some(rng, 5000, 0.125) * (4.0 + 0.5 * rng.standard_normal(5000))
    return x


@case(NEWBORNS, "outside")
def newborns_asked_for_a_study(rng: Rng) -> NDArray:
    """Babies just as heavy as the growth chart wants them at their age went to a study, and were struck off the list.

    Gone are eight of ten with a weight within 4 % of the line of the chart, which runs slantwise through the two.
    """
    x = draw(NEWBORNS, rng, 8000, 40.4, 1.9, 3650.0, 0.12)
    late = x[:, 0] - 40
    away = np.log(x[:, 1] / 3650) - 0.06 * late + 0.0025 * late**2
    return x[~((np.abs(away) < 0.04) & some(rng, len(x), 0.8))]


def ski_jump(theta: NDArray, rng: Rng) -> NDArray:
    """Return the speed at the take-off in km/h, the distance of a ski jump in m, and the sum of the marks for style."""
    n = len(theta)
    speed, form = theta[:, 0] + 0.5 * rng.standard_normal(n), rng.standard_normal(n)
    distance = theta[:, 1] + 4 * (speed - theta[:, 0]) + theta[:, 2] * form + 2.5 * rng.standard_normal(n)
    marks = theta[:, 3] + 1.4 * form + 0.9 * rng.standard_normal(n)
    return np.stack([speed, distance, marks], axis=1)


SKI_JUMPS = task(
    ski_jump,
    prior={"speed": (84, 96), "distance": (95, 140), "form": (3, 14), "style": (44, 54)},
    features=["speed", "distance", "marks"],
    name="ski-jumps",
)


@case(
    SKI_JUMPS,
    "single",
    right=("radiative_tail on marks",),
    defensible=("outliers on marks", "peak_background on marks", "flat_background", "offset on marks", "mixture"),
)
def ski_jumps_badly_landed(rng: Rng) -> NDArray:
    """One jumper of six staggers, grips the snow or falls: he loses a point or two, or more, at the worst 18."""
    x = draw(SKI_JUMPS, rng, 1200, 88.0, 108.0, 9.5, 51.5)
    x[:, 2] -= some(rng, 1200, 0.17) * 18 * rng.beta(0.9, 2.6, 1200)
    return x


@case(
    SKI_JUMPS,
    "single",
    right=("edge_acceptance on distance",),
    defensible=("edge_acceptance on marks", "forward_backward_acceptance on distance", "dead_region on distance"),
)
def ski_jumps_of_the_second_round(rng: Rng) -> NDArray:
    """Only the second round is listed, to which those are admitted who have jumped far enough in the first.

    Most of the short jumps are absent, which a greater mean distance and more even form take up for a good part.
    """
    x = draw(SKI_JUMPS, rng, 2600, 91.5, 112.0, 11.0, 47.0)
    return x[x[:, 1] + 4.0 * rng.standard_normal(len(x)) > 108.0 + rng.standard_normal(len(x))]


@case(
    SKI_JUMPS,
    "single",
    right=("conditional_response on marks",),
    defensible=("saturation on marks", "radiative_tail on marks", "conditional_response on distance"),
)
def ski_jumps_into_the_flat(rng: Rng) -> NDArray:
    """Where the hill grows flat nobody can land with one foot before the other, and each judge takes points off for it.

    From 120 m on one point in five metres is lost, or twice that, or nothing. The short jumps have their marks.
    """
    x = draw(SKI_JUMPS, rng, 700, 93.0, 122.0, 9.0, 50.0)
    x[:, 2] -= 0.2 * np.clip(x[:, 1] - 120.0, 0, None) * rng.uniform(0, 2, 700)
    return x


@case(SKI_JUMPS, "outside")
def ski_jumps_with_the_marks_of_another(rng: Rng) -> NDArray:
    """The sheets were copied with a line slipped at times: two jumps of five have the marks of another jumper."""
    x = draw(SKI_JUMPS, rng, 1500, 87.0, 125.0, 8.0, 49.5)
    slipped = np.column_stack([x[:, :2], np.roll(x[:, 2], 1)])
    return either(some(rng, 1500, 0.4), slipped, x)


def used_car(theta: NDArray, rng: Rng) -> NDArray:
    """Return the age of a car for sale in years, how far it has gone in 1000 km, and its price in 1000 euros."""
    n = len(theta)
    age = theta[:, 0] * rng.gamma(3.0, 1 / 3, n)
    way = theta[:, 1] * age * np.exp(0.4 * rng.standard_normal(n))
    price = theta[:, 2] * np.exp(-theta[:, 3] * age - 0.002 * way + 0.12 * rng.standard_normal(n))
    return np.stack([age, way, price], axis=1)


USED_CARS = task(
    used_car,
    prior={"mean_age": (3, 12), "yearly": (7, 25), "new": (12, 50), "decline": (0.04, 0.2)},
    features=["age", "mileage", "price"],
    name="used-cars",
)


@case(
    USED_CARS,
    "single",
    right=("saturation on mileage",),
    defensible=(
        "scale on mileage",
        "radiative_tail on mileage",
        "edge_acceptance on mileage",
        "outliers on mileage",
        "peak_background on mileage",
        "conditional_response on mileage",
    ),
)
def used_cars_with_clocks_turned_back(rng: Rng) -> NDArray:
    """The mileage of every second car that has gone more than 150 000 km was turned back to something that sells.

    It now stands anywhere between 105 000 and 150 000 km, mostly near the upper end. The price is that of the true way.
    """
    x = draw(USED_CARS, rng, 2000, 7.2, 18.0, 28.0, 0.11)
    turned = (x[:, 1] > 150) & some(rng, 2000, 0.5)
    x[:, 1] = np.where(turned, 150 - 45 * rng.beta(1.1, 2.2, 2000), x[:, 1])
    return x


@case(
    USED_CARS,
    "single",
    right=("peak_background on age",),
    defensible=("outliers on age", "quantisation on age", "flat_background on age"),
)
def used_cars_of_the_preset_year(rng: Rng) -> NDArray:
    """The form on the website is filled in with a day in January five years ago, and one seller of 14 leaves it so.

    The adverts were gathered in two months of spring, so that such a car seems to be from 5.2 to 5.37 years old.
    """
    x = draw(USED_CARS, rng, 3200, 8.5, 12.0, 22.0, 0.14)
    x[:, 0] = np.where(some(rng, 3200, 1 / 14), rng.uniform(5.2, 5.37, 3200), x[:, 0])
    return x


@case(
    USED_CARS,
    "single",
    right=("conditional_response on price",),
    defensible=("scale on price", "saturation on price", "mixture", "spread", "conditional_response on age"),
)
def used_cars_shut_out_of_towns(rng: Rng) -> NDArray:
    """Towns shut out the engines of the old standard, which ended some seven years ago: those cars have become cheap.

    They are worth from 10 to 30 % less. A faster decline of the price takes up a part of it, but for the step.
    """
    x = draw(USED_CARS, rng, 2500, 6.4, 14.5, 33.0, 0.09)
    old = some(rng, 2500, 1 / (1 + np.exp((7.0 - x[:, 0]) / 0.25)))
    x[:, 2] *= 1 - old * rng.uniform(0.1, 0.3, 2500)
    return x


@case(
    USED_CARS,
    "pair",
    right=("quantisation on mileage", "outliers on price"),
    defensible=("radiative_tail on price", "scale on price", "flat_background", "peak_background on price", "mixture"),
)
def used_cars_of_private_sellers(rng: Rng) -> NDArray:
    """Four sellers of ten round the mileage to tens of thousands, and a few give a price that nobody will sell at.

    Six of a hundred write anything from a fiftieth to a half of what they want, only to be looked at.
    """
    x = draw(USED_CARS, rng, 6000, 5.8, 16.0, 18.5, 0.08)
    x[:, 1] = np.where(some(rng, 6000, 0.4), 10 * np.round(x[:, 1] / 10), x[:, 1])
    x[:, 2] *= np.where(some(rng, 6000, 0.06), rng.uniform(0.02, 0.5, 6000), 1)
    return x


def heart_beat(theta: NDArray, rng: Rng) -> NDArray:
    """Return the time from a heart beat to the next in ms: it grows and shrinks with the breath, and scatters too."""
    n = len(theta)
    breath = theta[:, 1] * np.sin(2 * np.pi * rng.random(n))
    return (theta[:, 0] * np.exp(breath + theta[:, 2] * rng.standard_normal(n)))[:, None]


HEART_BEATS = task(
    heart_beat,
    prior={"mean": (550, 1250), "breath": (0.01, 0.15), "scatter": (0.01, 0.09)},
    features=["interval"],
    name="heart-beats",
)


@case(HEART_BEATS, "single", right=("saturation",), defensible=("peak_background", "edge_acceptance", "quantisation"))
def heart_beats_with_a_pacemaker(rng: Rng) -> NDArray:
    """A pacemaker beats in place of a heart that has not done so for 1000 ms; of such waits one in ten escapes it."""
    x = draw(HEART_BEATS, rng, 1500, 925.0, 0.05, 0.055)
    paced = (x > 1000) & ~some(rng, 1500, 0.1)[:, None]
    return np.where(paced, 1000 + 1.5 * rng.standard_normal((1500, 1)), x)


@case(
    HEART_BEATS,
    "single",
    right=("outliers",),
    defensible=("flat_background", "radiative_tail", "resolution", "mixture", "spread", "peak_background"),
)
def heart_beats_out_of_turn(rng: Rng) -> NDArray:
    """Three beats of a hundred come out of turn, much too early, and after most of them the heart rests for longer."""
    x = draw(HEART_BEATS, rng, 4500, 780.0, 0.045, 0.025)[:, 0]
    gone = some(rng, 4500, 0.03) * rng.uniform(0.25, 0.5, 4500)
    rest = some(rng, 4500, 0.8) * np.roll(gone, 1) * rng.uniform(0.8, 1.0, 4500)
    return (x * (1 - gone + rest))[:, None]


@case(
    HEART_BEATS,
    "single",
    right=("spread", "mixture"),
    defensible=("offset", "scale", "peak_background", "radiative_tail", "resolution"),
)
def heart_beats_sitting_and_lying(rng: Rng) -> NDArray:
    """The patient lay for a third of the time and sat for the rest, and when he lies his heart is slower by 90 ms.

    It takes a while to settle, so the difference is not always the same. A deeper breath resembles a part of it.
    """
    x = draw(HEART_BEATS, rng, 2500, 730.0, 0.03, 0.03)
    return x + some(rng, 2500, 0.33)[:, None] * (90 + 12 * rng.standard_normal((2500, 1)))


@case(HEART_BEATS, "outside")
def heart_beats_between_messages(rng: Rng) -> NDArray:
    """The belt sends a message every 60 ms from the last beat on, and hears no beat in the 14 ms that it takes."""
    x = draw(HEART_BEATS, rng, 4000, 1050.0, 0.08, 0.05)
    into = np.mod(x[:, 0], 60.0)
    return x[into > 14.0 + rng.standard_normal(len(x))]


def wage(theta: NDArray, rng: Rng) -> NDArray:
    """Return what a worker earns in an hour, in euros: a middle, a scatter about it, and a tail of those who rose."""
    rise = theta[:, 2] * rng.standard_exponential(len(theta))
    return (theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta)) + rise))[:, None]


WAGES = task(
    wage,
    prior={"middle": (9, 30), "scatter": (0.1, 0.6), "tail": (0.05, 0.4)},
    features=["wage"],
    name="wages",
)


@case(WAGES, "single", right=("offset",), defensible=("scale", "edge_acceptance", "radiative_tail"))
def wages_with_money_for_the_way(rng: Rng) -> NDArray:
    """The firms have reported the wage with the money for the way to work in it, which is the same for poor and rich.

    It makes about 7.50 euros an hour, more for those who live far off. A smaller scatter would do nearly the same.
    """
    return draw(WAGES, rng, 30000, 12.5, 0.48, 0.12) + 7.0 + 0.5 * rng.gamma(2.0, 0.5, (30000, 1))


@case(
    WAGES,
    "single",
    right=("flat_background",),
    defensible=("outliers", "radiative_tail", "peak_background", "mixture", "spread"),
)
def wages_made_up_at_the_door(rng: Rng) -> NDArray:
    """One interviewer has made up his wages, three of a hundred: anything from 3 to 60 euros, as it came."""
    return either(some(rng, 7000, 0.03), rng.uniform(3, 60, (7000, 1)), draw(WAGES, rng, 7000, 16.5, 0.17, 0.1))


@case(WAGES, "pair", right=("saturation", "quantisation"), defensible=("edge_acceptance", "peak_background"))
def wages_by_law_and_from_memory(rng: Rng) -> NDArray:
    """By law nobody may earn less than 12.41 euros, and most who did now earn just that; a third name whole euros.

    One of ten firms does not obey. Those who answer from memory do know the wage of the law.
    """
    x = draw(WAGES, rng, 5000, 14.0, 0.24, 0.15)
    at_law = (x < 12.41) & some(rng, 5000, 0.9)[:, None]
    rounded = np.where(some(rng, 5000, 0.35)[:, None], np.round(x), x)
    return np.where(at_law, 12.41, rounded)


def litter(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many piglets of a sow are born alive, of the eggs that she had: some litters fare better."""
    eggs = np.clip(np.rint(theta[:, 0] + 2.5 * rng.standard_normal(len(theta))), 0, None).astype(np.int64)
    return rng.binomial(eggs, rng.beta(40 * theta[:, 1], 40 * (1 - theta[:, 1])))


LITTERS = task(litter, prior={"eggs": (12, 32), "survival": (0.3, 0.95)}, features=["piglets"], name="litters-of-sows")


@case(LITTERS, "single", right=("threshold_loss",))
def litters_broken_up(rng: Rng) -> NDArray:
    """Sows with few piglets are not worth a pen: the piglets are put to other sows, and no card is written.

    It is done with nearly all litters below eight, with some of eight to ten. Fewer eggs that fare better resemble it.
    """
    x = draw(LITTERS, rng, 3500, 21.0, 0.5)
    return x[~some(rng, len(x), np.interp(x.ravel(), [6, 8, 10, 11], [0.95, 0.75, 0.15, 0.0]))]


@case(
    LITTERS,
    "pair",
    right=("zero_inflation", "censoring"),
    defensible=("truncation", "dead_time", "quantisation", "mixture", "overdispersion"),
)
def litters_on_the_cards(rng: Rng) -> NDArray:
    """Six sows of a hundred did not conceive: their cards say none. No more than 14 are left to one, as she has teats.

    The piglets beyond are put on another card, save in the weeks when nobody has the time, which are one of eight.
    """
    x = draw(LITTERS, rng, 1600, 18.5, 0.72)
    return np.where(rng.random(x.shape) < 7 / 8, np.minimum(x, 14), x) * (rng.random(x.shape) > 0.06)


@case(LITTERS, "outside")
def litters_with_a_bonus(rng: Rng) -> NDArray:
    """The stockman has a bonus for litters from twelve on, and writes half those of eleven as twelve, a few of ten."""
    x = draw(LITTERS, rng, 2800, 17.0, 0.68)
    return np.where(rng.random(x.shape) < 0.5 * (x == 11) + 0.25 * (x == 10), 12, x)


CASES: list[Case] = [
    plain("newborns_plain", NEWBORNS, 3000, 40.7, 1.0, 3600.0, 0.15),
    plain("ski_jumps_plain", SKI_JUMPS, 800, 92.0, 128.0, 6.5, 51.0),
    plain("used_cars_plain", USED_CARS, 5000, 6.1, 13.0, 36.0, 0.1),
    plain("wages_plain", WAGES, 15000, 17.0, 0.27, 0.18),
    plain("litters_plain", LITTERS, 2200, 19.0, 0.6),
    newborns_dated_by_hand,
    newborns_sent_to_the_city,
    newborns_in_the_old_book,
    newborns_asked_for_a_study,
    ski_jumps_badly_landed,
    ski_jumps_of_the_second_round,
    ski_jumps_into_the_flat,
    ski_jumps_with_the_marks_of_another,
    used_cars_with_clocks_turned_back,
    used_cars_of_the_preset_year,
    used_cars_shut_out_of_towns,
    used_cars_of_private_sellers,
    heart_beats_with_a_pacemaker,
    heart_beats_out_of_turn,
    heart_beats_sitting_and_lying,
    heart_beats_between_messages,
    wages_with_money_for_the_way,
    wages_made_up_at_the_door,
    wages_by_law_and_from_memory,
    litters_broken_up,
    litters_on_the_cards,
    litters_with_a_bonus,
]
"""The cases of this file."""
