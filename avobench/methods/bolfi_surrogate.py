"""The engine of `bolfi`: ELFI's default Gaussian process and acquisition, with the same results in a tenth of the time.

ELFI fits its process with GPy, whose cost grows with the cube of the evidence, and searches each acquisition from one
starting point after the other. Here the kernel matrix is kept at its low numerical rank, so that the cost is linear in
the evidence, and all starting points are searched together. With 150 evaluations on carl a run takes 3 s in place of
40 s, and the errors of 15 pairs of runs do not differ (p = 0.64, Wilcoxon; docs/tables/performance.md).

A library for Bayesian optimisation, such as BoTorch, has processes and acquisitions of its own, but it would not give
ELFI's kernel, priors, noise, optimiser, schedule and random stream. These are kept, because a benchmark of BOLFI is to
be one of ELFI's BOLFI. This module needs ELFI as it loads.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dtrtrs
from scipy.spatial.distance import cdist
from scipy.special import gammaln

from avobench.methods.elfi_model import import_elfi

if TYPE_CHECKING:
    from elfi import ElfiModel

elfi = import_elfi()

Array = NDArray[np.float64]
Function = Callable[[Array], tuple[Array, Array, Array]]
"""Values (m,), gradients (m, p) and Hessians (m, p, p) at points (m, p)."""

TOLERANCE = 1e-13
"""Largest part of a point's prior variance that the low-rank kernel may miss at the evidence."""
RELIABLE = 1e-6
"""Least pivot that is taken over, as a part of the prior variance: the rounding of a smaller one would spread."""
DIRECT = 2
"""Number of parameters up to which the second derivatives are solved for one by one. The records of the benchmark were
made so, and a last bit decides between equal minima; with more parameters it takes three to seven times as long."""
JITTER = 1e-8
"""GPy adds this to the noise variance of the evidence (its ExactGaussianInference)."""


class Hyperparameters(NamedTuple):
    """Those of cov(y, y') = variance exp(-|x - x'|^2 / (2 lengthscale^2)) + bias + noise [same evaluation]."""

    variance: float
    lengthscale: float
    bias: float
    noise: float


class Moments(NamedTuple):
    """Mean and variance without noise at m points, each (m,), with gradients (m, p) and Hessians (m, p, p) if asked."""

    mean: Array
    variance: Array
    mean_gradient: Array | None = None
    variance_gradient: Array | None = None
    mean_hessian: Array | None = None
    variance_hessian: Array | None = None


