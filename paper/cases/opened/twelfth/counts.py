"""Cases of one count, with simulators that no other case has: pollen, rings, reads, alleles and lightning."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, plain, some


def _pollen(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Grains in one field of view of a slide that is evenly spread."""
    return rng.poisson(theta[:, 0])


POLLEN = task(_pollen, prior={"grains": (8, 60)}, features=["grains"], name="pollen")


def _ring(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Photoelectrons in the Cherenkov ring of one particle, fewer where it is barely above the threshold."""
    momentum = rng.uniform(10, 40, len(theta))
    return rng.poisson(theta[:, 0] * (1 - (theta[:, 1] / momentum) ** 2))


RING = task(
    _ring,
    prior={"photons": (12, 45), "threshold": (2, 9.5)},
    units={"threshold": "GeV"},
    features=["photoelectrons"],
    name="ring",
)


def _depth(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Reads that cover one base of a genome: the ease of its copying varies by a gamma law."""
    mean, shape = theta.T
    return rng.poisson(mean * rng.gamma(shape) / shape)


DEPTH = task(_depth, prior={"mean": (15, 80), "shape": (4, 40)}, features=["reads"], name="depth")


CHROMOSOMES = 40


def _alleles(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Copies of an allele among 40 chromosomes of a population that drifted away from its source."""
    frequency, drift = theta.T
    total = 1 / drift - 1
    p = rng.beta(frequency * total, (1 - frequency) * total)
    return rng.binomial(CHROMOSOMES, p)


ALLELES = task(_alleles, prior={"frequency": (0.1, 0.6), "drift": (0.03, 0.3)}, features=["copies"], name="alleles")


def _lightning(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Strokes in five minutes of a storm: flashes come at random, and each has one stroke and some more."""
    flashes = rng.poisson(theta[:, 0])
    return flashes + rng.poisson(theta[:, 1] * flashes)


LIGHTNING = task(
    _lightning, prior={"flashes": (3, 20), "more_strokes": (0.2, 4)}, features=["strokes"], name="lightning"
)


# Nothing is missing.
pollen_as_told = plain("pollen_as_told", POLLEN, 2400, 23.7)
rings_as_told = plain("rings_as_told", RING, 13_000, 31.0, 6.4)
depth_as_told = plain("depth_as_told", DEPTH, 33_000, 38.0, 14.0)
alleles_as_told = plain("alleles_as_told", ALLELES, 5200, 0.27, 0.11)
lightning_as_told = plain("lightning_as_told", LIGHTNING, 850, 8.4, 1.9)


# One effect.
@case(POLLEN, "single", ("overdispersion", "spread"), ("mixture",))
def pollen_under_coverslip(rng: np.random.Generator) -> NDArray:
    """Grains drift to the edge of the coverslip: fields lie on a line from its middle, and the rate grows with the
    square of the distance, from 0.8 to 1.7 times (Brookes and Thomas 1967)."""
    place = rng.uniform(0, 1, 3600)
    return rng.poisson(26 * (0.8 + 0.9 * place**2))


@case(POLLEN, "single", ("heaping",), ("quantisation",))
def pollen_by_tally(rng: np.random.Generator) -> NDArray:
    """Tally marks are bundled by five, and a tired counter reads bundles alone: the more marks, the likelier, from a
    few in a hundred at ten grains to nearly a half at sixty."""
    grains = draw(POLLEN, rng, 5500, 34.0).ravel()
    return np.where(rng.random(5500) < np.clip(grains / 130, 0, 0.5), 5 * np.round(grains / 5), grains)


@case(RING, "single", ("double_counting", "dead_time"), ("inefficiency", "truncation"))
def ring_of_pixels(rng: np.random.Generator) -> NDArray:
    """A ring crosses 44 pixels, not all of one width, and photons that hit one pixel are read as one."""
    photons = draw(RING, rng, 12_000, 34.0, 5.0).ravel().astype(int)
    width = rng.dirichlet(np.full(44, 6.0))
    return np.array([len(np.unique(rng.choice(44, k, p=width))) if k else 0 for k in photons])


@case(RING, "single", ("readout_noise",), ("overdispersion", "spread", "flat_background"))
def ring_by_charge(rng: np.random.Generator) -> NDArray:
    """Photoelectrons are found from the charge, of which the pedestal has noise of five electrons, and that of one
    event in five of nine; the charge is rounded, and never below zero."""
    electrons = draw(RING, rng, 9000, 20.0, 4.0).ravel()
    noise = np.where(some(rng, 9000, 0.2), 9.0, 5.0)
    return np.maximum(np.round(electrons + rng.normal(0, noise)), 0).astype(int)


@case(DEPTH, "single", ("censoring",), ("truncation", "dead_time"))
def depth_with_cap(rng: np.random.Generator) -> NDArray:
    """The caller of variants keeps at most 30 reads of each strand, so that most deep bases are at 60, and some, of
    uneven strands, below (maximal depth of samtools)."""
    reads = draw(DEPTH, rng, 7000, 46.0, 12.0).ravel().astype(int)
    forward = rng.binomial(reads, 0.5)
    return np.minimum(forward, 30) + np.minimum(reads - forward, 30)


@case(DEPTH, "single", ("zero_inflation",), ("mixture", "flat_background"))
def depth_with_deletions(rng: np.random.Generator) -> NDArray:
    """Deletions: four bases in a hundred are lost on one chromosome, so that half of the reads remain, and three on
    both, where now and then a read is mapped by mistake."""
    reads = draw(DEPTH, rng, 4300, 42.0, 30.0).ravel().astype(int)
    u = rng.random(4300)
    reads = np.where(u < 0.04, rng.binomial(reads, 0.5), reads)
    return np.where(u > 0.97, rng.binomial(1, 0.15, 4300), reads)


@case(ALLELES, "single", ("threshold_loss",), ("inefficiency",))
def alleles_filtered(rng: np.random.Generator) -> NDArray:
    """Sites with a rare allele are thought to be errors of reading and are filtered out: all with fewer than three
    copies, and of three to five copies those whose quality is low, from two thirds down to a fifth."""
    copies = draw(ALLELES, rng, 4400, 0.2, 0.14).ravel().astype(int)
    lost = np.array([1, 1, 1, 0.65, 0.4, 0.2, 0])
    return copies[rng.random(4400) > lost[np.minimum(copies, 6)]]


@case(LIGHTNING, "single", ("dead_time",), ("truncation", "double_counting", "inefficiency"))
def lightning_seen_by_slow_sensor(rng: np.random.Generator) -> NDArray:
    """The sensor is busy for twelve seconds after each stroke that it records, and sees no other in that time."""
    strokes = draw(LIGHTNING, rng, 5000, 15.0, 0.7).ravel().astype(int)
    seen = []
    for k in strokes:
        last, count = -np.inf, 0
        for t in np.sort(rng.uniform(0, 300, k)):
            if t - last > 12:
                last, count = t, count + 1
        seen.append(count)
    return np.array(seen)


# Two effects.
@case(POLLEN, "pair", ("flat_background", "truncation"), ("mixture", "overdispersion", "threshold_loss"))
def pollen_with_clumps(rng: np.random.Generator) -> NDArray:
    """Seven fields in a hundred hold a torn anther, with any number up to 45; and fields of more than 33 grains are
    given up as too crowded to count, most of them from 31 on."""
    grains = draw(POLLEN, rng, 8000, 25.0).ravel()
    grains = np.where(some(rng, 8000, 0.07), rng.integers(0, 46, 8000), grains)
    return grains[rng.random(8000) < np.array([1, 0.5, 0.2, 0.1, 0])[np.clip(grains - 30, 0, 4).astype(int)]]


@case(DEPTH, "pair", ("mixture", "quantisation"), ("zero_inflation", "heaping"))
def depth_in_bands(rng: np.random.Generator) -> NDArray:
    """A fifth of the bases lie on the single X of a man, at half of the depth, and the file keeps depths in bands of
    four from zero, by their lower end (blocks of a gVCF)."""
    reads = np.where(
        some(rng, 16_000, 0.2),
        draw(DEPTH, rng, 16_000, 27.0, 22.0).ravel(),
        draw(DEPTH, rng, 16_000, 54.0, 22.0).ravel(),
    )
    return 4 * np.floor(reads / 4).astype(int)


@case(RING, "pair", ("after_pulses", "threshold_loss"), ("overdispersion", "double_counting", "truncation"))
def ring_of_silicon(rng: np.random.Generator) -> NDArray:
    """Silicon photomultipliers: each electron sets off others nearby, with a chance of 0.35 that these pass on; and a
    ring of fewer than twelve is not found by the trigger, of twelve to fifteen in half of the cases."""
    electrons = draw(RING, rng, 11_000, 18.0, 3.0).ravel().astype(int)
    more = electrons
    while more.any():
        more = rng.poisson(0.35 * more)
        electrons = electrons + more
    return electrons[rng.random(11_000) < np.where(electrons < 12, 0, np.where(electrons < 16, 0.5, 1))]


@case(LIGHTNING, "pair", ("zero_inflation", "double_counting"), ("mixture", "overdispersion", "after_pulses"))
def lightning_of_two_stations(rng: np.random.Generator) -> NDArray:
    """Lists of two stations were joined, and each stroke is there twice but for one of thirty that the second did not
    hear; and in nine intervals of a hundred both were without power, for all of it or for a half and more."""
    strokes = draw(LIGHTNING, rng, 6500, 7.0, 0.9).ravel().astype(int)
    live = np.where(some(rng, 6500, 0.7), 0.0, rng.uniform(0, 0.5, 6500))
    strokes = np.where(some(rng, 6500, 0.09), rng.binomial(strokes, live), strokes)
    return strokes + rng.binomial(strokes, 29 / 30)


# Effects outside the catalogue.
@case(POLLEN, "outside")
def pollen_with_digits_exchanged(rng: np.random.Generator) -> NDArray:
    """In one count of six the typist exchanged the two digits, so that 27 became 72, and 20 became 2."""
    grains = draw(POLLEN, rng, 4800, 24.0).ravel().astype(int)
    turned = 10 * (grains % 10) + grains // 10
    return np.where(some(rng, 4800, 1 / 6), turned, grains)


@case(DEPTH, "outside")
def depth_in_six_bits(rng: np.random.Generator) -> NDArray:
    """Depth is kept in six bits, and goes on from zero after 63: deep bases come out shallow."""
    return draw(DEPTH, rng, 9000, 55.0, 25.0).ravel().astype(int) % 64


@case(ALLELES, "outside")
def alleles_folded(rng: np.random.Generator) -> NDArray:
    """It is not known which allele is the older, and the rarer in the sample is counted: x becomes the smaller of x
    and 40 - x (the folded spectrum)."""
    copies = draw(ALLELES, rng, 7500, 0.42, 0.1).ravel().astype(int)
    return np.minimum(copies, CHROMOSOMES - copies)


CASES: list[Case] = [value for value in list(globals().values()) if isinstance(value, Case)]
