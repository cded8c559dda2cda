"""How far theta may be off since a bank has events at a few thetas alone: between them it is a mixture of its nodes."""

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.quadratic import quadratic
from avobench.tasks.sample import SampleTask

NEAR = 2
"""So many nodes near theta, for each coefficient of the quadratic that says how the means bend."""
SURE = 2.0
"""Standard errors beyond which a shift is not the noise of the events at the nodes."""


def shift(task: SampleTask, theta: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """How far linear interpolation moves each parameter in the middle of the nodes around theta (p,): (p,).

    Shares of events in bins are described by a quadratic in theta over the nodes near by. What the mean of the nodes
    around theta has beside it is told apart from noise, and taken for a shift of theta. None where the nodes are too
    few for a quadratic.
    """
    p, nodes, around = len(theta), task.scaled(task.nodes), task.corners(theta)
    i, j = np.triu_indices(p)
    order = np.argsort(((nodes - task.scaled(theta)) ** 2).sum(axis=1))
    middle = nodes[around].mean(axis=0)
    z = nodes[order] - middle
    terms = quadratic(z)
    for num in range(min(NEAR * terms.shape[1], len(z)), len(z) + 1):
        if np.linalg.matrix_rank(terms[:num]) == terms.shape[1]:
            break
    else:
        return None
    near, solved = order[:num], np.linalg.pinv(terms[:num])
    shares = np.array([task.in_bins(task.groups[k]).mean(axis=0) for k in near])
    spread = z[np.isin(order, around)]
    bend = (spread.T @ spread / len(spread))[i, j] @ solved[1 + p :]
    slopes, missed = solved[1 : 1 + p] @ shares, bend @ shares
    covariance = np.cov(np.concatenate([task.in_bins(task.groups[k]) for k in around]), rowvar=False)
    weighted = slopes @ np.linalg.pinv(covariance, hermitian=True)
    inverse = np.linalg.pinv(weighted @ slopes.T, hermitian=True)  # the covariance of theta by one event
    moved = inverse @ weighted @ missed
    noise = np.diag(inverse) * (bend**2 / task.sizes[near]).sum()
    told = moved**2 > SURE**2 * noise
    return np.sign(moved) * np.sqrt(np.where(told, moved**2 - noise, 0)) * task.prior.width
