"""Simulated cases of counts: spots on the sun, loans of library books, lice on salmon, particles in the air."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def spots(theta: NDArray, rng: Rng) -> NDArray:
    """Return the spots on the sun on a day: of some groups, each with one spot and a geometric number of further ones.

    Days of one part of the solar cycle are alike.
    """
    groups = rng.poisson(theta[:, 0])
    return groups + rng.poisson(theta[:, 1] * rng.standard_gamma(groups))


def loans(theta: NDArray, rng: Rng) -> NDArray:
    """Return the loans of a library book in ten years: Poisson, with a demand that is gamma over the titles."""
    return rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1]))


def lice(theta: NDArray, rng: Rng) -> NDArray:
    """Return the sea lice on a farmed salmon: larvae come in clumps, of which some more or fewer settle on a fish.

    Those of a clump that settle are one or two.
    """
    clumps = rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1] / 1.3))
    return clumps + rng.binomial(clumps, 0.3)


def particles(theta: NDArray, rng: Rng) -> NDArray:
    """Return the particles that an aerosol counter sees in a second: in turbulent air their density is lognormal."""
    eddies = np.exp(theta[:, 1] * rng.standard_normal(len(theta)) - theta[:, 1] ** 2 / 2)
    return rng.poisson(theta[:, 0] * eddies)


SUN = task(spots, prior={"groups": (0.5, 10), "further": (0.3, 8)}, features=["spots"], name="sunspots")
LIBRARY = task(loans, prior={"mean": (1, 40), "evenness": (0.5, 8)}, features=["loans"], name="library-loans")
SALMON = task(lice, prior={"mean": (1, 30), "evenness": (0.8, 12)}, features=["lice"], name="salmon-lice")
AEROSOL = task(
    particles, prior={"mean": (10, 300), "turbulence": (0.02, 0.6)}, features=["particles"], name="aerosol-counter"
)


@case(SUN, "single", right=("zero_inflation",), defensible=("mixture", "overdispersion", "spread", "flat_background"))
def sunspots_of_cloudy_days(rng: Rng) -> NDArray:
    """Whoever copied the old diaries entered a day without a remark as one without spots; most had just been cloudy.

    In winter, a third of the days, that makes 36 % of the days zero, and in the other seasons 13 %.
    """
    n = 420
    x = one(SUN, rng, n, 4.6, 2.8)
    blank = some(rng, n, np.where(some(rng, n, 1 / 3), 0.36, 0.13))
    return np.where(blank, 0, x)


@case(
    SUN,
    "pair",
    right=("quantisation", "threshold_loss"),
    defensible=("heaping",),
)
def sunspots_of_a_busy_observer(rng: Rng) -> NDArray:
    """A crowded sun is estimated, not counted: from some 15 spots on, two numbers in three are multiples of five.

    Where estimating sets in differs from day to day with the seeing. A sun without spots was seldom worth an entry:
    four of five such days are lost, and a third of those with one spot.
    """
    x = one(SUN, rng, 7000, 3.1, 3.6)
    x = x[rng.random(len(x)) > np.select([x == 0, x == 1], [0.8, 0.33], 0.0)]
    n = len(x)
    guessed = (x > rng.normal(15.0, 2.5, n)) & some(rng, n, 0.67)
    return np.where(guessed, 5 * np.round((x + rng.normal(0, 0.8, n)) / 5), x).astype(int)


@case(SUN, "outside")
def sunspots_by_the_formula_of_wolf(rng: Rng) -> NDArray:
    """The column is not of spots, but of Wolf's relative number: ten times the groups, and the spots on top.

    So no day has 1 to 10, and numbers crowd above each multiple of ten, as 11, 12, 22. No spot was lost, added twice
    or rounded: each group weighs ten, and what a group is the events do not say.
    """
    n = 550
    groups = rng.poisson(2.3, n)
    return 10 * groups + groups + rng.poisson(0.8 * rng.standard_gamma(groups))


@case(LIBRARY, "single", right=("censoring",), defensible=("truncation", "quantisation", "peak_background"))
def loans_on_a_full_date_slip(rng: Rng) -> NDArray:
    """Loans are the stamps on the date slip in a book, which has 24 lines, or 20 if it is an old one, one in four.

    When it is full most clerks stamp over older dates, so that the slip has no more. One book in eight got a second
    slip below the first, and shows all its loans.
    """
    n = 760
    x = one(LIBRARY, rng, n, 15.0, 2.6)
    lines = np.where(some(rng, n, 0.25), 20, 24)
    return np.where(some(rng, n, 1 / 8), x, np.minimum(x, lines))


@case(LIBRARY, "single", right=("threshold_loss",), defensible=("edge_acceptance", "turn_on"))
def loans_after_the_shelves_were_weeded(rng: Rng) -> NDArray:
    """Books that hardly anybody borrowed were thrown out: of those with up to 4 loans about three in four.

    The librarian of each room drew the line elsewhere, between some 3 and 7 loans, and spared one book in five.
    """
    x = one(LIBRARY, rng, 6300, 12.0, 1.8)
    n = len(x)
    weeded = (x < rng.normal(5.2, 1.0, n)) & some(rng, n, 0.8)
    return x[~weeded]


@case(
    LIBRARY,
    "pair",
    right=("zero_inflation", "truncation"),
    defensible=("mixture", "overdispersion", "spread"),
)
def loans_of_lost_and_of_worn_books(rng: Rng) -> NDArray:
    """One book in nine stands on a wrong shelf and was never lent; a few of these were found once by accident.

    A book falls apart after 30 to 40 loans, sooner or later, and is taken out of the catalogue with its record.
    """
    n = 13000
    x = one(LIBRARY, rng, n, 19.0, 3.2)
    x = np.where(some(rng, n, 1 / 9), some(rng, n, 0.06), x).astype(int)
    return x[x < 26 + rng.gamma(4.0, 2.2, n)]


@case(
    SALMON,
    "single",
    right=("mixture",),
    defensible=("zero_inflation", "overdispersion", "spread", "flat_background", "double_counting"),
)
def lice_of_a_treated_pen(rng: Rng) -> NDArray:
    """One fish in four is of a pen that had been bathed against lice some weeks before: it has 2.2 lice, not 14.

    Lice settle on these fish as on all others, but at another mean, and a little less evenly.
    """
    n = 1000
    bathed = some(rng, n, 0.25)
    return np.where(bathed, one(SALMON, rng, n, 2.2, 3.5), one(SALMON, rng, n, 14.0, 6.0))


@case(
    SALMON,
    "pair",
    right=("double_counting", "censoring"),
    defensible=("pile_up", "mixture", "overdispersion", "spread", "flat_background", "truncation"),
)
def lice_of_two_fish_in_a_tub(rng: Rng) -> NDArray:
    """When it has to go fast two salmon lie in a tub, and the lice of both are entered as of one: 17 % of the entries.

    The form has boxes to tick up to 25 lice, and the last is ticked for all that have more. On the newer form, used
    for one entry in ten, the last box is 30.
    """
    n = 1900
    x = one(SALMON, rng, n, 9.5, 8.5)
    x = np.where(some(rng, n, 0.17), x + one(SALMON, rng, n, 9.5, 8.5), x)
    return np.minimum(x, np.where(some(rng, n, 0.1), 30, 25))


@case(SALMON, "outside")
def lice_typed_on_a_wet_screen(rng: Rng) -> NDArray:
    """The tablet takes a second tap on the same key for a bounce, and drops it: 11 becomes 1, 22 becomes 2, 33 is 3.

    That happens to seven in ten such numbers, as fast typists are, and to no other: nothing is rounded or missed.
    So single numbers have holes, and as many fish turn up at a number that has nothing to do with theirs.
    """
    n = 22000
    x = one(SALMON, rng, n, 17.0, 4.0)
    return np.where((x > 9) & (x < 100) & (x % 11 == 0) & some(rng, n, 0.7), x // 11, x)


@case(AEROSOL, "single", right=("dead_time",), defensible=("inefficiency", "truncation", "censoring"))
def aerosol_with_two_in_the_beam(rng: Rng) -> NDArray:
    """A particle that enters the beam while another is still in it makes no pulse of its own, but prolongs that one.

    Flights last 2.8 ms in the mean, longer near the walls of the jet, at 210 particles a second in the still air of a
    cellar. So busy seconds lose most, and the counts come to scatter less than any in the simulator.
    """
    n = 2600
    number = one(AEROSOL, rng, n, 210.0, 0.11)
    shape = (n, int(number.max()))
    start = np.sort(np.where(np.arange(shape[1]) < number[:, None], rng.random(shape), np.inf), axis=1)
    busy = np.maximum.accumulate(start + rng.gamma(3.0, 0.0028 / 3, shape), axis=1)
    begins = np.isfinite(start)
    begins[:, 1:] &= start[:, 1:] > busy[:, :-1]
    return begins.sum(axis=1)


@case(
    AEROSOL,
    "single",
    right=("flat_background",),
    defensible=("mixture", "overdispersion", "spread", "pile_up", "double_counting"),
)
def aerosol_beside_a_road(rng: Rng) -> NDArray:
    """In 6 % of the seconds the plume of a passing car is drawn in, and its particles come on top of those of the air.

    How many depends on how near and how dirty the car was: about an exponential number, 60 in the mean, and four
    times that for a lorry, which is one in twelve.
    """
    n = 16000
    plume = rng.poisson(rng.exponential(np.where(some(rng, n, 1 / 12), 240.0, 60.0)))
    return one(AEROSOL, rng, n, 48.0, 0.17) + np.where(some(rng, n, 0.06), plume, 0)


@case(AEROSOL, "outside")
def aerosol_in_seven_bits(rng: Rng) -> NDArray:
    """The register of the counter has seven bits, and nobody kept the carry: after 127 particles it starts at 0 again.

    What is read is the remainder by 128. Seconds with many particles are neither lost nor kept at the end of the
    scale, but come back at its beginning, each by the same 128.
    """
    return one(AEROSOL, rng, 3500, 108.0, 0.22) % 128


CASES: list[Case] = [
    plain("sunspots_as_drawn", SUN, 30000, 2.2, 4.4),
    plain("loans_of_a_branch_library", LIBRARY, 8800, 9.0, 1.3),
    plain("lice_of_one_pen", SALMON, 300, 6.5, 3.0),
    plain("aerosol_of_clean_air", AEROSOL, 1400, 75.0, 0.31),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
