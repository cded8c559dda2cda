"""Cases of events that are one count each: spikes, outbreaks, mutants, queues, animals and photons.

Written without sight of the code.
"""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, some


def _spikes(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The spikes of a neuron in half a second, at random with one rate in Hz."""
    return rng.poisson(0.5 * theta[:, 0])


def _outbreak(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The cases that follow one introduced case, each of which infects a Poisson number of others (Farrington 2003)."""
    return _chain(len(theta), lambda z, i: rng.poisson(theta[i, 0] * z))


def _chain(n: int, offspring, generations: int = 10_000) -> NDArray:
    """The sum of all generations that come of one case in each of n outbreaks."""
    total, z, alive = np.zeros(n, int), np.ones(n, int), np.arange(n)
    while alive.size and generations:
        z = offspring(z, alive)
        total[alive] += z
        alive, z, generations = alive[z > 0], z[z > 0], generations - 1
    return total


def _mutants(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The resistant cells of a culture with m mutations, whose clones are of size k with chance 1/k(k+1) (Lea 1949)."""
    m = rng.poisson(theta[:, 0])
    clones = np.minimum(1 / (1 - rng.random(m.sum())), 1e6).astype(int)
    return np.bincount(np.repeat(np.arange(len(m)), m), clones, len(m)).astype(int)


def _queue(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The customers that an arriving one finds at a counter of load rho, as of the M/M/1 queue."""
    return rng.geometric(1 - theta[:, 0]) - 1


def _fish(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The fish of one haul, negative binomial with a mean and a clumping k (Bliss, Fisher 1953)."""
    return rng.poisson(rng.gamma(theta[:, 1]) * theta[:, 0] / theta[:, 1])


def _photons(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The photons of a star in an exposure whose seeing lets a fifth more or less through."""
    return rng.poisson(theta[:, 0] * rng.uniform(0.8, 1.2, len(theta)))


SPIKES = task(_spikes, prior={"rate": (10, 60)}, units={"rate": "Hz"}, features=["spikes"], name="spikes")
OUTBREAK = task(_outbreak, prior={"reproduction": (0.2, 0.85)}, features=["cases"], name="outbreak")
MUTANTS = task(_mutants, prior={"mutations": (0.5, 8)}, features=["mutants"], name="mutants")
QUEUE = task(_queue, prior={"load": (0.3, 0.95)}, features=["waiting"], name="queue")
FISH = task(_fish, prior={"mean": (1, 15), "clumping": (0.4, 6)}, features=["fish"], name="fish")
PHOTONS = task(_photons, prior={"flux": (5, 60)}, features=["photons"], name="photons")


def _renewal(rng: np.random.Generator, n: int, rate: float, blind: float, length: float = 0.5) -> NDArray:
    """Counts of a renewal process with an absolute refractory time, begun long before each window."""
    gaps = blind + rng.exponential(1 / rate - blind, (n, int(3 * rate * length) + 40))
    times = np.cumsum(gaps, axis=1) - rng.uniform(5 / rate, 10 / rate, (n, 1))
    return ((times > 0) & (times < length)).sum(axis=1)


@case(SPIKES)
def spikes_plain(rng):
    """A Poisson neuron, as the simulator has it."""
    return draw(SPIKES, rng, 2500, 33.0)


@case(SPIKES, "single", ("dead_time",))
def spikes_refractory(rng):
    """The neuron cannot fire for 4 ms after each spike (Berry, Meister 1998)."""
    return _renewal(rng, 3000, 40.0, 0.004)


@case(SPIKES, "single", ("overdispersion",), ("mixture",))
def spikes_gain(rng):
    """The gain of the neuron drifts from trial to trial as a gamma variable (Goris 2014)."""
    return rng.poisson(0.5 * 28 * rng.gamma(1 / 0.03, 0.03, 1800))


@case(SPIKES, "pair", ("zero_inflation", "dead_time"), ("mixture",))
def spikes_down_states(rng):
    """Under anaesthesia the cell is silent in one window of twenty-five, and it is refractory for 5 ms otherwise."""
    return _renewal(rng, 5000, 38.0, 0.005) * ~some(rng, 5000, 0.04)


@case(SPIKES, "outside")
def spikes_four_bits(rng):
    """The register of the counter has four bits and begins again with nought after fifteen."""
    return draw(SPIKES, rng, 1500, 23.0) % 16


@case(OUTBREAK)
def outbreak_plain(rng):
    """Outbreaks as the simulator has them."""
    return draw(OUTBREAK, rng, 1500, 0.55)


@case(OUTBREAK, "single", ("inefficiency",))
def outbreak_reported(rng):
    """A case is reported with a chance of 0.45 only, though every introduction is known (Gibbons 2014)."""
    return rng.binomial(draw(OUTBREAK, rng, 5000, 0.78)[:, 0].astype(int), 0.45)


@case(OUTBREAK, "single", ("overdispersion",), ("zero_inflation", "mixture"))
def outbreak_superspreading(rng):
    """Each case has its own reproduction number, a gamma variable of shape 0.3 (Lloyd-Smith 2005)."""
    return _chain(800, lambda z, _: rng.poisson(rng.gamma(0.3 * z) * 0.6 / 0.3))


@case(OUTBREAK, "single", ("threshold_loss",), ("inefficiency",))
def outbreak_unnoticed(rng):
    """An outbreak becomes known only if one of its cases is tested, so small ones are mostly missed (Blumberg 2013)."""
    size = draw(OUTBREAK, rng, 5000, 0.6)[:, 0]
    return size[some(rng, len(size), 1 - 0.55 ** (size + 1))]


@case(OUTBREAK, "pair", ("overdispersion", "censoring"), ("mixture", "zero_inflation"))
def outbreak_places(rng):
    """Places differ in their reproduction number, as a beta variable, and reports end with `12 or more`."""
    places = rng.beta(0.8, 1.0, 6000)
    return np.minimum(_chain(6000, lambda z, i: rng.poisson(places[i] * z), 400), 12)


@case(OUTBREAK, "outside")
def outbreak_two_generations(rng):
    """Contacts are traced for two generations and no further."""
    return _chain(1200, lambda z, _: rng.poisson(0.8 * z), 2)


@case(MUTANTS)
def mutants_plain(rng):
    """Cultures as the simulator has them, with jackpots of thousands."""
    return draw(MUTANTS, rng, 1200, 2.6)


@case(MUTANTS, "single", ("inefficiency",))
def mutants_plated(rng):
    """Only a tenth of each culture is plated (Stewart 1990)."""
    return rng.binomial(draw(MUTANTS, rng, 3000, 6.0)[:, 0].astype(int), 0.1)


@case(MUTANTS, "single", ("censoring",), ("truncation",))
def mutants_too_many(rng):
    """Plates with more than 60 colonies are written down as 60."""
    return np.minimum(draw(MUTANTS, rng, 1000, 4.0), 60)


@case(MUTANTS, "single", ("overdispersion",), ("zero_inflation", "mixture"))
def mutants_volumes(rng):
    """The cultures are of unlike final size, a gamma variable with a variation of 0.7 (Zheng 2010)."""
    return _mutants(4.0 * rng.gamma(2, 0.5, (4000, 1)), rng)


@case(MUTANTS, "pair", ("zero_inflation", "inefficiency"))
def mutants_dead_plates(rng):
    """A tenth of each culture is plated, and one plate of six does not grow anything."""
    return rng.binomial(draw(MUTANTS, rng, 5000, 8.0)[:, 0].astype(int), 0.1) * ~some(rng, 5000, 0.17)


@case(QUEUE)
def queue_plain(rng):
    """The queue as the simulator has it."""
    return draw(QUEUE, rng, 10_000, 0.8)


@case(QUEUE, "single", ("truncation",))
def queue_waiting_room(rng):
    """The room holds twelve, and who finds it full is sent away without a record, as in the M/M/1/K queue."""
    found = draw(QUEUE, rng, 1500, 0.88)[:, 0]
    return found[found <= 12]


@case(QUEUE, "single", ("pile_up",), ("double_counting",))
def queue_neighbour(rng):
    """In two pictures of five a part of the next queue is in view and is counted too."""
    here, there = draw(QUEUE, rng, 20_000, 0.6)[:, 0], draw(QUEUE, rng, 20_000, 0.6)[:, 0].astype(int)
    return here + rng.binomial(there, 0.8) * some(rng, 20_000, 0.4)


@case(QUEUE, "pair", ("overdispersion", "censoring"), ("mixture",))
def queue_rush_hours(rng):
    """The load changes with the hour, and the camera sees no more than fifteen."""
    return np.minimum(_queue(rng.beta(4, 2, (8000, 1)), rng), 15)


@case(QUEUE, "outside")
def queue_longer(rng):
    """The manager writes down the longer one of two queues."""
    return np.maximum(draw(QUEUE, rng, 1500, 0.75), draw(QUEUE, rng, 1500, 0.75))


@case(FISH)
def fish_plain(rng):
    """Hauls as the simulator has them, which are clumped and often empty."""
    return draw(FISH, rng, 1000, 4.0, 0.7)


@case(FISH, "single", ("zero_inflation",), ("mixture",))
def fish_unoccupied(rng):
    """A fifth of the sites is not inhabited (MacKenzie 2002)."""
    return draw(FISH, rng, 2000, 9.0, 2.5)[:, 0] * ~some(rng, 2000, 0.2)


@case(FISH, "single", ("quantisation",))
def fish_in_fives(rng):
    """The divers give their numbers in fives, as counts by eye often are."""
    return 5 * np.rint(draw(FISH, rng, 400, 11.0, 2.0) / 5)


@case(FISH, "single", ("mixture",))
def fish_two_stocks(rng):
    """Two hauls of five are of a second stock that is six times as dense."""
    return either(some(rng, 4000, 0.4), draw(FISH, rng, 4000, 13.0, 5.0), draw(FISH, rng, 4000, 2.0, 5.0))


@case(FISH, "pair", ("zero_inflation", "truncation"), ("mixture",))
def fish_torn_nets(rng):
    """A seventh of the nets is not set, and nets with more than 16 fish tear and are left out."""
    hauls = draw(FISH, rng, 8000, 11.0, 3.0)[:, 0] * ~some(rng, 8000, 0.14)
    return hauls[hauls <= 16]


@case(FISH, "outside")
def fish_swapped_digits(rng):
    """A third of the counts of two digits is copied with the digits swapped."""
    n = draw(FISH, rng, 4000, 13.0, 5.5)[:, 0].astype(int)
    return np.where((n > 9) & (n < 100) & some(rng, 4000, 0.33), n % 10 * 10 + n // 10, n)


@case(PHOTONS)
def photons_plain(rng):
    """Exposures as the simulator has them, with a known scatter of the seeing."""
    return draw(PHOTONS, rng, 20_000, 22.0)


@case(PHOTONS, "single", ("readout_noise",), ("overdispersion",))
def photons_amplifier(rng):
    """The amplifier adds a noise of two electrons (Janesick 2001)."""
    return np.maximum(np.rint(draw(PHOTONS, rng, 3000, 14.0) + rng.normal(0, 2, (3000, 1))), 0)


@case(PHOTONS, "single", ("flat_background",), ("mixture",))
def photons_cosmics(rng):
    """In three exposures of a hundred a cosmic ray gives a count of its own, anything up to 100."""
    return np.where(some(rng, 2500, 0.03), rng.integers(0, 101, 2500), draw(PHOTONS, rng, 2500, 30.0)[:, 0])


@case(PHOTONS, "single", ("double_counting",), ("overdispersion",))
def photons_afterpulses(rng):
    """A third of the photons give an afterpulse that is counted as well (Campbell 1992)."""
    n = draw(PHOTONS, rng, 3000, 15.0)[:, 0].astype(int)
    return n + rng.binomial(n, 0.33)


@case(PHOTONS, "pair", ("quantisation", "flat_background"))
def photons_coarse_converter(rng):
    """The converter has a step of four photons, and cosmic rays spoil four exposures of a hundred."""
    n = np.where(some(rng, 4000, 0.04), rng.integers(0, 121, 4000), draw(PHOTONS, rng, 4000, 33.0)[:, 0])
    return 4 * np.floor(n / 4)


@case(PHOTONS, "outside")
def photons_best_of_three(rng):
    """Of three exposures only the brightest is kept, which is called lucky imaging (Fried 1978)."""
    return np.max([draw(PHOTONS, rng, 2500, 30.0) for _ in range(3)], axis=0)


CASES: list[Case] = [c for c in list(globals().values()) if isinstance(c, Case)]
