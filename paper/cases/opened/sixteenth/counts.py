"""Simulated cases of counts: dicentric chromosomes, larvae in maize, neutrons of cosmic rays, transcripts in a cell."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def dicentrics(theta: NDArray, rng: Rng) -> NDArray:
    """Return the dicentric chromosomes in a white blood cell, of which gamma rays make more than in step with dose."""
    dose = theta[:, 0]
    return rng.poisson(0.001 + 0.03 * dose + 0.06 * dose**2)


def larvae(theta: NDArray, rng: Rng) -> NDArray:
    """Return the larvae of the corn borer in a plant: of some masses of eggs, each with some that live (Neyman's A)."""
    return rng.poisson(theta[:, 1] * rng.poisson(theta[:, 0]))


def neutrons(theta: NDArray, rng: Rng) -> NDArray:
    """Return the neutrons that a monitor counts in a second: of some showers, each with one neutron or more."""
    showers = rng.poisson(theta[:, 0])
    return showers + rng.poisson(theta[:, 1] * showers)


def transcripts(theta: NDArray, rng: Rng) -> NDArray:
    """Return the transcripts of a gene in a cell, which makes them in bursts: a negative binomial number."""
    return rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1]))


DICENTRICS = task(dicentrics, prior={"dose": (1, 8)}, features=["dicentrics"], name="dicentric-chromosomes")
BORERS = task(larvae, prior={"masses": (0.5, 5), "living": (1, 8)}, features=["larvae"], name="corn-borers")
MONITOR = task(
    neutrons, prior={"showers": (5, 60), "further": (0.1, 0.6)}, features=["neutrons"], name="neutron-monitor"
)
GENE = task(transcripts, prior={"mean": (2, 40), "bursts": (0.8, 12)}, features=["transcripts"], name="transcripts")


@case(
    DICENTRICS,
    "single",
    right=("zero_inflation",),
    defensible=("mixture", "overdispersion", "spread", "flat_background"),
)
def dicentrics_of_a_shielded_body(rng: Rng) -> NDArray:
    """A wall shielded a part of the body: 3 in 10 of the cells in the blood have seen next to none of the dose.

    They have no dicentrics, but for one cell in a hundred. The others are Poisson, as the simulator says.
    """
    n = 410
    x = one(DICENTRICS, rng, n, 5.2)
    return np.where(some(rng, n, 0.3), some(rng, n, 0.01), x).astype(int)


@case(DICENTRICS, "single", right=("truncation",))
def dicentrics_in_tangled_cells(rng: Rng) -> NDArray:
    """Cells with many dicentrics lie tangled on the slide, and are passed over: half of those with five.

    Of cells with four one in five is passed over, and of those with seven and more almost each.
    """
    x = one(DICENTRICS, rng, 1750, 7.0)
    return x[rng.random(len(x)) > 1 / (1 + np.exp(-(x - 5.0) / 0.7))]


@case(
    DICENTRICS,
    "pair",
    right=("double_counting", "threshold_loss"),
    defensible=("overdispersion", "mixture", "spread", "pile_up"),
)
def dicentrics_in_overlapping_pictures(rng: Rng) -> NDArray:
    """Pictures of a cell overlap, and a dicentric in the overlap is counted in both: 22 % are, 6 % in a third picture.

    Cells without any are mostly not filed: one in four of them is.
    """
    x = one(DICENTRICS, rng, 7300, 5.6)
    x = x[(x > 0) | some(rng, len(x), 0.25)]
    twice = rng.binomial(x, 0.22)
    return x + twice + rng.binomial(twice, 0.06 / 0.22)


@case(BORERS, "single", right=("threshold_loss",), defensible=("edge_acceptance",))
def borers_seen_by_their_holes(rng: Rng) -> NDArray:
    """Only plants that show a hole are opened. Each larva makes one that is seen with a chance of 35 %.

    So plants with none are lost, and those with one, two or three mostly, often and at times.
    """
    x = one(BORERS, rng, 1300, 3.0, 1.9)
    return x[rng.random(len(x)) > 0.65**x]


@case(
    BORERS,
    "pair",
    right=("censoring", "zero_inflation"),
    defensible=("mixture", "threshold_loss", "quantisation", "heaping", "overdispersion", "spread"),
)
def borers_sprayed_and_fifteen_and_more(rng: Rng) -> NDArray:
    """In a strip that had been sprayed, 14 % of the field, nine plants in ten hold no larva and the others few.

    One man stops to count at 15 larvae and writes 15. Another, who opens a third of the plants, stops at 20.
    """
    n = 2580
    x = one(BORERS, rng, n, 2.9, 3.6)
    sprayed = some(rng, n, 0.14)
    x = np.where(sprayed, np.where(some(rng, n, 0.9), 0, rng.binomial(x, 0.3)), x)
    return np.minimum(x, np.where(some(rng, n, 1 / 3), 20, 15))


