"""Other answers that fit as well: mirror images of an estimate, and combinations that the events leave open.

A simulator that depends on the square of a parameter, or in which two parameters may change places, has several equally
good answers, and a method ends at one of them. Each candidate is a set of parameters with other signs, or with two of
them in each other's place. It is believed if events simulated there agree with the observed ones.
"""

from collections.abc import Callable
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from avobench.api.agreement import FEWEST, LEVEL, seen, two_sample
from avobench.tasks import Task
from avobench.tasks.errors import SimulatorError

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


def mirrored(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Theta (p,) with the signs of some changed, and with two in each other's place with either sign: (m, p)."""
    p, found = len(theta), []
    for signs in product((1.0, -1.0), repeat=p):
        found.append(np.array(signs) * theta)
    for i, j in combinations(range(p), 2):
        for sign in (1.0, -1.0):
            other = theta.copy()
            other[[i, j]] = sign * theta[[j, i]]
            found.append(other)
    return np.array(found[1:])


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
        x = seen(task, simulate(np.repeat(images, n, axis=0))).reshape(len(images), n, -1)
        return np.array([two_sample(seen(task, observed), each, rng) for each in x])

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

    It names two points, a standard error to either side of theta (p,) with its covariance (p, p).
    """
    if not np.isfinite(covariance).all():
        return []
    unit, names = task.prior.width / np.sqrt(12), task.parameter_names
    variance, axes = np.linalg.eigh(covariance / np.outer(unit, unit))
    said = []
    for each, axis in zip(variance, axes.T, strict=True):
        if each <= OPEN**2:
            continue
        ends = [
            np.clip(theta + side * np.sqrt(each) * axis * unit, task.prior.low, task.prior.high) for side in (-1, 1)
        ]
        one, other = (
            ", ".join(f"{names[j]} = {end[j]:.3g}" for j in np.flatnonzero(np.abs(axis) > TAKES_PART)) for end in ends
        )
        said.append(f"the events hardly tell {one} from {other}, or what lies between")
    return said