class Posterior:
    """A Gaussian process given evidence x (n, p), y (n,) and its hyper-parameters.

    The exponential part of the kernel matrix is L L^T with L (n, r), a Cholesky factorisation that stops at the rank r
    where no diagonal element misses more than `TOLERANCE` of itself: Harbrecht, Peters and Schneider, Applied Numerical
    Mathematics 62 (2012) 428. A is L with the bias as one more column, and everything follows from the small matrix
    B = A^T A + s I, s the noise (Rasmussen and Williams 2006, Appendix A.3), since (A A^T + s I)^-1 A = A B^-1.

    `pivots`, those of a posterior with similar evidence or hyper-parameters, save their search, nothing else.
    Raises numpy.linalg.LinAlgError when B is not positive definite in floating point.
    """

    def __init__(self, x: Array, y: Array, hyperparameters: Hyperparameters, pivots: Sequence[int] = ()) -> None:
        self.x, self.y, self.hyperparameters = x, y, hyperparameters
        self.noise = hyperparameters.noise + JITTER
        self.pivots, factor = self._partial_cholesky(list(pivots))
        self._pivot_factor = np.asfortranarray(factor[self.pivots])
        self._factor = self._with_bias(factor.T).T
        self._small, info = dpotrf(self._factor.T @ self._factor + self.noise * np.eye(len(self.pivots) + 1), lower=1)
        if info:
            raise np.linalg.LinAlgError(f"no Cholesky factorisation with {hyperparameters}")
        whitened = _solve(self._small, self._factor.T @ y)
        self._weights = _solve(self._small, whitened, transposed=True)  # B^-1 A^T y
        self._alpha = (y - self._factor @ self._weights) / self.noise  # (K + s I)^-1 y, and A^T alpha = B^-1 A^T y
        # For the mean and its derivatives: sums over the evidence of alpha, times coordinates and their products.
        self._centre = x.mean(axis=0)
        centred = x - self._centre
        products = (centred[:, :, None] * centred[:, None]).reshape(len(x), -1)
        terms = np.column_stack([np.ones(len(x)), centred, products])
        self._mean_terms = hyperparameters.variance * self._alpha[:, None] * terms
        self._mean_offset = hyperparameters.bias * self._alpha.sum()

    def moments(self, x: Array, derivatives: int = 0) -> Moments:
        """The process at points x (m, p), with gradients (`derivatives` 1) and Hessians (2)."""
        (m, p), direct = x.shape, x.shape[1] <= DIRECT
        scale = self.hyperparameters.lengthscale
        # The mean from all evidence, in O(n) a point: between evidence and bounds, where L misses more of the kernel,
        # the weights of the mean are too large for what it misses.
        sums = self._correlation(x, self.x) @ self._mean_terms
        mean = sums[:, 0] + self._mean_offset

        kernel = self._correlation(self.x[self.pivots], x)
        blocks = [kernel]
        if derivatives:
            shift = (self.x[self.pivots, None] - x) / scale**2  # (r, m, p)
            blocks += [shift[..., i] * kernel for i in range(p)]
        if derivatives > 1 and direct:
            blocks += [
                (shift[..., i] * shift[..., j] - (i == j) / scale**2) * kernel for i in range(p) for j in range(p)
            ]
        rows = _solve(self._pivot_factor, np.hstack(blocks))
        features = self._with_bias(rows)
        features[-1, m:] = 0  # the bias does not depend on x
        whitened = _solve(self._small, features)
        # The prior variance that L misses away from the evidence, and s a^T B^-1 a. The last pivots are inexact, by a
        # rounding of their square; that cancels in the sum, so the first term may be negative and is not cut off.
        missed, kept = self.hyperparameters.variance, self.noise
        row, white = rows[:, :m], whitened[:, :m]
        variance = missed * (1 - (row**2).sum(0)) + kept * (white**2).sum(0)
        if not derivatives:
            return Moments(mean, variance)

        first, white_first = (of[:, m : m * (p + 1)].reshape(-1, p, m) for of in (rows, whitened))
        gradient = 2 * np.einsum("rm,rim->mi", white, white_first) * kept
        gradient -= 2 * np.einsum("rm,rim->mi", row, first) * missed
        value, moved = sums[:, :1], sums[:, 1 : p + 1]  # sums of weights, and of weights times coordinates
        centred = x - self._centre
        moments = mean, variance, (moved - centred * value) / scale**2, gradient
        if derivatives == 1:
            return Moments(*moments)

        hessian = np.einsum("rim,rjm->mij", white_first, white_first)
        hessian_missed = np.einsum("rim,rjm->mij", first, first)
        if direct:
            second, white_second = (of[:, m * (p + 1) :].reshape(-1, p, p, m) for of in (rows, whitened))
            hessian += np.einsum("rm,rijm->mij", white, white_second)
            hessian_missed += np.einsum("rm,rijm->mij", row, second)
        variance_hessian = 2 * (kept * hessian - missed * hessian_missed)
        if not direct:
            # The second derivatives of the kernel, row by row, enter in one combination: solve for its coefficients.
            back = kept * np.sqrt(missed) * _solve(self._small, white, transposed=True)[:-1] - missed * row
            pull = 2 * kernel * _solve(self._pivot_factor, back, transposed=True)  # (r, m)
            variance_hessian += np.einsum("rm,rmi,rmj->mij", pull, shift, shift, optimize=True)
            variance_hessian -= pull.sum(0)[:, None, None] * np.eye(p) / scale**2
        cross = centred[:, :, None] * moved[:, None]
        squares = sums[:, p + 1 :].reshape(m, p, p) - cross - cross.transpose(0, 2, 1)
        squares += value[:, :, None] * (centred[:, :, None] * centred[:, None] - scale**2 * np.eye(p))
        return Moments(*moments, squares / scale**4, variance_hessian)

    def log_likelihood(self) -> tuple[float, Array]:
        """Logarithm of the marginal likelihood of the evidence, and its gradient (4,) in the hyper-parameters."""
        n, r, s, of = len(self.y), len(self.pivots), self.noise, self.hyperparameters
        a, weights, alpha = self._factor, self._weights, self._alpha
        log_determinant = (n - r - 1) * np.log(s) + 2 * np.log(self._small.diagonal()).sum()
        value = -(s * alpha @ alpha + weights @ weights + log_determinant + n * np.log(2 * np.pi)) / 2

        inverse, _ = dpotri(self._small, lower=1)
        inverse = np.tril(inverse) + np.tril(inverse, -1).T  # B^-1
        diagonal = inverse.diagonal()
        variance = (weights[:r] @ weights[:r] - (r - s * diagonal[:r].sum())) / (2 * of.variance)
        bias = (weights[r] ** 2 - (1 - s * diagonal[r])) / (2 * of.bias)
        noise = (alpha @ alpha - (n - r - 1) / s - diagonal.sum()) / 2

        # dK / d lengthscale is K times squared distances / lengthscale^3, element by element, and with coordinates as
        # diagonal matrices D_i: K * |x - x'|^2 = sum_i D_i^2 K + K D_i^2 - 2 D_i K D_i, which needs only A.
        # For M = D_i L, M^T (K + s I)^-1 M = |M - A W|^2 / s + |W|^2 with W = B^-1 A^T M, a sum of positive terms.
        x = self.x - self._centre
        columns = a[:, :r]  # L
        squares = (x**2).sum(1)
        trace = (inverse[:r] * (a.T @ (squares[:, None] * columns)).T).sum()
        quadratic = (alpha * squares) @ columns @ weights[:r]
        for coordinate in x.T:
            moved = coordinate[:, None] * columns
            within, _ = dpotrs(self._small, a.T @ moved, lower=1)
            trace -= ((moved - a @ within) ** 2).sum() / s + (within**2).sum()
            quadratic -= ((alpha @ moved) ** 2).sum()
        return value, np.array([variance, (quadratic - trace) / of.lengthscale**3, bias, noise])

    def _correlation(self, x: Array, other: Array) -> Array:
        return np.exp(cdist(x, other, "sqeuclidean") * (-0.5 / self.hyperparameters.lengthscale**2))

    def _with_bias(self, rows: Array) -> Array:
        """Rows of A^T, (r + 1, m), from those of L^T in units of the prior's standard deviation, (r, m)."""
        of = self.hyperparameters
        return np.vstack([np.sqrt(of.variance) * rows, np.full(rows.shape[1], np.sqrt(of.bias))])

    def _partial_cholesky(self, pivots: list[int]) -> tuple[list[int], Array]:
        """Pivots and L (n, r) of unit variance, from the given pivots, as far as they are independent, and more."""
        kernel = self._correlation(self.x[pivots], self.x)
        block, info = dpotrf(kernel[:, pivots], lower=1)
        if info:
            block = block[: info - 1, : info - 1]
        small = np.flatnonzero(block.diagonal() ** 2 < RELIABLE)
        r = small[0] if small.size else len(block)
        pivots = pivots[:r]
        rows = np.empty((len(self.x), len(self.x)))  # of which the operating system provides what is written
        rows[:r] = _solve(block[:r, :r], kernel[:r])
        missed = 1 - (rows[:r] ** 2).sum(0)
        missed[pivots] = 0
        while (largest := missed.max()) > TOLERANCE:
            i = int(missed.argmax())
            rows[r] = (self._correlation(self.x[[i]], self.x)[0] - rows[:r, i] @ rows[:r]) / np.sqrt(largest)
            rows[r, pivots] = 0
            missed -= rows[r] ** 2
            pivots.append(i)
            missed[pivots] = 0
            r += 1
        return pivots, rows[:r].T