@case(BORERS, "outside")
def borers_with_digits_exchanged(rng: Rng) -> NDArray:
    """Who typed the field book exchanged the two digits of a number in three of ten: 12 became 21, and 20 became 2.

    Numbers below ten and those like 11 stay. No larva was missed or counted twice, and nothing was rounded.
    """
    n = 8800
    x = one(BORERS, rng, n, 3.6, 4.2)
    swapped = 10 * (x % 10) + x // 10
    return np.where((x > 9) & (x < 100) & some(rng, n, 0.3), swapped, x)


@case(MONITOR, "single", right=("dead_time",), defensible=("inefficiency",))
def monitor_with_a_slow_discriminator(rng: Rng) -> NDArray:
    """After a pulse the discriminator needs 14 ms, and 40 ms after one pulse in eight, which is a large one.

    The neutrons of a shower come within some milliseconds of each other, so that few showers show more than one.
    """
    n = 560
    showers = rng.poisson(34.0, n)
    start = np.where(np.arange(showers.max()) < showers[:, None], rng.random((n, showers.max())), np.inf)
    follow = [
        np.where(rng.poisson(0.35, start.shape) >= k, start + rng.gamma(k, 0.004, start.shape), np.inf) for k in (1, 2)
    ]
    times = np.sort(np.concatenate([start, *follow], axis=1), axis=1)
    free, seen = np.zeros(n), np.zeros(n, dtype=int)
    for t in times.T:
        hit = np.isfinite(t) & (t >= free)
        seen += hit
        free = np.where(hit, t + np.where(some(rng, n, 1 / 8), 0.040, 0.014), free)
    return seen


@case(MONITOR, "single", right=("readout_noise",), defensible=("overdispersion", "spread", "mixture"))
def monitor_read_by_its_charge(rng: Rng) -> NDArray:
    """An old monitor does not count pulses, but reads the charge on a condenser in units of a neutron.

    The reading is off by 4.5 neutrons, and by twice that while the pump of the laboratory runs, a fifth of the time.
    """
    n = 1030
    x = one(MONITOR, rng, n, 31.0, 0.25) + rng.normal(0, np.where(some(rng, n, 0.2), 9.0, 4.5))
    return np.maximum(np.round(x), 0).astype(int)


@case(MONITOR, "outside")
def monitor_halves_compared(rng: Rng) -> NDArray:
    """What was filed is by how many neutrons the two halves of the monitor differed, whichever had more.

    An event is the distance between two counts: neither is there by itself, and most of the sum cancels.
    """
    n = 5000
    return np.abs(one(MONITOR, rng, n, 44.0, 0.3) - one(MONITOR, rng, n, 44.0, 0.3))


@case(GENE, "single", right=("double_counting", "pile_up"), defensible=("mixture", "overdispersion", "flat_background"))
def gene_in_droplets_of_two_cells(rng: Rng) -> NDArray:
    """A droplet should hold one cell, but 14 % hold two, and 1 % three: their transcripts are read as of one cell.

    The cells of a doublet are drawn as all others are. The smaller of them has burst a little in three of ten.
    """
    n = 12000
    first, second, third = (one(GENE, rng, n, 14.0, 7.0) for _ in range(3))
    second = np.where(some(rng, n, 0.3), rng.binomial(second, 0.75), second)
    u = rng.random(n)
    return first + np.where(u < 0.15, second, 0) + np.where(u < 0.01, third, 0)


@case(
    GENE,
    "pair",
    right=("mixture", "truncation"),
    defensible=("overdispersion", "spread", "flat_background", "zero_inflation"),
)
def gene_in_two_types_of_cells(rng: Rng) -> NDArray:
    """One cell in seven is of another type, which makes four times as many transcripts of this gene.

    Cells with many are taken for doublets and are left out: from 34 transcripts on, in one batch from 40 on.
    """
    n = 17500
    x = np.where(some(rng, n, 1 / 7), one(GENE, rng, n, 27.0, 8.0), one(GENE, rng, n, 6.5, 3.5))
    return x[x < np.where(some(rng, n, 0.25), 40, 34)]


@case(GENE, "outside")
def gene_smoothed_over_neighbours(rng: Rng) -> NDArray:
    """To fill the zeros, the count of a cell was replaced by the mean of it and its five neighbours, rounded.

    The cells that are averaged are alike but for chance, so that counts scatter less than those of any cell can.
    """
    n = 3500
    return np.round(one(GENE, rng, 6 * n, 5.5, 9.0).reshape(n, 6).mean(axis=1)).astype(int)


CASES: list[Case] = [
    plain("dicentrics_alone", DICENTRICS, 300, 4.4),
    plain("borers_alone", BORERS, 22000, 1.7, 4.9),
    plain("monitor_alone", MONITOR, 760, 22.0, 0.42),
    plain("gene_alone", GENE, 30000, 18.0, 2.6),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
