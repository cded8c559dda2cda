"""Whitened inputs: what the discriminators and the statistic of `avo`, and the moments of `smm`, see of an event."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from avobench.methods.problem import Problem

OFFSET = 100.0
"""A feature whose mean is farther from zero than this, in its standard deviations, is counted from its mean: float32
has 24 bits, and 17 of them are then left for what varies."""
APART = 1e5
"""Ratio of the standard deviations of two features, not of an image, from which each is counted in its own: the least
would else be taken for a constant."""
LEAST_VARIANCE = 1e-3
"""Added to every variance, as a share of their mean, so that a feature that hardly varies is not blown up."""

MOST_DOUBTS = 3
"""Features of which it is said one by one that the simulator never makes what was observed."""


class Inputs:
    """Events as float32 rows of zero mean and, nearly, unit covariance among the observed ones.

    With `symmetric` an image is first summed over its cyclic axes: nothing there depends on theta. With `whiten` the
    rows are decorrelated by the symmetric square root of the inverse covariance (ZCA), else each is only scaled. With
    `quantiles` each feature is put on the scale on which the observed events are Gaussian before (`GaussianScale`), so
    that no event counts for more because it is far off. With `trim` a feature of an event that is no image lies at most
    at the quantiles of the observed events that leave this share of them beyond either end (Winsorised).

    A feature that is the same in all simulated events, and never that in an observed one, says nothing of theta, and
    would move the answer by what networks make of numbers that they have not learnt from. It is left out: from the
    first simulated events on, and for as long as no simulated one differs.
    """

    def __init__(
        self, problem: Problem, *, symmetric: bool, whiten: bool, quantiles: bool = False, trim: float = 0.0
    ) -> None:
        self._shape, self._summed = (-1, *problem.event_shape), tuple(1 + axis for axis in problem.cyclic_axes)
        self._symmetric = symmetric and bool(self._summed)
        self._origin, self._scales, self._units, self._ends = origin(problem.x_observed), None, None, None
        std = np.ones(1) if problem.event_shape else problem.x_observed.std(axis=0, dtype=float)
        if std.max() > APART * min(std[std > 0], default=1.0):
            self._units = np.where(std > 0, std, 1)
        if quantiles:
            self._scales = [GaussianScale(column) for column in self._sum(problem.x_observed).T]
        if trim and not problem.event_shape:
            low, high = np.quantile(self._sum(problem.x_observed), (trim, 1 - trim), axis=0)
            self._ends = np.where(low < high, (low, high), [[-np.inf], [np.inf]])
        x = self._rows(problem.x_observed)
        covariance = np.atleast_2d(np.cov(x, rowvar=False, bias=len(x) == 1))
        if not whiten:
            covariance = np.diag(np.diag(covariance))
        variance, axes = np.linalg.eigh(covariance)
        spread = np.sqrt(variance.clip(0) + LEAST_VARIANCE * variance.mean())
        whitening = (axes / np.where(spread > 0, spread, 1)) @ axes.T
        self._problem, self._first = problem, np.empty((0, problem.x_observed.shape[1]))
        self._missed = np.zeros(problem.x_observed.shape[1], bool)
        self._shift, self._whitening = (a.astype(np.float32) for a in (x.mean(axis=0, dtype=float), whitening))

    def __call__(self, x: NDArray) -> NDArray[np.float32]:
        """x (n, d) -> (n, k), with k = d unless an image is summed."""
        if self._missed.any():
            x = np.where(self._missed, self._problem.x_observed.mean(axis=0), x)
        return (self._rows(x) - self._shift) @ self._whitening

    def simulated(self, x: NDArray) -> NDArray[np.float32]:
        """The same of simulated events, from which it is learnt what to leave out."""
        if not len(self._first):
            self._first = x[:1].copy()
            self._missed = ~(self._problem.x_observed == x[0]).any(axis=0)
        if self._missed.any():
            self._missed &= (x == self._first).all(axis=0)
        return self(x)

    @property
    def doubt(self) -> str:
        """The reason why any answer is doubtful, or ""."""
        names = self._problem.feature_names or [f"x{j + 1}" for j in range(len(self._missed))]
        doubts = [
            f"the simulator makes {names[j]} = {self._first[0, j]:g} alone, which was never observed: it is left out"
            for j in np.flatnonzero(self._missed)[:MOST_DOUBTS]
        ]
        if (more := self._missed.sum() - MOST_DOUBTS) > 0:
            doubts.append(f"so are {more} other features")
        if (self._problem.x_observed == self._problem.x_observed[0]).all():
            doubts.append("all observed events are alike, so how far they scatter is not known, and the error is rough")
        return "; ".join(doubts)

    def _rows(self, x: NDArray) -> NDArray[np.float32]:
        x = self._sum(x)
        if self._scales is not None:
            x = np.column_stack([scale(column) for scale, column in zip(self._scales, x.T, strict=True)])
        if self._ends is not None:
            x = np.clip(x, *self._ends)
        return x.astype(np.float32, copy=False)

    def _sum(self, x: NDArray) -> NDArray:
        x = x - self._origin if self._origin.any() else x
        x = x / self._units if self._units is not None else x
        if self._symmetric:
            x = x.reshape(self._shape).sum(axis=self._summed, dtype=np.float32)
        return x.reshape(len(x), -1)


class GaussianScale:
    """An increasing function of a feature, after which its observed values (N,) are Gaussian.

    It is linear between two of them. Beyond them it goes on with the logarithm of the distance in their standard
    deviations: nothing that tells events apart is lost.
    """

    def __init__(self, observed: NDArray) -> None:
        self.values, counts = np.unique(observed, return_counts=True)
        self.quantiles = ndtri((np.cumsum(counts) - counts / 2) / len(observed))
        self.unit = observed.std(dtype=float) or 1.0

    def __call__(self, x: NDArray) -> NDArray[np.float32]:
        """x (n,) -> (n,)."""
        x = x.astype(float)
        beyond = x - np.clip(x, self.values[0], self.values[-1])
        far = np.sign(beyond) * np.log1p(np.abs(beyond) / self.unit)
        return (np.interp(x, self.values, self.quantiles) + far).astype(np.float32)


def origin(x: NDArray) -> NDArray[np.float64]:
    """The zero from which the features of events x (n, d) are counted before they become float32: (d,)."""
    mean, std = x.mean(axis=0, dtype=float), x.std(axis=0, dtype=float)
    return np.where(np.abs(mean) > OFFSET * std, mean, 0.0)