def _solve(lower: Array, right: Array, transposed: bool = False) -> Array:
    """X of lower X = right, or of lower^T X = right. The checks of SciPy's solve_triangular cost more than the work."""
    if not len(lower):
        return right
    solution, info = dtrtrs(lower, right, lower=1, trans=int(transposed))
    if info:
        raise np.linalg.LinAlgError("singular triangular matrix")
    return solution


class GaussianProcess:
    """Takes the place of ELFI's GPyRegression as `target_model`, of the same kernel, priors, noise and optimiser.

    `parameter_names` in ELFI's order and `bounds`, (low, high) for each of them. Hyper-parameters start at 1, the noise
    at a hundredth of the squared largest distance; variance, length scale and bias have gamma priors of equal mean and
    variance: (largest distance / 3)^2, a third of the span of all bounds, and a quarter of the first.
    """

    def __init__(self, parameter_names: Sequence[str], bounds: Sequence[tuple[float, float]]) -> None:
        self.parameter_names, self.bounds = list(parameter_names), list(bounds)
        self.input_dim = len(self.bounds)
        self.max_opt_iters = 50
        self.posterior: Posterior | None = None
        self._prior_mean: Array | None = None

    @property
    def n_evidence(self) -> int:
        return 0 if self.posterior is None else len(self.posterior.y)

    @property
    def X(self) -> Array:
        """Thetas of the evidence, (n, p)."""
        return self.posterior.x

    @property
    def Y(self) -> Array:
        """Distances of the evidence, (n, 1)."""
        return self.posterior.y[:, None]

    @property
    def noise(self) -> float:
        return self.posterior.hyperparameters.noise

    def predict(self, x: Array, noiseless: bool = False) -> tuple[Array, Array]:
        """Mean and variance, each (m, 1), at x, of shape (m, p) or a flattened one."""
        moments = self.posterior.moments(np.reshape(x, (-1, self.input_dim)))
        noise = 0 if noiseless else self.noise
        return moments.mean[:, None], moments.variance[:, None] + noise

    def predict_mean(self, x: Array) -> Array:
        return self.predict(x)[0]

    def predictive_gradients(self, x: Array) -> tuple[Array, Array]:
        """Gradients of mean and variance, each (m, p), at x (m, p)."""
        moments = self.posterior.moments(np.reshape(x, (-1, self.input_dim)), derivatives=1)
        return moments.mean_gradient, moments.variance_gradient

    def predictive_gradient_mean(self, x: Array) -> Array:
        return self.predictive_gradients(x)[0]

    def update(self, x: Array, y: Array, optimize: bool = False) -> None:
        """Add evidence x (m, p), y (m,), and fit the hyper-parameters if asked.

        Raises ValueError when the first distances are not positive anywhere, or any is not finite.
        """
        x, y = np.reshape(x, (-1, self.input_dim)), np.ravel(y)
        if not np.isfinite(y).all():
            raise ValueError("the Gaussian process needs finite distances")
        if self.posterior is None:
            largest = y.max()
            if largest <= 0:
                raise ValueError("the Gaussian process needs a positive distance to set its scale")
            variance = (largest / 3) ** 2
            self._prior_mean = np.array([variance, (np.max(self.bounds) - np.min(self.bounds)) / 3, variance / 4])
            self.posterior = Posterior(x, y, Hyperparameters(1, 1, 1, largest**2 / 100))
        else:
            old = self.posterior
            self.posterior = Posterior(np.vstack([old.x, x]), np.append(old.y, y), old.hyperparameters, old.pivots)
        if optimize:
            self.optimize()

    def log_posterior(self, at: Posterior) -> tuple[float, Array]:
        """Log likelihood and prior of the hyper-parameters, up to a constant, and the gradient (4,) in log(exp(.) - 1),
        the coordinates in which GPy optimises; the prior includes their Jacobian."""
        value, gradient = at.log_likelihood()
        theta = np.array(at.hyperparameters)
        shape, prior = self._prior_mean, theta[:3]
        jacobian = -np.expm1(-theta)
        value += ((shape - 1) * np.log(prior) - prior - gammaln(shape) + np.log(jacobian[:3])).sum()
        gradient[:3] += (shape - 1) / prior - 1 + 1 / np.expm1(prior)
        return value, gradient * jacobian

    def optimize(self) -> None:
        """Fit the hyper-parameters as GPy does: scaled conjugate gradients from where they are, at most 50 steps."""
        from paramz.optimization.scg import SCG  # of GPy

        @lru_cache(maxsize=1)  # SCG asks for the gradient where it has just asked for the value
        def objective(key: bytes) -> tuple[float, Array]:
            hyperparameters = Hyperparameters(*_positive(np.frombuffer(key)).tolist())
            if hyperparameters.lengthscale < 1e-100 or max(hyperparameters) > 1e100:
                return np.inf, np.zeros(4)  # a step too far, whose powers overflow: SCG tries a shorter one
            try:
                self.posterior = self._refitted(hyperparameters)  # from the pivots of the last step
            except np.linalg.LinAlgError:
                return np.inf, np.zeros(4)  # a step too far, which GPy refuses in the same way
            value, gradient = self.log_posterior(self.posterior)
            return -value, -gradient

        theta = np.array(self.posterior.hyperparameters)
        best, *_ = SCG(
            lambda z: objective(z.tobytes())[0],
            lambda z: objective(z.tobytes())[1],
            theta + np.log(-np.expm1(-theta)),
            maxiters=self.max_opt_iters,
        )
        self.posterior = self._refitted(Hyperparameters(*_positive(best).tolist()))

    def _refitted(self, hyperparameters: Hyperparameters) -> Posterior:
        return Posterior(self.posterior.x, self.posterior.y, hyperparameters, self.posterior.pivots)


