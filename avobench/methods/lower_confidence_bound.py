"""ELFI's default acquisition, LCBSC, minimised from all its starting points together. Imported only where ELFI is."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avobench.methods.elfi_model import import_elfi

Array = NDArray[np.float64]
Function = Callable[[Array], tuple[Array, Array, Array]]
"""Values (m,), gradients (m, p) and Hessians (m, p, p) at points (m, p)."""


class BatchedLCBSC(import_elfi().methods.bo.acquisition.LCBSC):
    """LCBSC, whose model is a `GaussianProcess`: the same starting points, from the same random stream, and bounds.

    ELFI runs L-BFGS-B from one starting point after the other; here all of them take Newton steps at once.
    """

    def acquire(self, n: int, t: int | None = None) -> Array:
        """The minimum of the bound for the t-th acquisition, n times, (n, p), plus noise if ELFI was given any."""
        low, high = np.transpose(self.model.bounds)
        starts = self.prior.rvs(self.n_inits, random_state=self.random_state).reshape(-1, self.model.input_dim)
        factor = np.sqrt(self._beta(t))
        found, values = minimise(
            lambda x: self._bound(x, factor), np.clip(starts, low, high), low, high, self.max_opt_iters
        )
        return self._add_noise(np.tile(found[values.argmin()], (n, 1)))

    def _bound(self, x: Array, factor: float) -> tuple[Array, Array, Array]:
        """mean - factor standard deviations, as Brochu, Cora and de Freitas 2010, with derivatives."""
        at = self.model.posterior.moments(x, derivatives=2)
        std = np.sqrt(np.maximum(at.variance, 1e-15))  # where GPy, too, cuts off what rounding takes below zero
        std_gradient = at.variance_gradient / (2 * std[:, None])
        outer = std_gradient[:, :, None] * std_gradient[:, None]
        std_hessian = (at.variance_hessian / 2 - outer) / std[:, None, None]
        return (
            at.mean - factor * std,
            at.mean_gradient - factor * std_gradient,
            at.mean_hessian - factor * std_hessian,
        )


def minimise(function: Function, x: Array, low: Array, high: Array, max_steps: int) -> tuple[Array, Array]:
    """Local minima (m, p) in a box and their values (m,), one from each starting point (m, p), all at the same time.

    Projected Newton steps (Bertsekas, SIAM Journal on Control and Optimization 20 (1982) 221) with the absolute values
    of the curvatures. A step that does not lead down is not taken, and the next one from there is four times shorter.
    It ends when every step is below 1e-8 of the box, or promises less than 1e-10 of the value.
    """
    width = high - low
    edge = 1e-10 * width
    radius = np.ones(len(x))  # longest step, in units of the box: L-BFGS, too, leaps far at first
    value, gradient, hessian = function(x)
    for _ in range(max_steps):
        # In units of the box. Coordinates on a bound that the gradient pushes against are kept there.
        fixed = ((x <= low + edge) & (gradient > 0)) | ((x >= high - edge) & (gradient < 0))
        slope = np.where(fixed, 0, gradient * width)
        both = fixed[:, :, None] | fixed[:, None]
        curvature = np.where(both, np.eye(x.shape[1]), hessian * width[:, None] * width)
        eigenvalues, axes = np.linalg.eigh(curvature)
        along = np.einsum("mij,mi->mj", axes, slope) / np.maximum(np.abs(eigenvalues), 1e-12)
        step = -np.einsum("mij,mj->mi", axes, along)
        length = np.sqrt((step**2).sum(1))
        step *= np.minimum(1, radius / np.maximum(length, 1e-300))[:, None]  # no step where the slope is zero
        length = np.minimum(length, radius)
        promised = -(slope * step).sum(1)
        if ((length < 1e-8) | (promised < 1e-10 * np.abs(value))).all():
            break
        trial = np.clip(x + step * width, low, high)
        trial_value, trial_gradient, trial_hessian = function(trial)
        better = trial_value < value
        x = np.where(better[:, None], trial, x)
        value = np.where(better, trial_value, value)
        gradient = np.where(better[:, None], trial_gradient, gradient)
        hessian = np.where(better[:, None, None], trial_hessian, hessian)
        radius = np.where(better, np.maximum(radius, 2 * length), length / 4)
    return x, value
