"""Measured data with an answer from the literature. Their sources are in README.md, and the files in data/."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import lognormal, negative_binomial, normal, one_and_more, poisson, whole_normal

Rng = np.random.Generator
read = reader(__file__)


def ball(theta: NDArray, rng: Rng) -> NDArray:
    """Return the number on a ball, from 1 to 39: all alike, or ever more or less likely along the numbers."""
    u = rng.random(len(theta))
    turned = np.where(rng.random(len(theta)) < 0.5 * (1 + theta[:, 0] * (2 * u - 1)), u, 1 - u)
    return 1 + np.floor(39 * turned)


def peas(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of the two copies of three genes are the dominant ones, in a plant of the second generation."""
    return rng.binomial(2, theta)


def tenth_normal(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to tenths."""
    return np.round(normal(theta, rng), 1)


def root_of_tenths(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values that are roots of whole tenths where they are positive."""
    x = normal(theta, rng)
    return np.where(x > 0, np.sqrt(np.round(x * x, 1)), x)


def two_normals(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values with a correlation, rounded to hundredths."""
    z = rng.standard_normal((2, len(theta)))
    other = theta[:, 4] * z[0] + np.sqrt(1 - theta[:, 4] ** 2) * z[1]
    return np.round(np.stack([theta[:, 0] + theta[:, 1] * z[0], theta[:, 2] + theta[:, 3] * other], axis=1), 2)


AGES = read("urine_of_children")[:, 0]
"""Ages of the children that were measured."""


def along_age(theta: NDArray, rng: Rng) -> NDArray:
    """Return the age of one of the children, and a value that is normal about a line in the age, in tenths."""
    age = rng.choice(AGES, len(theta))
    line = theta[:, 0] - theta[:, 1] * age
    return np.stack([age, np.round(line + theta[:, 2] * rng.standard_normal(len(theta)), 1)], axis=1)


SMOKERS = task(
    one_and_more, prior={"further": (3, 60), "shape": (0.3, 10)}, features=["cigarettes"], name="cigarettes-a-day"
)
MOTHERS = task(poisson, prior={"rate": (0.2, 20)}, features=["cigarettes"], name="mothers-who-smoke")
DIRECTORS = task(poisson, prior={"rate": (2, 40)}, features=["interlocks"], name="shared-directors")
NODES = task(negative_binomial, prior={"mean": (0.5, 12), "shape": (0.2, 6)}, features=["nodes"], name="colon-nodes")
LOTTERY = task(ball, prior={"tilt": (-0.9, 0.9)}, features=["number"], kinds={"number": "count"}, name="lottery-balls")
PEAS = task(
    peas,
    prior={"round": (0.2, 0.8), "yellow": (0.2, 0.8), "grey": (0.2, 0.8)},
    features=["round", "yellow", "grey"],
    name="mendel-peas",
)
RATS = task(whole_normal, prior={"mean": (25, 55), "width": (1, 15)}, features=["hindfoot"], name="kangaroo-rats")
PENSIONS = task(tenth_normal, prior={"mean": (60, 130), "width": (5, 60)}, features=["joined"], name="pension-plans")
INNSBRUCK = task(root_of_tenths, prior={"mean": (-2, 5), "width": (0.5, 5)}, features=["root"], name="innsbruck-rain")
WAGES = task(
    lognormal, prior={"median": (50, 200), "log_width": (0.1, 1)}, features=["wage"], name="mid-atlantic-wages"
)
RATIO = task(normal, prior={"mean": (0.4, 1.1), "width": (0.05, 0.5)}, features=["ratio"], name="loan-to-value")
SWISS = task(normal, prior={"mean": (-0.3, 0.4), "width": (0.3, 3)}, features=["change"], name="swiss-market")
CREATININE = task(
    lognormal, prior={"median": (0.5, 2), "log_width": (0.05, 0.8)}, features=["creatinine"], name="creatinine"
)
TALL = task(normal, prior={"mean": (160, 190), "width": (3, 15)}, features=["height"], name="tall-men")
ATHLETES = task(
    two_normals,
    prior={"lean": (40, 90), "width": (5, 25), "fat": (5, 25), "spread": (2, 12), "tie": (-0.95, 0.95)},
    features=["lean", "fat"],
    name="athletes",
)
URINE = task(
    along_age,
    prior={"birth": (5, 40), "fall": (0, 4), "width": (1, 12)},
    features=["age", "gag"],
    name="urine-of-children",
)


@case(SMOKERS, "single", right=("quantisation", "heaping"), defensible=("peak_background", "mixture", "overdispersion"))
def cigarettes_a_day(rng: Rng) -> NDArray:
    """Cigarettes that smokers say they smoke in a day: 20, a pack, comes most often, then 30, 10, 40 and 15.

    J. Mullahy (1997), Rev. Econ. Stat. 79, 586 (the data); on heaping in halves and wholes of a pack H. Wang and
    D. Heitjan (2008), Stat. Med. 27, 3789.
    """
    return read("cigarettes_a_day", counts=True)


@case(
    MOTHERS,
    "single",
    right=("zero_inflation",),
    defensible=("mixture", "overdispersion", "spread", "flat_background", "quantisation", "heaping"),
)
def mothers_who_smoke(rng: Rng) -> NDArray:
    """Cigarettes that mothers smoked in a day while they were pregnant: most of them do not smoke at all.

    J. Mullahy (1997), Rev. Econ. Stat. 79, 586; J. Wooldridge, Introductory Econometrics, data BWGHT. That smokers
    report tens and packs is there too, but is the smaller part.
    """
    return read("mothers_who_smoke", counts=True)


@case(DIRECTORS, "single", right=("overdispersion", "spread"), defensible=("mixture", "zero_inflation"))
def shared_directors(rng: Rng) -> NDArray:
    """Directors that a large Canadian firm shares with others: far more with banks and large firms than with others.

    M. Ornstein (1976), Can. J. Sociol. 1, 411; J. Fox (2008), Applied Regression Analysis, chapter 15: the textbook's
    example of counts that scatter more than Poisson ones.
    """
    return read("shared_directors", counts=True)


@case(NODES, "single", right=("threshold_loss",))
def colon_nodes(rng: Rng) -> NDArray:
    """Lymph nodes with cancer in patients of a trial for stage C: to be of this stage, a node must be involved.

    C. Moertel et al. (1990), N. Engl. J. Med. 322, 352. So those with none are not in it, but for two slips.
    """
    return read("colon_nodes", counts=True)


@case(LOTTERY)
def lottery_balls(rng: Rng) -> NDArray:
    """Numbers drawn in 122 weeks of a lottery of Ontario, seven of 39 in each: all are as likely, by its rules.

    D. Bellhouse (1982), Can. Public Policy 8, 311. That no number comes twice in a week does not show in one number.
    """
    return read("lottery_balls", counts=True)


@case(PEAS)
def mendel_peas(rng: Rng) -> NDArray:
    """Peas of Mendel's second generation, by three genes that are passed on by themselves, as his law says.

    G. Mendel (1866), Versuche ueber Pflanzen-Hybriden; R. Fisher (1936), Ann. Sci. 1, 115, who finds that these
    counts agree with the law, if anything too well.
    """
    return read("mendel_peas", counts=True)


@case(RATS, "single", right=("mixture",), defensible=("peak_background", "outliers", "flat_background"))
def kangaroo_rats(rng: Rng) -> NDArray:
    """Hind feet of two species of kangaroo rats in one desert: Merriam's is small, and the banner-tailed one is large.

    S. Ernest et al. (2016), Ecology 97, 1082: the Portal project. One in six is of the large species.
    """
    return read("kangaroo_rats")


@case(
    PENSIONS,
    "single",
    right=("saturation", "censoring"),
    defensible=("peak_background", "edge_acceptance", "truncation"),
)
def pension_plans_joined(rng: Rng) -> NDArray:
    """Per cent of workers who join the pension plan of their firm: no more than all can, and in four of ten all do.

    L. Papke and J. Wooldridge (1996), J. Appl. Econometrics 11, 619, who wrote of shares that pile up at one.
    """
    return read("pension_plans_joined")


@case(INNSBRUCK, "single", right=("saturation", "censoring"), defensible=("peak_background", "edge_acceptance"))
def innsbruck_rain(rng: Rng) -> NDArray:
    """Root of the rain of three days in Innsbruck: normal, but that less than none is recorded as 0.

    J. Messner, G. Mayr and A. Zeileis (2016), R Journal 8(1), 173: the example of a model that is censored at zero.
    """
    return read("innsbruck_rain")


@case(
    WAGES,
    "single",
    right=("saturation", "peak_background"),
    defensible=("censoring", "mixture", "second_exponential", "outliers", "radiative_tail", "quantisation", "heaping"),
)
def mid_atlantic_wages(rng: Rng) -> NDArray:
    """Wages of men: those beyond the top code of the survey stand together at about 280 thousand, a hump by itself.

    G. James, D. Witten, T. Hastie and R. Tibshirani (2013), An Introduction to Statistical Learning, section 7.1: a
    group of high earners, above 250 thousand. In the Current Population Survey one value stands for all of these.
    """
    return read("mid_atlantic_wages")


@case(
    RATIO,
    "single",
    right=("peak_background",),
    defensible=("quantisation", "heaping", "saturation", "mixture", "second_exponential", "outliers", "spread"),
)
def loan_to_value(rng: Rng) -> NDArray:
    """Loan for a house in Boston, as a share of its value: beyond 80 % an insurance is due, so that many ask for 80 %.

    A. Munnell, G. Tootell, L. Browne and J. McEneaney (1996), Am. Econ. Rev. 86, 25; J. Stock and M. Watson,
    Introduction to Econometrics, chapter 11. There are smaller peaks at 90 and 95 %.
    """
    return read("loan_to_value")


@case(
    SWISS,
    "single",
    right=("spread", "outliers"),
    defensible=("mixture", "second_exponential", "radiative_tail", "flat_background", "peak_background"),
)
def swiss_market(rng: Rng) -> NDArray:
    """Changes of the Swiss index of shares from day to day, 1991 to 1998: calm and restless times, and heavy tails.

    R. Cont (2001), Quant. Finance 1, 223: what all such changes have in common.
    """
    return read("swiss_market")


@case(CREATININE, "single", right=("quantisation",), defensible=("heaping", "outliers", "radiative_tail", "spread"))
def creatinine(rng: Rng) -> NDArray:
    """Creatinine in the blood of people of Olmsted County, which the laboratory gives in tenths of a mg/dl.

    A. Dispenzieri et al. (2012), Mayo Clin. Proc. 87, 517. Most of the values are 0.8 to 1.3, a handful of steps.
    """
    return read("creatinine")


@case(TALL)
def tall_men(rng: Rng) -> NDArray:
    """Heights of men who smoked, measured in a survey of health of the United States: normal, as Quetelet said.

    M. Hernan and J. Robins (2020), Causal Inference: What If (the data NHEFS); A. Quetelet (1835), Sur l'homme.
    """
    return read("tall_men")


@case(
    ATHLETES,
    "single",
    right=("mixture",),
    defensible=("peak_background", "conditional_response", "flat_background", "spread"),
)
def athletes_of_both_sexes(rng: Rng) -> NDArray:
    """Lean mass and fat of Australian athletes, half of them women, who have less of the one and more of the other.

    R. Telford and R. Cunningham (1991), Med. Sci. Sports Exerc. 23, 788; R. Cook and S. Weisberg (1994), An
    Introduction to Regression Graphics.
    """
    return read("athletes")


@case(
    URINE,
    "single",
    right=("conditional_response on gag",),
    defensible=("radiative_tail on gag", "second_exponential on gag", "outliers on gag", "spread", "mixture"),
)
def urine_of_children(rng: Rng) -> NDArray:
    """A substance in the urine of children falls steeply after birth, and slowly from two years on: not along a line.

    W. Venables and B. Ripley (2002), Modern Applied Statistics with S. Its scatter falls with age too.
    """
    return read("urine_of_children")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
