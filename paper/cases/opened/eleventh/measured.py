"""Case cases of measured data, with the textbook's first model, and what the literature says is wrong with it.

Each file in `data` is of values and their counts, or of events; its README tells where each comes from.
"""

from pathlib import Path

import numpy as np

from avobench import task
from paper.cases.case import Case, case

DATA = Path(__file__).parent / "data"


def events(name):
    """The events of a file (N,), by value and count."""
    value, count = np.loadtxt(DATA / f"{name}.csv", delimiter=",", skiprows=1).T
    value = value.astype(int) if np.all(value == np.rint(value)) else value
    return np.repeat(value, count.astype(int))


def numbers(name):
    """The events of a file (N,) as real numbers."""
    return events(name).astype(float)


def poisson(name, feature, low, high):
    """Counts of one rate for all."""
    return task(lambda t, rng: rng.poisson(t[:, 0]), prior={"rate": (low, high)}, features=[feature], name=name)


def normal(name, feature, mean, sigma, step=None):
    """Normal numbers, written down in steps where the field does so and the model may know it."""

    def simulate(theta, rng):
        x = rng.normal(theta[:, 0], theta[:, 1])
        return x if step is None else step * np.rint(x / step)

    return task(simulate, prior={"mean": mean, "sigma": sigma}, features=[feature], name=name)


def lognormal(name, feature, median, sigma):
    """Lognormal numbers."""
    return task(
        lambda t, rng: t[:, 0] * np.exp(t[:, 1] * rng.normal(size=len(t))),
        prior={"median": median, "sigma": sigma},
        features=[feature],
        name=name,
    )


@case(poisson("owl-calls", "calls", 1, 15), "single", ("zero_inflation", "overdispersion"), ("spread", "mixture"))
def owls(rng):
    """Calls of barn owl siblings before the parent comes (Roulin and Bersier 2007, Anim. Behav. 74, 1099): a quarter
    are zeros; the example of zero-inflated counts in Zuur and others (2009), Mixed Effects Models, ch. 13, and Bolker
    and others (2013), Methods Ecol. Evol. 4, 501, who need overdispersion as well."""
    return events("owls")


@case(
    poisson("extramarital", "affairs", 0.3, 5),
    "single",
    ("zero_inflation", "overdispersion"),
    ("spread", "mixture", "flat_background", "heaping"),
)
def affairs(rng):
    """Extramarital affairs in a year (Fair 1978, J. Polit. Econ. 86, 45): three in four say none, and answers in
    classes are coded as 7 and 12; Greene (2003), Econometric Analysis, and Kleiber and Zeileis (2008) on excess
    zeros."""
    return events("affairs")


@case(
    poisson("gifts", "guilders", 2, 20),
    "single",
    ("zero_inflation", "heaping", "overdispersion"),
    ("spread", "mixture", "quantisation"),
)
def charity(rng):
    """Gifts in guilders after a mailing (Franses and Paap 2001, Quantitative Models in Marketing Research, ch. 7): 60 %
    give nothing, hence a two-part or Tobit model, and the others round sums: 5, 10, 25, 50."""
    return events("charity")


@case(poisson("epilepsy", "seizures", 3, 20), "single", ("overdispersion", "spread"), ("mixture", "zero_inflation"))
def seizures(rng):
    """Seizures of epileptics in two weeks (Thall and Vail 1990, Biometrics 46, 657): the standard example of
    overdispersion, by patients who differ; Breslow and Clayton (1993), Venables and Ripley (2002), ch. 10."""
    return events("seizures")


def _stars(theta, rng):
    """Half stars from 1 to 10, as the sum of nine steps of a chance that varies as a beta between users."""
    mean, scatter = theta.T
    size = 1 / scatter - 1
    return 1 + rng.binomial(9, rng.beta(mean * size, (1 - mean) * size))


@case(
    task(_stars, prior={"mean": (0.3, 0.9), "scatter": (0.02, 0.5)}, features=["half_stars"], name="ratings"),
    "single",
    ("heaping",),
    ("quantisation", "mixture"),
)
def movielens(rng):
    """Ratings of films in half stars (Harper and Konstan 2015, ACM Trans. Interact. Intell. Syst. 5, 19): half stars
    came in 2003 alone and are chosen less than whole ones, so that even numbers of half stars are too frequent."""
    return events("movielens")