def _positive(z: Array) -> Array:
    """log(1 + exp(z)), with z cut off where GPy does it, just above underflow to zero."""
    return np.logaddexp(0, np.maximum(z, -np.log(np.finfo(float).max)))


def fast(model: "ElfiModel", bounds: dict[str, tuple[float, float]], **acquisition: Any) -> dict[str, Any]:
    """The arguments of `elfi.BOLFI` that put this process and acquisition in place of ELFI's own.

    `acquisition` are the arguments of ELFI's acquisition: noise_var, exploration_rate and seed.
    """
    process = GaussianProcess(list(bounds), list(bounds.values()))
    prior = elfi.model.extensions.ModelPrior(model, parameter_names=process.parameter_names)
    return {"target_model": process, "acquisition_method": BatchedLCBSC(process, prior=prior, **acquisition)}


class BatchedLCBSC(elfi.methods.bo.acquisition.LCBSC):
    """LCBSC, whose model is a `GaussianProcess`: the same starting points, from the same random stream, and bounds.

    ELFI runs L-BFGS-B from one starting point after the other; here all of them take Newton steps at once.
    """

    def acquire(self, n: int, t: int | None = None) -> Array:
        """The minimum of the bound for the t-th acquisition, n times, (n, p), plus noise if ELFI was given any."""
        low, high = np.transpose(self.model.bounds)
        starts = self.prior.rvs(self.n_inits, random_state=self.random_state).reshape(-1, self.model.input_dim)
        factor = np.sqrt(self._beta(t))
        minima, values = minimise(
            lambda x: self._bound(x, factor), np.clip(starts, low, high), low, high, self.max_opt_iters
        )
        return self._add_noise(np.tile(minima[values.argmin()], (n, 1)))

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
