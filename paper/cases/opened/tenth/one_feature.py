"""Cases of events that are one real number: reaction times, magnitudes, directions, lifetimes, returns, rain, alphas.

Written without sight of the code.
"""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, some

TURN = 2 * np.pi


def _reaction(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A reaction time in seconds, ex-Gaussian of mu, sigma and tau (Luce 1986)."""
    return rng.normal(theta[:, 0], theta[:, 1]) + rng.exponential(theta[:, 2])


def _magnitude(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A magnitude above 2 with the b of Gutenberg and Richter (1944)."""
    return 2 + rng.exponential(1 / (theta[:, 0] * np.log(10)))


def _heading(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A direction about a mean one, as of von Mises (Batschelet 1981)."""
    return rng.vonmises(theta[:, 0], theta[:, 1])


def _fluorescence(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The time in ns of a photon in a window of 12.5 ns after a pulse that is 0.15 ns wide (Becker 2005)."""
    return (1 + rng.normal(0, 0.15, len(theta)) + rng.exponential(theta[:, 0])) % 12.5


def _return(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The return of a share in a day in per cent, normal with a drift and a volatility (Osborne 1959)."""
    return rng.normal(theta[:, 0], theta[:, 1])


def _rain(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The rain of a wet day in mm, a gamma variable of a shape and a scale (Thom 1958)."""
    return rng.gamma(theta[:, 0], theta[:, 1])


def _alpha(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The energy in MeV of an alpha of 239Pu (the share) or 241Am, in a detector of a resolution in MeV."""
    lines = np.where(rng.random(len(theta)) < theta[:, 0], 0, 3) + rng.choice(3, len(theta), p=[0.8, 0.14, 0.06])
    return rng.normal(np.array([5.157, 5.144, 5.105, 5.486, 5.443, 5.388])[lines], theta[:, 1])


REACTION = task(
    _reaction,
    prior={"mu": (0.25, 0.6), "sigma": (0.015, 0.08), "tau": (0.04, 0.3)},
    features=["rt"],
    feature_units={"rt": "s"},
    name="reaction",
)
MAGNITUDE = task(_magnitude, prior={"b": (0.5, 1.6)}, features=["magnitude"], name="magnitude")
HEADING = task(
    _heading,
    prior={"mean": (-1, 1), "concentration": (0.7, 8)},
    support={"mean": (-np.pi, np.pi), "concentration": (0.1, 50)},
    features=["heading"],
    kinds={"heading": "angle"},
    name="heading",
)
FLUORESCENCE = task(
    _fluorescence, prior={"lifetime": (0.6, 4)}, features=["time"], feature_units={"time": "ns"}, name="fluorescence"
)
RETURN = task(_return, prior={"drift": (-0.8, 0.8), "volatility": (0.4, 3)}, features=["return"], name="return")
RAIN = task(_rain, prior={"shape": (0.4, 2.5), "scale": (3, 16)}, features=["rain"], name="rain")
ALPHA = task(_alpha, prior={"share": (0.1, 0.9), "width": (0.005, 0.02)}, features=["energy"], name="alpha")


@case(REACTION)
def reaction_plain(rng):
    """A task with long tails of the responses, as the simulator has them."""
    return draw(REACTION, rng, 3000, 0.38, 0.035, 0.21)


@case(REACTION, "single", ("flat_background",), ("outliers", "mixture"))
def reaction_contaminants(rng):
    """One response of twenty has nothing to do with the stimulus and comes at any time up to 2.5 s (Ratcliff 2002)."""
    return either(some(rng, 2500, 0.05), rng.uniform(0.15, 2.5, (2500, 1)), draw(REACTION, rng, 2500, 0.42, 0.04, 0.1))


@case(REACTION, "single", ("saturation",))
def reaction_deadline(rng):
    """A trial ends after 1.1 s, and who has not answered then is given 1.1 s."""
    return np.minimum(draw(REACTION, rng, 2000, 0.45, 0.05, 0.17), 1.1)


@case(REACTION, "single", ("peak_background",), ("mixture",))
def reaction_anticipations(rng):
    """One response of thirty is an anticipation at the expected time of the signal (Yellott 1971)."""
    return either(some(rng, 1500, 0.033), rng.normal(0.2, 0.03, (1500, 1)), draw(REACTION, rng, 1500, 0.4, 0.04, 0.12))


@case(REACTION, "pair", ("quantisation", "flat_background"), ("outliers",))
def reaction_video(rng):
    """Responses are read from a video of 25 pictures a second, and one of sixteen is a lapse of any length to 3 s."""
    rt = draw(REACTION, rng, 5000, 0.36, 0.03, 0.11)
    return 0.04 * np.rint(either(some(rng, 5000, 0.06), rng.uniform(0.2, 3, (5000, 1)), rt) / 0.04)


@case(REACTION, "outside")
def reaction_swapped_digits(rng):
    """Times of three digits are typed by hand, and one of four with its first two digits swapped."""
    ms = np.rint(1000 * draw(REACTION, rng, 4000, 0.4, 0.04, 0.09)[:, 0]).astype(int)
    swapped = ms % 100 // 10 * 100 + ms // 100 * 10 + ms % 10
    return np.where((ms < 1000) & some(rng, 4000, 0.25), swapped, ms) / 1000 + rng.uniform(-5e-4, 5e-4, 4000)


@case(MAGNITUDE)
def magnitude_plain(rng):
    """A complete catalogue."""
    return draw(MAGNITUDE, rng, 6000, 1.05)


@case(MAGNITUDE, "single", ("edge_acceptance",))
def magnitude_incomplete(rng):
    """The chance to detect an earthquake rises with its magnitude as a normal integral (Ogata, Katsura 1993)."""
    m = draw(MAGNITUDE, rng, 6000, 0.95)[:, 0]
    return m[rng.normal(2.1, 0.2, 6000) < m]


@case(MAGNITUDE, "single", ("resolution",))
def magnitude_errors(rng):
    """The magnitudes of a complete list are measured anew with an error of 0.15 (Tinti, Mulargia 1985)."""
    return draw(MAGNITUDE, rng, 700, 1.1) + rng.normal(0, 0.15, (700, 1))


@case(MAGNITUDE, "pair", ("quantisation", "edge_acceptance"))
def magnitude_historic(rng):
    """Magnitudes from old reports come in steps of a quarter, and the small ones are reported less often."""
    m = draw(MAGNITUDE, rng, 15_000, 0.8)[:, 0]
    return 0.25 * np.rint(m[rng.normal(2.2, 0.3, 15_000) < m] / 0.25)


@case(MAGNITUDE, "outside")
def magnitude_largest(rng):
    """The list has the largest shock of each sequence of one to five."""
    m = draw(MAGNITUDE, rng, 6000, 0.9).reshape(-1, 5)
    return np.where(np.arange(5) < rng.integers(1, 6, (1200, 1)), m, 0).max(axis=1)


@case(HEADING)
def heading_plain(rng):
    """Birds that fly as the simulator has it."""
    return draw(HEADING, rng, 900, 0.7, 1.6)


@case(HEADING, "single", ("dead_region",))
def heading_tower(rng):
    """Winds from a sector of 35 degrees come through the tower and are struck from the record."""
    x = draw(HEADING, rng, 4000, -0.3, 1.2)[:, 0]
    return x[(x < 0.5) | (x > 0.5 + np.radians(35))]


@case(HEADING, "single", ("peak_background",))
def heading_calms(rng):
    """In a calm, one hour of twenty-five, the vane rests where it is pushed by its cable, near 115 degrees."""
    return either(some(rng, 5000, 0.04), rng.normal(2.0, 0.06, (5000, 1)), draw(HEADING, rng, 5000, 0.2, 1.5))


@case(HEADING, "single", ("mixture",), ("flat_background",))
def heading_reverse(rng):
    """One bird of seven flies the other way, which is called reverse migration (Alerstam 1990)."""
    return either(some(rng, 600, 0.14), draw(HEADING, rng, 600, 0.4 - np.pi, 2.5), draw(HEADING, rng, 600, 0.4, 2.5))


@case(HEADING, "pair", ("quantisation", "flat_background"), ("mixture",))
def heading_compass(rng):
    """Headings are noted by the sixteen points of the compass, and one bird of six flies anywhere."""
    x = either(some(rng, 6000, 0.16), rng.uniform(-np.pi, np.pi, (6000, 1)), draw(HEADING, rng, 6000, -0.5, 5.0))
    x = TURN / 16 * np.rint(16 * x / TURN)
    return np.where(x < -3.1, x + TURN, x)


@case(FLUORESCENCE)
def fluorescence_plain(rng):
    """One dye, with photons that wrap into the next window."""
    return draw(FLUORESCENCE, rng, 50_000, 3.6)


@case(FLUORESCENCE, "single", ("second_exponential", "mixture"), ("spread",))
def fluorescence_bound(rng):
    """A quarter of the NADH is bound to protein and shines for 2.8 ns in place of 1.1 (Lakowicz 1992)."""
    tau = np.where(some(rng, 8000, 0.25), 2.8, 1.1)
    return (1 + rng.normal(0, 0.15, 8000) + rng.exponential(tau)) % 12.5


@case(FLUORESCENCE, "single", ("resolution",))
def fluorescence_slow_diode(rng):
    """Another diode is used, whose jitter of 0.2 ns comes on top of the pulse."""
    return (draw(FLUORESCENCE, rng, 4000, 1.6) + rng.normal(0, 0.2, (4000, 1))) % 12.5


@case(FLUORESCENCE, "pair", ("flat_background", "offset"))
def fluorescence_dark_counts(rng):
    """One count of fourteen is a dark one, and a longer cable delays all by 0.1 ns."""
    t = either(some(rng, 20_000, 0.07), rng.uniform(0, 12.5, (20_000, 1)), draw(FLUORESCENCE, rng, 20_000, 1.9))
    return (t + 0.1) % 12.5


@case(FLUORESCENCE, "outside")
def fluorescence_first_photon(rng):
    """Only the first photon of a pulse is timed, and a pulse gives two of them or so (O'Connor, Phillips 1984)."""
    n = rng.poisson(1.6, 9000)
    times = draw(FLUORESCENCE, rng, 9000 * 12, 2.4).reshape(-1, 12)
    return np.where(np.arange(12) < n[:, None], times, 99).min(axis=1)[n > 0]


@case(RETURN)
def return_plain(rng):
    """A share with a low volatility, as the simulator has it."""
    return draw(RETURN, rng, 2500, 0.05, 0.7)


@case(RETURN, "single", ("outliers",), ("spread", "mixture"))
def return_jumps(rng):
    """On one day of fifty there is a jump on top, six times as large as the volatility (Merton 1976)."""
    return draw(RETURN, rng, 2500, 0.05, 1.1) + some(rng, 2500, 0.02)[:, None] * rng.normal(0, 6.6, (2500, 1))


@case(RETURN, "single", ("forward_backward_acceptance",))
def return_reported(rng):
    """Of the returns that are reported to a database by will, a third of the losses is kept back (Agarwal 2013)."""
    x = draw(RETURN, rng, 4000, 0.2, 1.4)[:, 0]
    return x[(x > 0) | some(rng, 4000, 0.66)]


@case(RETURN, "pair", ("peak_background", "spread"), ("outliers", "mixture"))
def return_stale(rng):
    """On one day of twelve nobody trades and the return is nought (Lesmond 1999), and volatility itself is random."""
    x = rng.normal(0.1, 1.2 * np.exp(rng.normal(-0.1, 0.45, 4000)))
    return np.where(some(rng, 4000, 0.08), 0, x)


@case(RAIN)
def rain_plain(rng):
    """Wet days as the simulator has them, many of which are near to nothing."""
    return draw(RAIN, rng, 2000, 0.6, 11.0)


@case(RAIN, "single", ("quantisation",))
def rain_bucket(rng):
    """The bucket of the gauge tips after each millimetre, and what is left in it is not seen."""
    return np.floor(draw(RAIN, rng, 3000, 1.3, 6.0))


@case(RAIN, "pair", ("quantisation", "saturation"))
def rain_small_gauge(rng):
    """The gauge is read to the next 2 mm, and it overflows at 30 mm."""
    return np.minimum(2 * np.rint(draw(RAIN, rng, 4000, 1.0, 10.0) / 2), 30)


@case(RAIN, "outside")
def rain_siphon(rng):
    """The recorder empties itself by a siphon at 20 mm and begins again with nought, which nobody corrected."""
    return draw(RAIN, rng, 3000, 1.6, 9.0) % 20


@case(ALPHA)
def alpha_plain(rng):
    """A thin source."""
    return draw(ALPHA, rng, 12_000, 0.3, 0.011)


@case(ALPHA, "single", ("radiative_tail",))
def alpha_thick_source(rng):
    """One alpha of seven has lost energy in the thickness of the source, 30 keV on average (Bortels, Collaers 1987)."""
    return draw(ALPHA, rng, 4000, 0.55, 0.009) - some(rng, 4000, 0.14)[:, None] * rng.exponential(0.03, (4000, 1))


@case(ALPHA, "single", ("offset", "scale"))
def alpha_zero(rng):
    """The zero of the scale is 5 keV too high; so near to each other are the lines that a scale looks the same."""
    return draw(ALPHA, rng, 2500, 0.5, 0.012) + 0.005


@case(ALPHA, "pair", ("radiative_tail", "flat_background"), ("outliers",))
def alpha_old_source(rng):
    """One alpha of nine loses 60 keV in dust on average, and one count of thirty is noise from 4.7 to 5.7 MeV."""
    e = draw(ALPHA, rng, 8000, 0.6, 0.01) - some(rng, 8000, 0.11)[:, None] * rng.exponential(0.06, (8000, 1))
    return either(some(rng, 8000, 0.03), rng.uniform(4.7, 5.7, (8000, 1)), e)


CASES: list[Case] = [c for c in list(globals().values()) if isinstance(c, Case)]
