"""Whitened inputs: what the discriminators and the statistic of `avo`, and the moments of `smm`, see of an event."""

import numpy as np
from numpy.typing import NDArray

from avobench.methods.problem import Problem

LEAST_VARIANCE = 1e-3
"""Added to every variance, as a share of their mean, so that a feature that hardly varies is not blown up."""


class Inputs:
    """Events as float32 rows of zero mean and, nearly, unit covariance among the observed ones.

    With `symmetric` an image is first summed over its cyclic axes: nothing there depends on theta. With `whiten` the
    rows are decorrelated by the symmetric square root of the inverse covariance (ZCA), else each is only scaled.
    """

    def __init__(self, problem: Problem, *, symmetric: bool, whiten: bool) -> None:
        self._shape, self._summed = (-1, *problem.event_shape), tuple(1 + axis for axis in problem.cyclic_axes)
        self._symmetric = symmetric and bool(self._summed)
        x = self._sum(problem.x_observed)
        covariance = np.atleast_2d(np.cov(x, rowvar=False))
        if not whiten:
            covariance = np.diag(np.diag(covariance))
        variance, axes = np.linalg.eigh(covariance)
        spread = np.sqrt(variance.clip(0) + LEAST_VARIANCE * variance.mean())
        whitening = (axes / np.where(spread > 0, spread, 1)) @ axes.T
        self._shift, self._whitening = (a.astype(np.float32) for a in (x.mean(axis=0, dtype=float), whitening))

    def __call__(self, x: NDArray) -> NDArray[np.float32]:
        """x (n, d) -> (n, k), with k = d unless an image is summed."""
        return (self._sum(x) - self._shift) @ self._whitening

    def _sum(self, x: NDArray) -> NDArray[np.float32]:
        if self._symmetric:
            x = x.reshape(self._shape).sum(axis=self._summed, dtype=np.float32)
        return x.reshape(len(x), -1).astype(np.float32)
