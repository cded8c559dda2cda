"""Whether fresh events at an estimate agree with the observed ones, at any size, and which other answers do as well.

Each feature is looked at by Neyman's smooth test, which sees a shift, another width and other tails, and by a scan of
intervals of all widths, which sees a narrow peak. Both hold for few events too. A classifier that learns from one half
of the events and judges the other (D. Lopez-Paz, M. Oquab, ICLR 2017) sees how features depend on each other.

A simulator that depends on the square of a parameter, or in which two parameters may change places, has several equally
good answers, and a method ends at one of them. Each candidate is a set of parameters with other signs, or with two of
them in each other's place. It is believed if events simulated there agree with the observed ones.
"""

from collections.abc import Callable
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.errors import SimulatorError, text_of
from avobench.tasks.prior import Distributed

SHARE = 10
"""One in so many of the simulated events that are allowed is held back for the test."""
LEVEL = 0.01
"""A p-value below it is a doubt. One sound fit in twenty may be doubted, for what theta is off by."""
FEWEST = 10
"""Events of each kind below which nothing is said."""
ROUNDING = 1e-12
"""Probabilities that differ by less are the same."""
LEARNT_FROM = 100
"""Events of each kind in either half from which a classifier learns."""
MOST_INTERVALS = 1024
"""Intervals of the least width in which the events of a feature are counted, at most; FEWEST lie in each."""
MOST_DEGREES = 8
"""Polynomials of the ranks of a feature that are compared, at most. Of what an event of Student's law tells of its
degrees of freedom they hold three quarters and more."""
MOST_TIMES = 10
"""So many observed events for each simulated one are looked at, at most: more of them add a tenth at best."""
MOST_PARAMETERS = 6
"""Largest number of parameters: with more there are too many candidates for the events that are held back."""
APART = 5.0
"""Standard errors from which a candidate is another answer, with the error that so few events as test it would give."""
TESTED = 3
"""So many candidates are tested a second time, those that the first look leaves."""
OPEN = 0.5
"""Standard error of a combination, in standard deviations of the prior, above which the events leave it open."""
TAKES_PART = 0.25
"""Least component of a parameter in an open combination, of unit length, from which it is named."""


def doubt_of(
    task: Task,
    theta: NDArray[np.float64],
    observed: NDArray,
    simulate: Callable[[NDArray[np.float64]], NDArray],
    num_simulated: int,
    rng: np.random.Generator,
) -> str:
    """The reason to doubt theta (p,), or "": so many events simulated there differ from the observed ones (N, d).

    That nothing could be tested is a reason as well.
    """
    if min(len(observed), num_simulated) < FEWEST:
        return (
            f"{num_simulated} simulated events were held back to be compared with {len(observed)} observed ones: at "
            f"least {FEWEST} of either could tell whether they agree"
        )
    try:
        simulated = simulate(np.tile(theta, (num_simulated, 1)))
    except SimulatorError as error:
        return f"the simulator failed where the estimate was to be tested: {text_of(error)}"
    p_value = two_sample(without_cyclic_axes(task, observed), without_cyclic_axes(task, simulated), rng)
    if p_value >= LEVEL:
        return ""
    return f"fresh events simulated at the estimate differ from the observed ones: p = {p_value:.1g}"


def without_cyclic_axes(task: Task, x: NDArray) -> NDArray:
    """Events (n, d) as they are tested: images are summed over the axes along which nothing depends on theta."""
    if not task.cyclic_axes:
        return x
    axes = tuple(1 + axis for axis in task.cyclic_axes)
    return x.reshape(-1, *task.event_shape).sum(axis=axes).reshape(len(x), -1)


