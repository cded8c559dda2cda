"""Simulated cases of counts: deer before a camera, neutrons in a monitor, misprints of a page, tickets of a booking."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def passing(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many deer pass a camera in a night: some places are liked better than others."""
    return rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1]))


def neutrons(theta: NDArray, rng: Rng) -> NDArray:
    """Return the neutrons that a tube counts in a second: hadrons hit the lead, and each sets free a number of them."""
    return rng.poisson(theta[:, 1] * rng.poisson(theta[:, 0]))


def misprints(theta: NDArray, rng: Rng) -> NDArray:
    """Return the misprints of a page; one page in ten is the last of a chapter, and filled in part."""
    n = len(theta)
    return rng.poisson(theta[:, 0] * np.where(some(rng, n, 0.1), rng.uniform(0.3, 1.0, n), 1.0))


def tickets(theta: NDArray, rng: Rng) -> NDArray:
    """Return the tickets of a booking: somebody and a number of friends, each of whom may bring a partner."""
    people = 1 + rng.poisson(theta[:, 0])
    return people + rng.binomial(people, theta[:, 1])


DEER = task(passing, prior={"rate": (3, 40), "evenness": (0.8, 10)}, features=["deer"], name="camera-traps")
MONITOR = task(
    neutrons, prior={"hadrons": (2, 20), "multiplicity": (0.5, 5)}, features=["neutrons"], name="neutron-monitor"
)
MISPRINTS = task(misprints, prior={"rate": (2, 40)}, features=["misprints"], name="misprints")
TICKETS = task(tickets, prior={"friends": (0.5, 8), "couples": (0.05, 0.95)}, features=["tickets"], name="ticket-sales")


@case(DEER, "single", right=("censoring",))
def deer_on_a_full_card(rng: Rng) -> NDArray:
    """When the card of the camera is full, no further deer is seen: the count of such a night is what the card holds.

    This depends a little on how bright the pictures are: 27 to 30 fit on it. One camera in eight has a larger card.
    """
    n = 1500
    holds = np.where(some(rng, n, 1 / 8), 60, rng.choice([27, 28, 29, 30], n, p=[0.1, 0.25, 0.45, 0.2]))
    return np.minimum(one(DEER, rng, n, 17.0, 2.4), holds)


@case(
    DEER,
    "pair",
    right=("dead_time", "zero_inflation"),
    defensible=("mixture", "inefficiency", "overdispersion", "flat_background"),
)
def deer_during_the_pause_and_empty_batteries(rng: Rng) -> NDArray:
    """After each picture the camera pauses for 2 % of the night, and twice as long while its flash must be recharged.

    At 5 % of the cameras the battery was empty: two thirds of these saw nothing, the others a small part of the night.
    """
    n = 2700
    x = one(DEER, rng, n, 21.0, 6.5)
    times = np.sort(np.where(np.arange(x.max()) < x[:, None], rng.random((n, x.max())), np.inf), axis=1)
    free, seen = np.zeros(n), np.zeros(n, dtype=int)
    for t in times.T:
        hit = np.isfinite(t) & (t >= free)
        seen += hit
        free = np.where(hit, t + np.where(some(rng, n, 0.2), 0.04, 0.02), free)
    u = rng.random(n)
    return np.where(u < 0.033, 0, np.where(u < 0.05, rng.binomial(seen, rng.uniform(0.05, 0.3, n)), seen))


@case(DEER, "outside")
def deer_told_by_telephone(rng: Rng) -> NDArray:
    """German foresters tell counts by telephone, and say the ones before the tens: 31 is often written as 13.

    Of the numbers from 21 to 99, other than whole tens, 45 % have their digits exchanged. Such a count is neither
    rounded, nor lost, nor one that has nothing to do with the deer: it is another number of the same digits.
    """
    x = one(DEER, rng, 8600, 27.0, 5.5)
    swapped = 10 * (x % 10) + x // 10
    return np.where((x > 20) & (x < 100) & (x % 10 > 0) & some(rng, len(x), 0.45), swapped, x)


