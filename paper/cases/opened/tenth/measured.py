"""Cases of measured events with the answer of the literature, which was written down first.

Written without sight of the code. Where the tables come from is said beside them, in `data/README.md`.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avobench import task
from avobench.tasks import Task
from paper.cases.case import Case

DATA = Path(__file__).parent / "data"


def _read(name: str) -> NDArray:
    """The events of a table, (N,) or (N, d), each as often as its column of frequencies says."""
    with open(DATA / f"{name}.csv") as file:
        columns = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    if columns[-1] == "frequency":
        rows = np.repeat(rows[:, :-1], rows[:, -1].astype(int), axis=0)
    return rows[:, 0] if rows.shape[1] == 1 else rows


def _case(
    name: str, task: Task, why: str, right: tuple[str, ...] = (), defensible: tuple[str, ...] = (), pair: bool = False
) -> Case:
    return Case(name, task, lambda rng: _read(name), why, right, defensible, pair)


def _count(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A count of one mean, as of Poisson."""
    return rng.poisson(theta[:, 0])


def _of_twelve(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A count among twelve that have one chance each."""
    return rng.binomial(12, theta[:, 0])


def _of_ten(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A count among ten that have one chance each."""
    return rng.binomial(10, theta[:, 0])


def _number(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A normal number."""
    return rng.normal(theta[:, 0], theta[:, 1])


def _power(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A number whose logarithm is normal."""
    return np.exp(rng.normal(theta[:, 0], theta[:, 1]))


def _strength(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A number as of Weibull."""
    return theta[:, 1] * rng.weibull(theta[:, 0])


def _time(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """An exponential time of one mean."""
    return rng.exponential(theta[:, 0])


def _poisson(name: str, feature: str, low: float, high: float) -> Task:
    return task(_count, prior={"mean": (low, high)}, features=[feature], name=name)


def _binomial(name: str, feature: str, low: float, high: float) -> Task:
    return task(_of_twelve, prior={"chance": (low, high)}, features=[feature], name=name)


def _normal(name: str, feature: str, mean: tuple[float, float], sd: tuple[float, float]) -> Task:
    return task(_number, prior={"mean": mean, "sd": sd}, features=[feature], name=name)


def _lognormal(name: str, feature: str, mu: tuple[float, float], sigma: tuple[float, float]) -> Task:
    return task(_power, prior={"mu": mu, "sigma": sigma}, features=[feature], name=name)


def _weibull(name: str, feature: str, shape: tuple[float, float], scale: tuple[float, float]) -> Task:
    return task(_strength, prior={"shape": shape, "scale": scale}, features=[feature], name=name)


def _exponential(name: str, feature: str, low: float, high: float) -> Task:
    return task(_time, prior={"mean": (low, high)}, features=[feature], name=name)


def _magnitude(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A magnitude above 3.95 with the b of Gutenberg and Richter."""
    return 3.95 + rng.exponential(1 / (theta[:, 0] * np.log(10)))


def _eruption(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The minutes of a short eruption or, in a share, of a long one."""
    long = rng.random(len(theta)) < theta[:, 0]
    return np.where(long, rng.normal(theta[:, 1], theta[:, 2]), rng.normal(1.95, 0.25, len(theta)))


def _light(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A measured speed of light, of which the true value is known today."""
    return rng.normal(734.5, theta[:, 0])


def _price(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A price from 1000 to 2200 dollars with a density that falls exponentially."""
    fall = theta[:, 0]
    return 1000 - 1200 / fall * np.log1p(-rng.random(len(theta)) * (1 - np.exp(-fall)))


def _score(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A score in whole points from 0 to 100, normal before that."""
    return np.clip(np.rint(rng.normal(theta[:, 0], theta[:, 1])), 0, 100)


def _rain(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The rain of a wet day, a gamma variable."""
    return rng.gamma(theta[:, 0], theta[:, 1])


def _pitch(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The speed and the vertical break of a pitch of one kind."""
    return np.stack([rng.normal(theta[:, 0], theta[:, 1]), rng.normal(theta[:, 2], theta[:, 3])], axis=1)


def _sea(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The height of the waves and the surge, which have nothing to do with each other."""
    return np.stack([rng.gamma(theta[:, 0], theta[:, 1]), rng.normal(0.06, theta[:, 2])], axis=1)


def _pair(first: NDArray, second: NDArray, rho: NDArray, rng: np.random.Generator) -> NDArray:
    """Two normal numbers with a correlation, from their means and deviations."""
    z = rng.normal(size=(2, len(rho)))
    y = rho * z[0] + np.sqrt(1 - rho**2) * z[1]
    return np.stack([first[0] + first[1] * z[0], second[0] + second[1] * y], axis=1)


def _body(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The height of a man in inches and his left middle finger in cm."""
    return _pair((theta[:, 0], 2.55), (theta[:, 1], 0.55), theta[:, 2], rng)


def _bill(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The length and the depth of the bill of a penguin in mm."""
    return _pair((theta[:, 0], 5.4), (theta[:, 1], 2.0), theta[:, 2], rng)


OVER, MIX, ZERO = "overdispersion", "mixture", "zero_inflation"

CASES: list[Case] = [
    _case(
        "weldon-dice",
        _binomial("weldon-dice", "fives_and_sixes", 0.3, 0.37),
        "The chance of a five or a six is a little over a third, and with that the binomial fits (Pearson 1900).",
    ),
    _case(
        "cycling-deaths",
        _poisson("cycling-deaths", "deaths", 0.2, 1.5),
        "The deaths of cyclists in London are as a Poisson process has them (Aberdein, Spiegelhalter 2013).",
    ),
    _case(
        "women-in-queues",
        task(_of_ten, prior={"chance": (0.2, 0.7)}, features=["women"], name="women-in-queues"),
        "Women in queues of ten in the London underground are binomial within the error (Friendly, Meyer 2016).",
    ),
    _case(
        "doctor-visits",
        _poisson("doctor-visits", "visits", 0.1, 1),
        "Health differs from person to person, and the negative binomial is needed (Cameron, Trivedi 1986).",
        (OVER,),
        (ZERO, MIX),
    ),
    _case(
        "boat-trips",
        _poisson("boat-trips", "trips", 0.5, 6),
        "Two of three households never go there, and the others differ widely (Ozuna, Gomez 1995).",
        (ZERO, OVER),
        (MIX,),
        True,
    ),
    _case(
        "saxony-boys",
        _binomial("saxony-boys", "boys", 0.45, 0.58),
        "The chance of a boy differs from family to family (Edwards 1958; Lindsey, Altham 1998).",
        (OVER,),
        (MIX,),
    ),
    _case(
        "bundesliga-goals",
        _poisson("bundesliga-goals", "goals", 1, 3),
        "Teams differ in their strength, so that goals over all matches are overdispersed (Reep 1971).",
        (OVER,),
        (MIX,),
    ),
    _case(
        "phd-articles",
        _poisson("phd-articles", "articles", 0.5, 4),
        "Scientists differ in their productivity, and the negative binomial fits well (Long 1997).",
        (OVER,),
        (ZERO, MIX),
    ),
    _case(
        "grouse-ticks",
        _poisson("grouse-ticks", "ticks", 2, 15),
        "Ticks are clumped by brood and place, as parasites are (Elston 2001).",
        (OVER,),
        (ZERO, MIX),
    ),
    _case(
        "school-absences",
        _poisson("school-absences", "days", 5, 30),
        "Children differ in how often they are absent (Aitkin 1978; Venables, Ripley 2002).",
        (OVER,),
        (MIX,),
    ),
    _case(
        "federalist-may",
        _poisson("federalist-may", "may", 0.2, 1.5),
        "A word comes in clusters, and the negative binomial fits where Poisson does not (Mosteller, Wallace 1964).",
        (OVER,),
        (ZERO, MIX),
    ),
    _case(
        "daily-births",
        _poisson("daily-births", "births", 7500, 10_500),
        "Fewer children are born on weekends, and the rate changes with the season too (Gelman 2013).",
        (MIX, OVER),
    ),
    _case(
        "coal-gaps",
        _exponential("coal-gaps", "days", 100, 500),
        "Explosions became three times as rare about 1890 (Maguire 1952; Jarrett 1979; Raftery, Akman 1986).",
        (MIX, "second_exponential", "spread"),
        ("outliers",),
    ),
    _case(
        "faithful-waits",
        _normal("faithful-waits", "waiting", (60, 80), (5, 20)),
        "There are two kinds of eruption, after which one waits for 54 or for 80 minutes (Azzalini, Bowman 1990).",
        (MIX,),
        ("peak_background",),
    ),
    _case(
        "geyser-durations",
        task(
            _eruption,
            prior={"share": (0.3, 0.9), "long": (3.8, 4.8), "width": (0.15, 0.6)},
            features=["duration"],
            name="geyser-durations",
        ),
        "At night a duration was only noted as short or long, which are 2 and 4 here (Azzalini, Bowman 1990).",
        ("peak_background", "quantisation"),
    ),
    _case(
        "fiji-magnitudes",
        task(_magnitude, prior={"b": (0.6, 1.8)}, features=["magnitude"], name="fiji-magnitudes"),
        "Magnitudes are rounded to tenths, and those below 4.6 are incomplete, as in all such catalogues (Kagan 2003).",
        ("edge_acceptance", "quantisation"),
        (),
        True,
    ),
    _case(
        "bmw-returns",
        _normal("bmw-returns", "percent", (-0.2, 0.2), (0.8, 2.5)),
        "Volatility changes, which gives heavy tails, and holidays are entered as nought (Cont 2001).",
        ("spread", "outliers", "peak_background"),
        (MIX,),
    ),
    _case(
        "laguardia-wind",
        _weibull("laguardia-wind", "speed", (1.2, 3.2), (6, 16)),
        "Stations report whole knots and, below three of them, a calm (ASOS User's Guide 1998).",
        ("quantisation",),
        ("peak_background", "edge_acceptance", "dead_region"),
    ),
    _case(
        "reported-heights",
        _normal("reported-heights", "inches", (64, 72), (2, 6)),
        "Some students gave centimetres or feet where inches were asked for, or jokes (Irizarry 2019).",
        ("outliers",),
        (MIX, "spread", "flat_background"),
    ),
    _case(
        "davis-weights",
        _normal("davis-weights", "kg", (-2, 2), (0.5, 8)),
        "One weight was entered in the place of a height, and reported weights have last digits 0 and 5 (Fox 2008).",
        ("outliers", "quantisation"),
        ("spread",),
    ),
    _case(
        "carolina-births",
        _normal("carolina-births", "ounces", (105, 130), (10, 30)),
        "Most weights are normal, with a second population of small ones below that (Wilcox, Russell 1983).",
        (MIX,),
        ("outliers", "radiative_tail", "spread", "flat_background"),
    ),
    _case(
        "breastfeeding",
        _exponential("breastfeeding", "weeks", 6, 40),
        "Mothers remember whole months and halves of years (Klein, Moeschberger 1997).",
        ("quantisation", "peak_background"),
        (MIX, "spread", "second_exponential"),
    ),
    _case(
        "bird-strikes",
        _lognormal("bird-strikes", "feet", (5, 8), (0.8, 2.5)),
        "Pilots report round heights, as 50, 100, 500 and 1000 feet (Dolbeer 2006).",
        ("quantisation",),
        ("peak_background", MIX),
    ),
    _case(
        "diamond-prices",
        task(_price, prior={"fall": (0.1, 3)}, features=["dollars"], name="diamond-prices"),
        "There is no diamond between 1455 and 1545 dollars in this table, which is a fault of it (Wickham 2009).",
        ("dead_region",),
    ),
    _case(
        "light-1879",
        task(_light, prior={"sd": (30, 200)}, features=["speed"], name="light-1879"),
        "Michelson's speeds are too high, as is known today, which a scale tells as well (Stigler 1977).",
        ("offset", "scale"),
    ),
    _case(
        "light-1882",
        _normal("light-1882", "deviation", (15, 40), (3, 15)),
        "Two of the 66 times of Newcomb are far off (Stigler 1977; Gelman 2013).",
        ("outliers",),
        ("spread", MIX),
    ),
    _case(
        "galaxies",
        _normal("galaxies", "velocity", (15, 26), (2, 8)),
        "The galaxies are in clusters with a void between them (Roeder 1990).",
        (MIX, "peak_background"),
        ("outliers", "spread"),
    ),
    _case(
        "scottish-chests",
        _normal("scottish-chests", "inches", (38, 42), (1.5, 3)),
        "Chests were measured to the whole inch and are normal otherwise (Quetelet 1846; Stigler 1986).",
        ("quantisation",),
    ),
    _case(
        "covid-cycles",
        _normal("covid-cycles", "cycles", (20, 100), (2, 30)),
        "The machine stops after 45 cycles, and who has not passed the threshold by then is given 45.",
        ("saturation",),
        ("peak_background", MIX),
    ),
    _case(
        "cps-earnings",
        _weibull("cps-earnings", "earnings", (0.8, 3), (8, 40)),
        "Earnings are cut at a top code of 25 565 dollars, and who did not work earned nothing (Dehejia, Wahba 1999).",
        ("saturation", "peak_background"),
        (),
        True,
    ),
    _case(
        "boston-values",
        _lognormal("boston-values", "value", (2.7, 3.4), (0.2, 0.6)),
        "Values above 50 000 dollars were entered as 50 000 by the census (Gilley, Pace 1996).",
        ("saturation",),
        ("peak_background", "outliers", MIX),
    ),
    _case(
        "regents-scores",
        task(
            _score,
            prior={"mean": (50, 85), "sd": (8, 25)},
            features=["score"],
            kinds={"score": "continuous"},
            name="regents-scores",
        ),
        "Teachers lifted scores a little below the pass mark of 65 to that (Dee 2011).",
        ("peak_background",),
        ("dead_region",),
    ),
    _case(
        "commutes",
        _lognormal("commutes", "minutes", (2.3, 4), (0.4, 1.2)),
        "People give times in multiples of five minutes (Rietveld 2002).",
        ("quantisation",),
        ("peak_background",),
    ),
    _case(
        "rain-england",
        task(_rain, prior={"shape": (0.3, 1.5), "scale": (3, 15)}, features=["mm"], name="rain-england"),
        "Rain was read in hundredths of an inch and given in steps of a quarter of a millimetre or so (Coles 2001).",
        ("quantisation",),
        ("edge_acceptance",),
    ),
    _case(
        "kershaw-pitches",
        task(
            _pitch,
            prior={"speed": (82, 95), "speed_sd": (1, 9), "rise": (0, 15), "rise_sd": (2, 12)},
            features=["speed", "rise"],
            name="kershaw-pitches",
        ),
        "He throws a fast ball, a slider and a curve, each with a speed and a break of its own (Pane 2013).",
        (MIX,),
        ("correlation", "conditional_response", "spread"),
    ),
    _case(
        "newlyn-waves",
        task(
            _sea,
            prior={"shape": (1.5, 6), "scale": (0.4, 2), "surge_sd": (0.08, 0.3)},
            features=["wave", "surge"],
            feature_units={"wave": "m", "surge": "m"},
            name="newlyn-waves",
        ),
        "One storm makes both the waves and the surge, so that they are high together (Coles, Tawn 1994).",
        ("correlation", "conditional_response"),
        (MIX, "spread"),
    ),
    _case(
        "criminal-fingers",
        task(
            _body,
            prior={"height": (63, 68), "finger": (11, 12.2), "rho": (0.4, 0.85)},
            features=["height", "finger"],
            name="criminal-fingers",
        ),
        "Heights are grouped by the inch and fingers by the millimetre (Macdonell 1902; Student 1908).",
        ("quantisation on height", "quantisation on finger"),
    ),
    _case(
        "penguin-bills",
        task(
            _bill,
            prior={"length": (40, 48), "depth": (15.5, 18.8), "rho": (-0.7, 0.7)},
            features=["length", "depth"],
            name="penguin-bills",
        ),
        "They are of three species, of which Gentoos have long and flat bills (Gorman 2014; Horst 2020).",
        (MIX,),
        ("correlation", "spread"),
    ),
]
