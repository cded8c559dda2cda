"""How far theta may be off since a bank has events at a few thetas alone: between them it is a mixture of its nodes."""

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Task
from avobench.tasks.quadratic import quadratic
from avobench.tasks.sample import SampleTask

NEAR = 2
"""So many nodes near theta, for each coefficient of the quadratic that says how the means bend."""
SURE = 2.0
"""Standard errors beyond which a shift is not the noise of the events at the nodes."""
BENT = 2.0
"""Chi-squared per degree of freedom of the quadratic at the nodes, above which it is told from fewer of them. It is 1
where a quadratic describes them. On exponential lifetimes it was 5 to 27 at 6 rates, and 1 to 2 at 12."""


def apart(task: Task, theta: NDArray[np.float64], std: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
    """How far a bank of few thetas may shift theta (p,), and a doubt where that is more than `std` (p,) or unknown."""
    if not isinstance(task, SampleTask):
        return np.zeros(len(theta)), ""
    moved = shift(task, theta)
    if moved is None:
        few = f"the {len(task.nodes)} thetas of the bank are too few to tell what lies between them: simulate at more"
        return np.zeros(len(theta)), few
    if not (far := np.abs(moved) > std).any():
        return moved, ""
    shifts = ", ".join(f"{task.parameter_names[k]} by {abs(moved[k]):.2g}" for k in np.flatnonzero(far))
    doubt = f"the thetas of the bank are so far apart that this may shift {shifts}: simulate at thetas nearer to it"
    return moved, doubt


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
    covariance = np.cov(np.concatenate([task.in_bins(task.groups[k]) for k in around]), rowvar=False)
    precision = np.linalg.pinv(covariance, hermitian=True)
    least = terms.shape[1]
    fewest = next((num for num in range(least, len(z) + 1) if np.linalg.matrix_rank(terms[:num]) == least), None)
    if fewest is None:
        return None
    for num in range(max(min(NEAR * least, len(z)), fewest), fewest - 1, -1):
        near, solved = order[:num], np.linalg.pinv(terms[:num])
        shares = np.array([task.in_bins(task.groups[k]).mean(axis=0) for k in near])
        missed = shares - terms[:num] @ (solved @ shares)
        chi_squared = task.sizes[near] @ np.einsum("ki,ij,kj->k", missed, precision, missed)
        if chi_squared <= BENT * (num - least) * np.linalg.matrix_rank(covariance, hermitian=True):
            break
    spread = z[np.isin(order, around)]
    bend = (spread.T @ spread / len(spread))[i, j] @ solved[1 + p :]
    slopes, missed = solved[1 : 1 + p] @ shares, bend @ shares
    weighted = slopes @ precision
    inverse = np.linalg.pinv(weighted @ slopes.T, hermitian=True)  # the covariance of theta by one event
    moved = inverse @ weighted @ missed
    noise = np.diag(inverse) * (bend**2 / task.sizes[near]).sum()
    significant = moved**2 > SURE**2 * noise
    return np.sign(moved) * np.sqrt(np.where(significant, moved**2 - noise, 0)) * task.prior.width