def two_sample(observed: NDArray, simulated: NDArray, rng: np.random.Generator) -> float:
    """The p-value of two sets of events (N, d) and (n, d) being of one distribution.

    It is twice the smaller of the classifier's p-value and of d times the least of a feature.
    """
    from avobench.diagnosis.goodness_of_fit.gates import rounded
    from avobench.diagnosis.settings import TEST

    observed, simulated = rng.permutation(observed)[: MOST_TIMES * len(simulated)], rng.permutation(simulated)
    both = np.concatenate([observed, simulated])
    both = both[:, (both != both[0]).any(axis=0)]
    both = rounded(both, TEST.grain * both.std(axis=0))
    observed, simulated = both[: len(observed)], both[len(observed) :]
    pairs = list(zip(observed.T, simulated.T, strict=True))
    least = min((2 * min(smooth(*pair), scanned(*pair)) for pair in pairs), default=1.0)
    return float(min(1.0, 2 * min(classified(observed, simulated, rng), len(pairs) * least)))


def smooth(observed: NDArray, simulated: NDArray) -> float:
    """The p-value of observed (N,) and simulated values (n,) having the same means of polynomials of their ranks.

    This is the smooth test of J. Neyman, Skandinavisk Aktuarietidskrift 20 (1937) 150, for two samples. The covariance
    is that of all ways to deal these values out to the two. Few events are compared by few polynomials; one alone makes
    it the test of Wilcoxon.
    """
    from scipy.stats import chi2, rankdata

    num, total = len(observed), len(observed) + len(simulated)
    degrees = int(min(MOST_DEGREES, max(1, np.log2(min(num, len(simulated)) / FEWEST))))
    place = (2 * rankdata(np.concatenate([observed, simulated])) - 1) / total - 1
    values = np.polynomial.legendre.legvander(place, degrees)[:, 1:]
    values -= values.mean(axis=0)
    apart = values[:num].mean(axis=0) - values[num:].mean(axis=0)
    covariance = values.T @ values / (total - 1) * (1 / num + 1 / (total - num))
    rank = np.linalg.matrix_rank(covariance, hermitian=True)  # of few different values some polynomials are others' sum
    return float(chi2.sf(apart @ np.linalg.pinv(covariance, hermitian=True) @ apart, max(rank, 1)))


