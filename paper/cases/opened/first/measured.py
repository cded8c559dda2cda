"""Ten data sets that were measured, a simple simulator of each, and what the literature knows of it.

None of them is one of `examples/real`. The tables are facts, printed in what is cited.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import avobench
from avobench.tasks import Task
from paper.cases.case import Case

Array = NDArray[np.float64]
Rng = np.random.Generator
DATA = Path(__file__).parent / "data"


def counted(*times: int) -> NDArray[np.int64]:
    """Counts from how often 0, 1, 2, ... were seen."""
    return np.repeat(np.arange(len(times)), times)


def kept(name: str) -> NDArray:
    """The values of a table of values and how often each was seen."""
    value, times = np.loadtxt(DATA / f"{name}.csv", delimiter=",", unpack=True)
    return np.repeat(value, times.astype(int))


def poisson(name: str, low: float, high: float) -> Task:
    """Independent events of one rate."""
    return avobench.task(lambda theta, rng: rng.poisson(theta[:, 0]), name=name, prior={"rate": (low, high)})


def weeks(theta: Array, rng: Rng) -> NDArray[np.int64]:
    """The same chance of an arrest in each week: (n, 1) -> week (n,)."""
    return rng.geometric(theta[:, 0])


def classes_of_crabs(theta: Array, rng: Rng) -> Array:
    """One normal population, in the classes of 0.004 of the measurements: (n, 2) -> ratio (n,)."""
    return 0.5815 + 0.004 * np.rint((rng.normal(theta[:, 0], theta[:, 1]) - 0.5815) / 0.004)


def season(theta: Array, rng: Rng) -> Array:
    """A sinusoid over the year, with weather: mean, amplitude, spread (n, 3) -> temperature (n,) of a random day."""
    mean, amplitude, spread = theta.T
    return mean + amplitude * np.cos(rng.uniform(0, 2 * np.pi, len(theta))) + rng.normal(0, spread)


CLAIMS = counted(7840, 1317, 239, 42, 14, 4, 4, 1)
HOUSES = counted(168, 32, 16, 6, 1)
DEATHS = counted(162, 267, 271, 185, 111, 61, 27, 8, 3, 1)
BOMBS = np.repeat([0, 1, 2, 3, 4, 7], (229, 211, 93, 35, 7, 1))
YEAST = counted(0, 20, 43, 53, 86, 70, 54, 37, 18, 10, 5, 2, 2)
STATURE = np.repeat(
    [61.7, 62.2, 63.2, 64.2, 65.2, 66.2, 67.2, 68.2, 69.2, 70.2, 71.2, 72.2, 73.2, 73.7],
    (5, 7, 32, 59, 48, 117, 138, 120, 167, 99, 64, 41, 17, 14),
)
CRABS = 0.5815 + 0.004 * counted(
    *(1, 3, 5, 2, 7, 10, 13, 19, 20, 25, 40, 31, 60, 62, 54), *(74, 84, 86, 96, 85, 75, 47, 43, 24, 19, 9, 5, 0, 1)
)

CASES = (
    Case(
        "claims",
        poisson("claims", 0.02, 1),
        lambda rng: CLAIMS,
        "Claims of 9461 drivers in a year, Belgium (Thyrion, Astin Bull. 1 (1960) 142; Simar, Ann. Stat. 4 (1976) "
        "1200): a rate that differs between drivers, a mixed Poisson distribution",
        ("overdispersion", "spread", "mixture"),
        ("zero_inflation",),
    ),
    Case(
        "cholera",
        poisson("cholera", 0.05, 3),
        lambda rng: HOUSES,
        "Cases of cholera in 223 houses of a village (McKendrick, Proc. Edinb. Math. Soc. 44 (1926) 98): many houses "
        "were not exposed, and the others follow a Poisson distribution",
        ("zero_inflation",),
        ("overdispersion", "spread", "mixture"),
    ),
    Case(
        "deaths",
        poisson("deaths", 0.5, 6),
        lambda rng: DEATHS,
        "Notices of deaths of women over 80 in The Times, 1096 days (Schilling, J. Am. Stat. Assoc. 42 (1947) 407; "
        "Hasselblad, ibid. 64 (1969) 1459): two Poisson distributions, of summer and winter",
        ("mixture", "overdispersion", "spread"),
    ),
    Case(
        "bombs",
        poisson("bombs", 0.2, 3),
        lambda rng: BOMBS,
        "Flying bombs on 576 squares of London (Clarke, J. Inst. Actuaries 72 (1946) 481): a Poisson distribution",
    ),
    Case(
        "yeast",
        poisson("yeast", 1, 10),
        lambda rng: YEAST,
        "Yeast cells on 400 squares of a haemocytometer, fourth sample (Student, Biometrika 5 (1907) 351): a Poisson "
        "distribution",
    ),
    Case(
        "arrests",
        avobench.task(weeks, name="arrests", prior={"chance": (0.002, 0.05)}),
        lambda rng: kept("arrests").astype(np.int64),
        "Weeks to an arrest of 432 men out of prison (Rossi, Berk, Lenihan 1980): the study ended after 52 weeks, and "
        "who was not arrested is entered with 52",
        ("censoring",),
        ("truncation",),
    ),
    Case(
        "stature",
        avobench.task(
            lambda theta, rng: rng.normal(theta[:, 0], theta[:, 1]),
            name="stature",
            prior={"mean": (62, 74), "std": (1, 5)},
        ),
        lambda rng: STATURE,
        "Stature of 928 grown children (Galton, J. Anthropol. Inst. 15 (1886) 246): a normal distribution, in classes "
        "of one inch",
        ("quantisation",),
    ),
    Case(
        "crabs",
        avobench.task(classes_of_crabs, name="crabs", prior={"mean": (0.62, 0.68), "std": (0.008, 0.04)}),
        lambda rng: CRABS,
        "Forehead by length of 1000 shore crabs, Naples (Weldon, Proc. R. Soc. 54 (1893) 318; Pearson, Phil. Trans. A "
        "185 (1894) 71): two normal populations; a peak of others beside one normal population says the same",
        ("mixture", "peak_background"),
        ("spread", "radiative_tail"),
    ),
    Case(
        "rain",
        avobench.task(
            lambda theta, rng: rng.exponential(theta[:, 0]), name="rain", prior={"mean": (2, 20)}, units={"mean": "mm"}
        ),
        lambda rng: kept("rain"),
        "Rain on 623 wet days in Seattle: amounts follow a mixture of two exponentials (Woolhiser and Pegram, J. Appl. "
        "Meteorol. 18 (1979) 34); they are read in steps of 0.01 inch, 0.254 mm, besides",
        ("second_exponential", "mixture", "spread"),
        ("quantisation",),
    ),
    Case(
        "temperatures",
        avobench.task(season, name="temperatures", prior={"mean": (0, 20), "amplitude": (1, 12), "spread": (1, 8)}),
        lambda rng: kept("temperatures"),
        "Lowest temperature of 1461 days in Seattle: read in whole degrees Fahrenheit, and converted (Rhines et al., "
        "Q. J. R. Meteorol. Soc. 141 (2015) 2923)",
        ("quantisation",),
    ),
)
"""Ten data sets, in two of which nothing is missing."""