@case(MONITOR, "single", right=("quantisation",), defensible=("heaping",))
def neutrons_divided_by_four(rng: Rng) -> NDArray:
    """In one old station of three the scaler passes on each fourth pulse only, and the reading is taken times four.

    What is left over goes on into the next second, so that a count is rounded up or down with the rest as its chance.
    """
    n = 4800
    x = one(MONITOR, rng, n, 9.0, 1.6)
    return np.where(some(rng, n, 1 / 3), (x + rng.integers(0, 4, n)) // 4 * 4, x)


@case(
    MONITOR,
    "single",
    right=("readout_noise",),
    defensible=("flat_background", "mixture", "overdispersion", "spread", "quantisation", "pile_up"),
)
def neutrons_with_bits_upset(rng: Rng) -> NDArray:
    """A noisy line from the mountain turns over one bit in 3 % of the numbers that it sends.

    Each of the lowest seven bits may be hit, but that of 32, whose contact is bad, is in a third of the cases.
    """
    n = 11500
    x = one(MONITOR, rng, n, 6.5, 2.2)
    bit = rng.choice(7, n, p=[0.11, 0.11, 0.11, 0.11, 0.11, 0.34, 0.11])
    return np.where(some(rng, n, 0.03), x ^ (1 << bit), x)


@case(
    MONITOR,
    "pair",
    right=("truncation", "zero_inflation"),
    defensible=("mixture", "flat_background", "censoring"),
)
def neutrons_without_spikes_and_high_voltage(rng: Rng) -> NDArray:
    """A filter takes high counts for spikes: it drops half of those of 27, fewer of those below, and most above.

    In 2.5 % of the seconds the high voltage had tripped: in half of these nothing is counted, else up to a third.
    """
    n = 21000
    x = one(MONITOR, rng, n, 8.0, 2.3)
    x = x[rng.random(n) < 1 / (1 + np.exp((x - 27) / 0.8))]
    u = rng.random(len(x))
    weak = rng.binomial(x, rng.uniform(0.0, 1 / 3, len(x)))
    return np.where(u < 0.0125, 0, np.where(u < 0.025, weak, x))


@case(
    MISPRINTS,
    "single",
    right=("double_counting",),
    defensible=("overdispersion", "spread", "mixture", "pile_up"),
)
def misprints_that_lead_to_others(rng: Rng) -> NDArray:
    """A misprint distracts the typist, so that with a chance of 16 % he makes another, which may lead to one more.

    Late in the day, on one page of four, the chance is 33 %.
    """
    n = 850
    x = one(MISPRINTS, rng, n, 11.0)
    follows = np.where(some(rng, n, 0.25), 0.33, 0.16)
    return x + np.where(x > 0, rng.negative_binomial(np.maximum(x, 1), 1 - follows), 0)


@case(MISPRINTS, "single", right=("mixture",), defensible=("overdispersion", "spread", "flat_background", "pile_up"))
def misprints_of_the_apprentice(rng: Rng) -> NDArray:
    """The master set most of the book, with 7 misprints on a page, and his apprentice a sixth of it, with 16."""
    n = 480
    apprentice = some(rng, n, 1 / 6)
    return np.where(apprentice, one(MISPRINTS, rng, n, 16.0), one(MISPRINTS, rng, n, 7.0))


@case(MISPRINTS, "outside")
def misprints_by_which_editions_differ(rng: Rng) -> NDArray:
    """The table says by how many misprints the two editions of a page differ, whichever has more of them.

    So an event is the size of the difference of two counts. Many are small or nothing, but not since misprints were
    missed or pages left out: each page was counted well, twice, and the difference is no count of misprints at all.
    """
    n = 3600
    return np.abs(one(MISPRINTS, rng, n, 23.0) - one(MISPRINTS, rng, n, 23.0))


@case(TICKETS, "single", right=("truncation",))
def tickets_of_large_groups_by_letter(rng: Rng) -> NDArray:
    """Large groups book by letter, and are not in the list of the web shop: seven in ten of those of ten tickets.

    Of groups of eight one in eight writes a letter, and of those of twelve or more nobody books in the shop.
    """
    x = one(TICKETS, rng, 2300, 3.9, 0.45)
    by_letter = np.select([x >= 12, x == 11, x == 10, x == 9, x == 8], [1.0, 0.9, 0.7, 0.4, 0.125], 0.0)
    return x[rng.random(len(x)) > by_letter]


@case(
    TICKETS,
    "pair",
    right=("threshold_loss", "double_counting"),
    defensible=("pile_up", "mixture", "spread", "overdispersion"),
)
def tickets_without_lone_seats_of_one_account(rng: Rng) -> NDArray:
    """The shop refuses what would leave a lone seat: 75 % of the bookings of one ticket, and 20 % of those of three.

    It enters two bookings as one if a customer comes back within the hour, as 11 % of them do.
    """
    n = 18500
    x = one(TICKETS, rng, n, 2.2, 0.6)
    x = x[rng.random(n) > np.select([x == 1, x == 3], [0.75, 0.2], 0.0)]
    again = rng.permutation(x)
    return np.where(some(rng, len(x), 0.11), x + again, x)


@case(TICKETS, "outside")
def tickets_for_the_price_of_a_group(rng: Rng) -> NDArray:
    """From ten tickets on each is cheaper by a fifth, so that who needs eight or nine buys ten, as do a few with seven.

    Counts of seven to nine are moved up to ten. There is no heap at another ten, and none comes down to it from above,
    as in rounding; nobody with more is recorded as ten, as at a limit; and no booking is lost.
    """
    x = one(TICKETS, rng, 6400, 4.8, 0.5)
    cheaper = np.select([x == 9, x == 8, x == 7], [0.8, 0.65, 0.15], 0.0)
    return np.where(rng.random(len(x)) < cheaper, 10, x)


CASES: list[Case] = [
    plain("deer_alone", DEER, 640, 12.0, 3.6),
    plain("neutrons_alone", MONITOR, 28000, 12.0, 1.3),
    plain("misprints_alone", MISPRINTS, 330, 16.0),
    plain("tickets_alone", TICKETS, 1100, 1.9, 0.35),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