@case(
    task(lambda t, rng: rng.binomial(5, t[:, 0]), prior={"ease": (0.4, 0.95)}, features=["right"], name="law-test"),
    "single",
    ("overdispersion", "spread"),
    ("mixture",),
)
def lsat7(rng):
    """Right answers to five items of the Law School Admission Test (Bock and Lieberman 1970, Psychometrika 35, 179):
    people differ in ability, so that the score varies more than a binomial; Lord (1965) on the beta-binomial."""
    return events("lsat7")


@case(poisson("murders", "murders", 0.1, 2))
def london_murders(rng):
    """Murders in London on each day from 2006 to 2011: Spiegelhalter and Barnett (2009, Significance 6, 5) found the
    numbers of a day to be as a Poisson distribution says. No visible fault."""
    return events("london_murders")


@case(
    poisson("hospital-stay", "days", 4, 20),
    "single",
    ("overdispersion", "spread"),
    ("threshold_loss", "mixture", "after_pulses"),
)
def medpar(rng):
    """Days in hospital of Medicare patients (Hilbe 2011, Negative Binomial Regression, ch. 9-11): strongly
    overdispersed, and without zeros, since nobody is admitted for no day."""
    return events("medpar")


def _rearrest(theta, rng):
    """Weeks until the next arrest, as an exponential time in whole weeks."""
    return np.ceil(rng.exponential(theta[:, 0]))


@case(
    task(_rearrest, prior={"mean": (20, 400)}, features=["week"], feature_units={"week": "wk"}, name="rearrest"),
    "single",
    ("censoring",),
    ("saturation", "peak_background", "truncation"),
)
def rossi(rng):
    """Weeks until prisoners set free are arrested again (Rossi, Berk and Lenihan 1980; Allison 1995, Survival Analysis,
    ch. 5): the study ended after 52 weeks, and three in four were not arrested until then."""
    return numbers("rossi")


@case(
    normal("hours-of-work", "hours", (-500, 1500), (400, 2500)),
    "single",
    ("censoring",),
    ("saturation", "peak_background", "mixture", "truncation"),
)
def hours(rng):
    """Hours that wives worked for pay in 1975 (Mroz 1987, Econometrica 55, 765): 325 of 753 did not, the example of the
    Tobit model, a normal censored at zero, in Wooldridge (2010), Econometric Analysis, ch. 17."""
    return numbers("hours")


@case(
    lognormal("arsenic", "arsenic", (0.3, 3), (0.2, 1.5)),
    "single",
    ("truncation",),
    ("turn_on", "analysis_window", "edge_acceptance", "second_exponential"),
)
def wells(rng):
    """Arsenic in wells of Bangladesh, in 100 ug/l (Gelman and Hill 2007, Data Analysis, sec. 5.4): only households
    whose well is above the national limit of 0.5 are in the data."""
    return events("wells")


@case(
    normal("stamp-paper", "thickness", (0.06, 0.12), (0.003, 0.04), step=0.001),
    "single",
    ("mixture",),
    ("heaping", "peak_background", "second_exponential", "radiative_tail", "outliers", "flat_background"),
)
def stamps(rng):
    """Thickness in mm of the paper of the Hidalgo stamps of 1872 (Wilson 1983; Izenman and Sommer 1988, J. Am. Stat.
    Assoc. 83, 941): paper of several mills was used, and the density has between three and seven modes."""
    return events("stamps")


@case(lognormal("storm-wind", "wind", (20, 90), (0.2, 0.9)), "single", ("quantisation",), ("heaping",))
def storms(rng):
    """Winds of Atlantic storms in knots (Landsea and Franklin 2013, Mon. Weather Rev. 141, 3576): the best track gives
    intensities in steps of 5 knots."""
    return numbers("storms")


@case(
    normal("pregnancy", "days", (265, 295), (5, 30), step=1.0),
    "single",
    ("outliers", "mixture"),
    ("resolution", "flat_background", "radiative_tail", "spread"),
)
def gestation(rng):
    """Length of pregnancies of the Child Health and Development Studies (Nolan and Speed 2000, Stat Labs, ch. 1): long
    tails at both sides, since dates of the last period are recalled wrongly, besides births before their time; Platt
    and others (2001, Stat. Med. 20, 3491) find the errors by a mixture of normals."""
    return numbers("gestation")


