"""Simulated cases of counts: asbestos fibres, loaves of a bakery, crossovers in meiosis, passes of bats."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from avobench.tasks import Task
from paper.cases.case import Case, case, draw, plain, some

Rng = np.random.Generator
BIVALENTS = 19


def one(of: Task, rng: Rng, n: int, *theta: float) -> NDArray:
    """Return n events (n,) of a task at one point."""
    return draw(of, rng, n, *theta)[:, 0].astype(int)


def fibres(theta: NDArray, rng: Rng) -> NDArray:
    """Return the fibres in a graticule field of an air filter, on which they fell evenly."""
    return rng.poisson(theta[:, 0])


def loaves(theta: NDArray, rng: Rng) -> NDArray:
    """Return the loaves of rye sold in a day: some customers take two, the others one."""
    customers = rng.poisson(theta[:, 0])
    return customers + rng.binomial(customers, theta[:, 1])


def foci(theta: NDArray, rng: Rng) -> NDArray:
    """Return the MLH1 foci of a spermatocyte of a mouse: one on each of 19 bivalents for certain, and further ones."""
    return BIVALENTS + rng.poisson(theta[:, 0])


def passes(theta: NDArray, rng: Rng) -> NDArray:
    """Return the passes of bats in a quarter of an hour: each visit is a geometric number of passes, one at least."""
    visits = rng.poisson(theta[:, 0])
    return visits + rng.poisson(rng.gamma(visits, theta[:, 1] - 1))


FIBRES = task(fibres, prior={"density": (0.5, 25)}, features=["fibres"], name="asbestos-fibres")
LOAVES = task(loaves, prior={"customers": (8, 60), "two": (0, 0.6)}, features=["loaves"], name="bakery-loaves")
FOCI = task(foci, prior={"further": (1, 14)}, features=["foci"], name="meiotic-crossovers")
PASSES = task(passes, prior={"visits": (1, 14), "passes": (1.1, 5)}, features=["passes"], name="bat-passes")


@case(FIBRES, "single", right=("overdispersion",), defensible=("spread", "mixture"))
def fibres_fallen_unevenly(rng: Rng) -> NDArray:
    """The inlet of the cassette is narrow, so that more fibres fall on the middle of the filter than at its rim.

    Fields are taken all over the filter, and their density falls with the square of the distance, from 1.3 to 0.7.
    A static charge on the cowl leaves a third of the fields near the rim with still fewer.
    """
    n = 8500
    square = rng.random(n)
    density = 1.3 * np.exp(-0.62 * square) * np.where((square > 0.7) & some(rng, n, 1 / 3), 0.75, 1.0)
    return rng.poisson(6.4 * density)


@case(FIBRES, "single", right=("dead_time",), defensible=("inefficiency",))
def fibres_lying_across_others(rng: Rng) -> NDArray:
    """A fibre that lies across one already counted is taken for a part of it, and long ones cross more often.

    The more there are in a field the larger is the share that is missed, as of pulses in the blind time of a counter.
    """
    n = 1400
    x = one(FIBRES, rng, n, 15.0)
    covered, seen = np.zeros(n), np.zeros(n, dtype=int)
    for i in range(x.max()):
        length = rng.lognormal(-0.08, 0.4, n)
        apart = (i < x) & (rng.random(n) < np.exp(-0.02 * length * covered))
        covered += apart * length
        seen += apart
    return seen


@case(
    FIBRES,
    "pair",
    right=("double_counting", "zero_inflation"),
    defensible=("overdispersion", "mixture", "spread", "pile_up"),
)
def fibres_that_split_and_fields_that_are_murky(rng: Rng) -> NDArray:
    """Some fibres are split at their ends, and a new analyst counts each branch: of one in five he makes two to four.

    The filter did not clear everywhere: in 4 % of the fields nothing is seen, and in 2 % a quarter of the fibres.
    """
    n = 4700
    x = one(FIBRES, rng, n, 8.5)
    split = rng.binomial(x, 0.2)
    more = rng.binomial(split, 0.3)
    x = x + split + more + rng.binomial(more, 0.3)
    u = rng.random(n)
    return np.where(u < 0.04, 0, np.where(u < 0.06, rng.binomial(x, 0.25), x))


@case(LOAVES, "single", right=("censoring",))
def loaves_sold_out(rng: Rng) -> NDArray:
    """The shelf is empty before the evening: no more is sold than was baked, 48 loaves, or 42 on one day of four.

    On one day of five one or two of these loaves are cut for sandwiches, so that the last number is a little lower.
    """
    n = 780
    x = one(LOAVES, rng, n, 31.0, 0.28)
    baked = np.where(some(rng, n, 0.25), 42, 48)
    return np.minimum(x, baked - rng.choice(3, n, p=[0.8, 0.14, 0.06]))


@case(LOAVES, "pair", right=("mixture", "quantisation"), defensible=("overdispersion", "spread", "pile_up", "heaping"))
def loaves_of_market_days_in_half_dozens(rng: Rng) -> NDArray:
    """On market days, one in five, more customers come, and they take two loaves more often: a second population.

    Full half dozens are often written down: for half of the numbers next to one, a quarter of those two away from it,
    and an eighth of those in the middle.
    """
    n = 15500
    market = some(rng, n, 0.2)
    x = np.where(market, one(LOAVES, rng, n, 37.0, 0.4), one(LOAVES, rng, n, 26.0, 0.2))
    whole = 6 * np.round(x / 6).astype(int)
    written = rng.random(n) < np.array([0.0, 0.5, 0.25, 0.12])[np.abs(x - whole)]
    return np.where(written, whole, x)


@case(LOAVES, "outside")
def loaves_for_the_bonus(rng: Rng) -> NDArray:
    """From 50 loaves on there is a bonus: if a few are missing in the evening, the staff buy them, and some beyond.

    Days a little short of 50 are moved to anything from 50 to 54: there is a dent, and after it a surplus. Nothing
    is rounded, as no single number is preferred, and no number above 50 is lost or lowered.
    """
    n = 28000
    x = one(LOAVES, rng, n, 37.0, 0.25)
    short = 50 - x
    bought = (short > 0) & (rng.random(n) < np.interp(short, [1, 7], [0.4, 0.0]))
    return np.where(bought, 50 + rng.integers(0, 5, n), x)


@case(FOCI, "single", right=("inefficiency",), defensible=("readout_noise",))
def foci_stained_faintly(rng: Rng) -> NDArray:
    """The antibody is old, and a focus is too faint to be seen with a chance of 8 %, a little more or less in a cell.

    Each focus is missed by itself, also those that every bivalent must have: many cells have fewer than 19.
    """
    n = 1050
    return rng.binomial(one(FOCI, rng, n, 5.2), 1 - rng.beta(8.0, 92.0, n))


@case(FOCI, "single", right=("readout_noise",), defensible=("flat_background",))
def foci_by_software(rng: Rng) -> NDArray:
    """Foci are counted by software that takes specks of dirt for foci and joins close ones: it is wrong either way.

    In four cells of ten, where the ground is uneven, the error has a deviation of 1 to 3, and in the others of 0.5.
    """
    n = 3500
    sigma = np.where(some(rng, n, 0.4), rng.uniform(1.0, 3.0, n), 0.5)
    return np.maximum(one(FOCI, rng, n, 4.1) + np.round(rng.normal(0, sigma)).astype(int), 0)


@case(FOCI, "outside")
def foci_of_the_wrong_column(rng: Rng) -> NDArray:
    """For one cell in five the table has the number of bivalents with a single focus, from the column beside.

    That number is the smaller the more foci there are. It makes a narrow peak near 14, which is neither a share of
    the foci, nor spread over the range, nor what any number of further foci gives.
    """
    n = 570
    x = one(FOCI, rng, n, 5.8)
    single = (rng.multinomial(x - BIVALENTS, np.full(BIVALENTS, 1 / BIVALENTS)) == 0).sum(axis=1)
    return np.where(some(rng, n, 0.2), single, x)


@case(PASSES, "single", right=("threshold_loss",))
def passes_confirmed_by_one_call(rng: Rng) -> NDArray:
    """A quarter of an hour is listed only if at least one of its passes is good enough to tell the species.

    Each pass is so with a chance about 0.3, which differs between quiet and windy nights: few passes are often lost,
    many hardly ever, and a quarter of an hour without any is never listed.
    """
    n = 11500
    x = one(PASSES, rng, n, 4.2, 1.9)
    return x[rng.random(n) > (1 - rng.beta(6.0, 14.0, n)) ** x]


@case(
    PASSES,
    "pair",
    right=("censoring", "zero_inflation"),
    defensible=("mixture", "overdispersion", "spread", "flat_background"),
)
def passes_on_a_wet_microphone_and_in_a_full_buffer(rng: Rng) -> NDArray:
    """After rain the microphone is wet: 7 % of the quarters of an hour read nothing, and 3 % a fifth of the passes.

    The recorder has room for 28 passes in a quarter of an hour, or for 32 with the newer firmware on a fifth of them.
    """
    n = 1900
    x = one(PASSES, rng, n, 7.6, 2.4)
    u = rng.random(n)
    x = np.where(u < 0.07, 0, np.where(u < 0.1, rng.binomial(x, 0.2), x))
    return np.minimum(x, np.where(some(rng, n, 0.2), 32, 28))


@case(PASSES, "outside")
def passes_on_a_broken_display(rng: Rng) -> NDArray:
    """The upper right bar of the last digit of the display is dark: an 8 is read as a 6, and a 9 as a 5.

    The other digits look odd and are guessed rightly. This is no rounding to a step, and no bit of the number: 5 and
    6 gain, 8 and 9 lose all, and 4 and 7 stay as they are, in each ten again.
    """
    x = one(PASSES, rng, 320, 5.5, 1.7)
    return x - np.select([x % 10 == 8, x % 10 == 9], [2, 4], 0)


CASES: list[Case] = [
    plain("fibres_alone", FIBRES, 21000, 3.7),
    plain("loaves_alone", LOAVES, 430, 24.0, 0.35),
    plain("foci_alone", FOCI, 2600, 6.9),
    plain("passes_alone", PASSES, 6300, 6.1, 2.8),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