def scanned(observed: NDArray, simulated: NDArray) -> float:
    """The p-value of observed (N,) and simulated values (n,) being as frequent in each of many intervals.

    The intervals hold a half of all values, a quarter, and so on, and overlap by halves. Given how many values there
    are in one, the number of observed ones among them is hypergeometric. Each width has the same share of the false
    alarms, so that what is wide is not lost among many narrow intervals.
    """
    from scipy.stats import hypergeom

    num, total = len(observed), len(observed) + len(simulated)
    levels = int(np.log2(max(2, min(num, len(simulated), MOST_INTERVALS * FEWEST) / FEWEST)))
    both = np.concatenate([observed, simulated])
    inner = np.quantile(both, np.linspace(0, 1, 2**levels + 1)[1:-1])
    place = np.searchsorted(inner, both, side="right")
    below = [np.r_[0, np.bincount(x, minlength=2**levels).cumsum()] for x in (place[:num], place)]
    p_values = []
    for level in range(levels):
        width = 2**level
        first = np.arange(0, 2**levels - width + 1, max(1, width // 2))
        hits, of = (each[first + width] - each[first] for each in below)
        tail = np.minimum(hypergeom.cdf(hits, total, num, of), hypergeom.sf(hits - 1, total, num, of))
        p_values.append(2 * tail.min() * len(first))
    return float(min(1.0, levels * min(p_values)))


def classified(observed: NDArray, simulated: NDArray, rng: np.random.Generator) -> float:
    """The p-value of observed events being no more probable than simulated ones by what a classifier learnt.

    The classifier that one half teaches judges the other; the smaller of both p-values counts twice.
    """
    from scipy.stats import mannwhitneyu, ttest_ind

    from avobench.diagnosis.goodness_of_fit.gates import trained

    if min(len(observed), len(simulated)) < 2 * LEARNT_FROM or not observed.shape[1]:
        return 1.0
    p_values = []
    for half in range(2):
        trees = trained(observed[half::2], simulated[half::2], int(rng.integers(2**31)))
        judged = [trees.predict_proba(x[1 - half :: 2])[:, 1] for x in (observed, simulated)]
        if np.ptp(np.concatenate(judged)) == 0:
            p_values.append(1.0)
        elif min(map(np.ptp, judged)) < ROUNDING:  # without a variance there is no t
            p_values.append(mannwhitneyu(*judged, alternative="greater").pvalue)
        else:
            p_values.append(ttest_ind(*judged, equal_var=False, alternative="greater").pvalue)
    return min(1.0, 2 * min(p_values))


def mirrored(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Theta (p,) with the signs of some changed, and with two in each other's place with either sign: (m, p)."""
    p, images = len(theta), []
    for signs in product((1.0, -1.0), repeat=p):
        images.append(np.array(signs) * theta)
    for i, j in combinations(range(p), 2):
        for sign in (1.0, -1.0):
            other = theta.copy()
            other[[i, j]] = sign * theta[[j, i]]
            images.append(other)
    return np.array(images[1:])


def as_good(
    task: Task,
    theta: NDArray[np.float64],
    error: NDArray[np.float64],
    observed: NDArray,
    simulate: Callable[[NDArray[np.float64]], NDArray],
    num_simulated: int,
    num_fitted: int,
    rng: np.random.Generator,
) -> list[NDArray[np.float64]]:
    """Mirror images of theta (p,) at which events agree with the observed ones (N, d), within the prior.

    At most `num_simulated` events are made. The standard errors (p,) of theta come from `num_fitted` ones. An image so
    near to theta that these few could not tell the two apart is none.
    """
    if len(theta) > MOST_PARAMETERS or not (error > 0).all():
        return []
    resolved = np.sqrt(1 + 1 / (1 / len(observed) + 1 / num_fitted) / max(num_simulated / (2 * TESTED), 1))
    images = mirrored(theta)
    images = images[task.prior.contains(images)]
    images = images[(np.abs(images - theta) / error).max(axis=1) > APART * resolved]

    def p_values(n: int) -> NDArray[np.float64]:
        x = without_cyclic_axes(task, simulate(np.repeat(images, n, axis=0))).reshape(len(images), n, -1)
        return np.array([two_sample(without_cyclic_axes(task, observed), each, rng) for each in x])

    try:
        for most in (len(images), TESTED):  # a first look at all, and fresh events for those that it leaves
            if not len(images) or (n := num_simulated // 2 // len(images)) < FEWEST:
                return []
            p = p_values(n)
            order = np.argsort(-p)[: min(most, TESTED)]
            images = images[order[p[order] >= LEVEL]]
    except SimulatorError:  # it need not work wherever a mirror image lies
        return []
    return list(images)


def left_open(task: Task, theta: NDArray[np.float64], covariance: NDArray[np.float64]) -> list[str]:
    """A sentence for each combination of parameters of which the events tell next to nothing.

    It names two points, a standard error to either side of theta (p,) with its covariance (p, p). Of a prior that is
    not uniform the events must tell a quarter at most of what it does: it may itself be as narrow as their errors.
    """
    most = 1 / (1 + OPEN**2) if isinstance(task.prior, Distributed) else OPEN**2
    if not np.isfinite(covariance).all():
        return []
    unit, names = task.prior.std, task.parameter_names
    variance, axes = np.linalg.eigh(covariance / np.outer(unit, unit))
    sentences = []
    for each, axis in zip(variance, axes.T, strict=True):
        if each <= most:
            continue
        ends = [
            np.clip(theta + side * np.sqrt(each) * axis * unit, task.prior.low, task.prior.high) for side in (-1, 1)
        ]
        one, other = (
            ", ".join(f"{names[j]} = {end[j]:.3g}" for j in np.flatnonzero(np.abs(axis) > TAKES_PART)) for end in ends
        )
        sentences.append(f"the events hardly distinguish {one} from {other}, or from what lies between")
    return sentences