@case(
    normal("departures", "delay", (-10, 30), (2, 60), step=1.0),
    "single",
    ("radiative_tail",),
    ("mixture", "outliers", "second_exponential", "spread", "flat_background"),
)
def departures(rng):
    """Delays in minutes of flights from JFK in June 2013: a normal core and a long tail to one side, an exponential or
    power; Tu, Ball and Jank (2008, J. Am. Stat. Assoc. 103, 112) on the skewed distribution of the delay."""
    return numbers("departures")


def _inches(theta, rng):
    """Normal heights by the inch, at the middle of the class."""
    return np.floor(rng.normal(theta[:, 0], theta[:, 1])) + 0.5


@case(task(_inches, prior={"mean": (64, 72), "sigma": (1.5, 4)}, features=["height"], name="heights-of-fathers"))
def fathers(rng):
    """Heights of 1078 fathers by the inch (Pearson and Lee 1903, Biometrika 2, 357), who found a normal curve to fit;
    the model knows the classes. No visible fault."""
    return events("fathers")


@case(normal("wheat-yield", "bushels", (3, 5), (0.2, 1), step=0.01))
def wheat(rng):
    """Grain in lb of 500 plots sown alike (Mercer and Hall 1911, J. Agric. Sci. 4, 107, with Student's appendix), who
    found the yields to follow the normal law. No visible fault of the values, though neighbours are alike."""
    return events("wheat")


@case(
    lognormal("cow", "guess", (500, 2000), (0.1, 1.2)),
    "single",
    ("heaping", "outliers"),
    ("mixture", "quantisation", "flat_background", "spread"),
)
def penelope(rng):
    """17 184 guesses of a cow's weight in lb (Planet Money, National Public Radio, 2015; openintro): round numbers, and
    guesses in jest from 1 to 14 555; heaping of guesses as in Heitjan and Rubin (1991, Ann. Stat. 19, 2244)."""
    return numbers("penelope")


def _olive(theta, rng):
    """Two acids in percent, normal with a correlation."""
    oleic, sigma, linoleic, tau, rho = theta.T
    u, v = rng.normal(size=(2, len(theta)))
    return np.column_stack([oleic + sigma * u, linoleic + tau * (rho * u + np.sqrt(1 - rho**2) * v)])


@case(
    task(
        _olive,
        prior={"oleic": (68, 78), "sigma": (2, 8), "linoleic": (7, 13), "tau": (1, 5), "rho": (-0.98, 0.5)},
        features=["oleic", "linoleic"],
        name="olive-oil",
    ),
    "single",
    ("mixture",),
    ("peak_background", "conditional_response", "spread"),
)
def olive(rng):
    """Fatty acids of Italian olive oils (Forina and others 1983): oils of nine areas of three regions, which form
    groups of their own; Cook and Swayne (2007), Interactive and Dynamic Graphics, ch. 5."""
    return np.loadtxt(DATA / "olive.csv", delimiter=",", skiprows=1)


def _sat(theta, rng):
    """Two scores from 200 to 800 in tens, normal with a correlation."""
    verbal, quantitative, sigma, rho = theta.T
    u, v = rng.normal(size=(2, len(theta)))
    x = np.column_stack([verbal + sigma * u, quantitative + sigma * (rho * u + np.sqrt(1 - rho**2) * v)])
    return np.clip(10 * np.rint(x / 10), 200, 800)


@case(
    task(
        _sat,
        prior={"verbal": (500, 700), "quantitative": (500, 700), "sigma": (60, 200), "rho": (0, 0.95)},
        features=["verbal", "quantitative"],
        name="sat-scores",
    ),
    "single",
    ("heaping",),
    ("quantisation", "outliers", "mixture"),
)
def sat(rng):
    """Scores of the SAT as people told them on the web (Revelle, Wilt and Rosenthal 2010; data of the package psych):
    scores come in tens, but those told are multiples of fifty far too often; heaping as in Heitjan and Rubin (1991)."""
    return np.loadtxt(DATA / "sat.csv", delimiter=",", skiprows=1)


CASES: list[Case] = [each for each in list(globals().values()) if isinstance(each, Case)]
