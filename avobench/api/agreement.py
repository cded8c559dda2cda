"""Whether fresh events simulated at an estimate agree with the observed ones: a two-sample test, at any size.

Two tests look, and what both find counts once. The Kolmogorov-Smirnov test of each feature needs no tuning and is exact
for few events. A classifier that learns from one half of the events and judges the other (D. Lopez-Paz, M. Oquab, ICLR
2017) sees narrow structures, and how features depend on each other.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.errors import SimulatorError, text_of

SHARE = 10
"""One in so many of the simulated events that are allowed is held back for the test."""
LEVEL = 0.01
"""A p-value below it is a doubt. One sound fit in twenty may be doubted, so this leaves room for what theta is off by.
"""
FEWEST = 10
"""Events of each kind below which nothing is said."""
LEARNT_FROM = 100
"""Events of each kind in either half from which a classifier learns."""
MOST_TIMES = 10
"""So many observed events for each simulated one are looked at, at most: more of them add a tenth at best."""


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
    p_value = two_sample(seen(task, observed), seen(task, simulated), rng)
    if p_value >= LEVEL:
        return ""
    return f"fresh events simulated at the estimate differ from the observed ones: p = {p_value:.1g}"


def seen(task: Task, x: NDArray) -> NDArray:
    """What the test sees of events (n, d): an image is summed over the axes along which nothing depends on theta."""
    if not task.cyclic_axes:
        return x
    axes = tuple(1 + axis for axis in task.cyclic_axes)
    return x.reshape(-1, *task.event_shape).sum(axis=axes).reshape(len(x), -1)


def two_sample(observed: NDArray, simulated: NDArray, rng: np.random.Generator) -> float:
    """The p-value of two sets of events (N, d) and (n, d) being of one distribution.

    It is twice the smaller of the classifier's p-value and of the least among the features times their number.
    """
    from scipy.stats import ks_2samp

    from avobench.diagnosis.goodness_of_fit.gates import rounded
    from avobench.diagnosis.settings import TEST

    observed, simulated = rng.permutation(observed)[: MOST_TIMES * len(simulated)], rng.permutation(simulated)
    both = np.concatenate([observed, simulated])
    both = both[:, (both != both[0]).any(axis=0)]
    both = rounded(both, TEST.grain * both.std(axis=0))
    observed, simulated = both[: len(observed)], both[len(observed) :]
    each = [ks_2samp(a, b).pvalue for a, b in zip(observed.T, simulated.T, strict=True)]
    return float(min(1.0, 2 * min([classified(observed, simulated, rng), *(len(each) * p for p in each)])))


def classified(observed: NDArray, simulated: NDArray, rng: np.random.Generator) -> float:
    """The p-value of observed events being no more probable than simulated ones by what a classifier learnt.

    The classifier that one half teaches judges the other. The two halves depend on each other, so the smaller of both
    p-values counts twice.
    """
    from scipy.stats import ttest_ind

    from avobench.diagnosis.goodness_of_fit.gates import trained

    if min(len(observed), len(simulated)) < 2 * LEARNT_FROM or not observed.shape[1]:
        return 1.0
    p_values = []
    for half in range(2):
        trees = trained(observed[half::2], simulated[half::2], int(rng.integers(2**31)))
        judged = [trees.predict_proba(x[1 - half :: 2])[:, 1] for x in (observed, simulated)]
        alike = np.ptp(np.concatenate(judged)) == 0
        p_values.append(1.0 if alike else ttest_ind(*judged, equal_var=False, alternative="greater").pvalue)
    return min(1.0, 2 * min(p_values))
