"""Theta from published tables and a bank of simulated events at a few thetas, without another simulator call."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from avobench.tables.comparison import Comparison, Reduced, whitening
from avobench.tables.table import Table, Tables
from avobench.tasks.arguments import checked, numbers
from avobench.tasks.errors import UsageError
from avobench.tasks.quadratic import quadratic

ROUNDS = 20
"""Times that the covariance is taken anew at the minimum, at most: it changes little with theta, two or three do."""
STANDSTILL = 1e-6
"""Share of the box by which the minimum may still move: less than any printed digit shows."""


@dataclass(frozen=True, eq=False)
class TablePolynomial:
    """Each value of the tables as a quadratic polynomial in theta, fitted to a bank.

    Thetas count by their number of events. That of a bin's own variance would pull it low, since few entries seem sure.
    """

    tables: Tables
    box: NDArray[np.float64]
    """(2, p): where theta is looked for."""
    theta: NDArray[np.float64]
    """(k, p), of the bank."""
    values: NDArray[np.float64]
    """What each theta gives for the values: (k, K)."""
    covariances: NDArray[np.float64]
    """The covariance of each theta's values by simulation: (k, K, K)."""
    errors: NDArray[np.float64]
    """The covariance of the published values, if each theta is right: (k, K, K)."""
    num_events: NDArray[np.int64]
    """(k,)"""

    def to_t(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Theta (..., p) in the box as -1 to 1."""
        low, high = self.box
        return 2 * (theta - low) / (high - low) - 1

    def to_theta(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """The inverse of `to_t`."""
        low, high = self.box
        return low + (t + 1) / 2 * (high - low)

    def basis(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return quadratic(self.to_t(theta))

    @cached_property
    def solver(self) -> NDArray[np.float64]:
        """What makes coefficients of values: (b, k)."""
        return self._solver(np.ones(len(self.theta)))

    def _solver(self, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        root = np.sqrt(self.num_events * weights)[:, None]
        return np.linalg.pinv(self.basis(self.theta) * root) * root.T

    def minimum(
        self, t: NDArray[np.float64], w: NDArray[np.float64], without: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The t (p,) near this one at which values whitened by w (K, r) are closest to the tables, and their slopes.

        The slopes are (r, p). Of the bank one theta may be left out.
        """
        solver = self.solver if without is None else self._solver(1.0 * (np.arange(len(self.theta)) != without))
        coefficients, wanted = solver @ self.values @ w, self.tables.values @ w
        start = np.clip(t, -1, 1)
        solution = least_squares(lambda t: quadratic(t) @ coefficients - wanted, start, bounds=(-1, 1))
        return solution.x, solution.jac

    @cached_property
    def misfit(self) -> NDArray[np.float64]:
        """Mean squared residual of each table's bins in units of the variance by simulation, 1 if a quadratic does."""
        b = self.basis(self.theta)
        variances = np.diagonal(self.covariances, axis1=1, axis2=2)
        squares = (self.values - b @ self.solver @ self.values) ** 2
        pulls = np.divide(squares, variances, out=np.zeros_like(squares), where=variances > 0)
        each = pulls.sum(axis=0) / (len(b) - b.shape[1])
        return np.array([each[part].mean() for part in self.tables.parts])

    def at(self, theta: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The values at theta (p,), and their covariance by simulation: (K,), (K, K).

        Where a quadratic does not do, what it misses counts as noise, which more thetas do not make less.
        """
        share = (self.basis(theta[None]) @ self.solver)[0]
        # The same for all bins of a table: else the noise of a normalised one would change its sum.
        missed = np.repeat(np.sqrt(np.maximum(self.misfit - 1, 0)), [len(table.values) for table in self.tables])
        noise = np.tensordot(share**2, self.covariances, 1) + np.outer(missed, missed) * self.covariances.mean(axis=0)
        return share @ self.values, noise

    def covariance_at(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The covariance of the differences from the tables at theta (p,), by measurement and simulation: (K, K).

        That by measurement is the mean of those of the thetas near it, which is a covariance too.
        """
        near = np.maximum((self.basis(theta[None]) @ self.solver)[0], 0)
        return np.tensordot(near / near.sum(), self.errors, 1) + self.at(theta)[1]

    def whitening_at(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """What makes the differences from the tables at theta (p,) uncorrelated, with variance 1: (K, r)."""
        return whitening(self.covariance_at(theta))

    def compare(self, theta: NDArray[np.float64]) -> Comparison:
        count = int(self.num_events.sum())
        return Comparison.of(self.tables, self.at(theta)[0], self.covariance_at(theta), count)


@dataclass(frozen=True, eq=False)
class TableFit:
    """Theta from published tables and a bank."""

    names: list[str]
    theta: NDArray[np.float64]
    """(p,)"""
    covariance: NDArray[np.float64]
    """The linearised covariance of theta (p, p). What the tables do not tell is as wide as the box."""
    at_bound: NDArray[np.bool_]
    """Which parameters ended at the end of the box, where errors mean little: (p,)."""
    before: Comparison | None
    """The tables at the default theta, if there is one."""
    after: Comparison
    """The tables at the fitted theta."""
    num_fitted: int
    """Directions of theta that the tables tell: so many degrees of freedom are lost."""
    polynomial: TablePolynomial

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard errors of theta (p,), if the tables agree at the fit; see `scaled_std`."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def dof(self) -> int:
        return self.after.dof - self.num_fitted

    @property
    def scaled_std(self) -> NDArray[np.float64]:
        """Standard errors (p,), times sqrt(chi-squared / dof) where that is above 1 (Particle Data Group)."""
        return self.std * np.sqrt(max(self.after.chi_squared / max(self.dof, 1), 1))

    def __str__(self) -> str:
        rows = zip(self.names, self.theta, self.scaled_std, self.at_bound, strict=True)
        lines = [f"{n} = {t:.4g} ± {s:.2g}{' (at the end of the box)' * bool(at)}" for n, t, s, at in rows]
        columns = [self.after] if self.before is None else [self.before, self.after]
        width = max(len(name) for name in ("all tables", *(row.table.name for row in self.after.rows)))
        lines.append(f"{'chi-squared':{width}}  {'   default' if self.before else ''}    fitted  dof")
        for i, row in enumerate(self.after.rows):
            numbers = "".join(f"{column.rows[i].chi_squared:10.1f}" for column in columns)
            lines.append(f"{row.table.name:{width}}  {numbers}  {row.dof:3d}")
        numbers = "".join(f"{column.chi_squared:10.1f}" for column in columns)
        lines.append(f"{'all tables':{width}}  {numbers}  {self.dof:3d}")
        lines.append(f"A quadratic misses the bank by {self.polynomial.misfit.mean():.2f} times its noise, on average.")
        return "\n".join(lines)


@checked
def fit_tables(
    tables: Table | Tables | list[Table],
    theta: ArrayLike,
    simulated: Iterable[Any],
    *,
    names: list[str] | None = None,
    box: ArrayLike | None = None,
    default: ArrayLike | None = None,
) -> TableFit:
    """Fit theta to published tables from a bank: simulated events at k thetas (k, p).

    `simulated` has the events of each theta, one after the other, or a `Reduced` of them, so that they need not be
    held in memory at once. Each bin's value is fitted by a quadratic polynomial in theta; chi-squared, with the noise
    of the bank, is minimised in the `box` (p, 2) of lower and upper ends, that of the thetas by default. At the
    `default` theta (p,) the tables are compared too, as they were before.

    Raises UsageError for fewer thetas than the polynomial has terms, or for what does not fit together.
    """
    tables, at = Tables.of(tables), numbers("thetas", theta).astype(float)
    at = at[:, None] if at.ndim == 1 else at
    reduced = [r if isinstance(r, Reduced) else Reduced.of(tables, r) for r in simulated]
    if at.ndim != 2 or not at.size:
        raise UsageError(f"thetas must be an array (k, p), got {at.shape}")
    k, p = at.shape
    if len(reduced) != k:
        raise UsageError(f"there are {k} thetas, but simulated events of {len(reduced)}")
    if k <= (terms := (p + 1) * (p + 2) // 2):
        raise UsageError(f"a quadratic in {p} parameters needs more than {terms} thetas, got {k}")
    limits = np.stack([at.min(axis=0), at.max(axis=0)]) if box is None else numbers("the box", box).astype(float).T
    start = None if default is None else np.atleast_1d(numbers("default", default).astype(float))
    if start is not None and start.shape != (p,):
        raise UsageError(f"default must be a number for each of {p} parameters, got {start.shape}")
    if limits.shape != (2, p) or not (limits[0] < limits[1]).all():
        raise UsageError(f"the box must have a lower and a higher end for each of {p} parameters")
    for what, one in [("theta of the bank", at), ("default", at[:1] if start is None else start[None])]:
        if ((one < limits[0]) | (one > limits[1])).any():
            raise UsageError(f"a {what} lies outside the box, where the polynomial is not known")
    values, covariances = zip(*(r.predicted(tables) for r in reduced), strict=True)
    count = np.array([r.num_events for r in reduced])
    # What is rare is so among the events of all thetas.
    errors = np.array([replace(r, num_events=int(count.sum())).errors_of(tables) for r in reduced])
    polynomial = TablePolynomial(tables, limits, at, np.array(values), np.array(covariances), errors, count)
    if np.linalg.matrix_rank(polynomial.basis(at)) < terms:
        raise UsageError("the thetas do not spread over the box in all directions: take a Latin hypercube")
    names = [f"theta{i}" for i in range(p)] if names is None else list(names)
    if len(names) != p:
        raise UsageError(f"{len(names)} names for {p} parameters")
    return _best(polynomial, names, start)


def _best(polynomial: TablePolynomial, names: list[str], default: NDArray[np.float64] | None) -> TableFit:
    """The lowest of the minima that are found from the centre of the box, its nearest theta, and the default."""
    middle = polynomial.box.mean(axis=0)
    away = (polynomial.values - polynomial.tables.values) @ polynomial.whitening_at(middle)
    closest = polynomial.theta[(away**2).sum(axis=1).argmin()]
    starts = [middle, closest, *([] if default is None else [default])]
    minima = [_settled(polynomial, polynomial.to_t(start)) for start in starts]
    t, w, slopes = min(minima, key=lambda each: polynomial.compare(polynomial.to_theta(each[0])).chi_squared)
    theta, half = polynomial.to_theta(t), np.ptp(polynomial.box, axis=0) / 2
    # In the box as -1 to 1, where the variance of what may be anywhere is 1/3.
    values, vectors = np.linalg.eigh(slopes.T @ slopes)
    every = (vectors / np.maximum(values, 3)) @ vectors.T
    linear = every @ slopes.T @ w.T  # how t follows the measured values
    # The noise of the bank enters the slopes too, and so is taken from the bank itself, by a jackknife over its thetas.
    k = len(polynomial.theta)
    without = np.array([polynomial.minimum(t, w, i)[0] for i in range(k)])
    noise = (k - 1) * np.cov(without, rowvar=False, bias=True).reshape(len(t), len(t))
    cov = (every - linear @ polynomial.at(theta)[1] @ linear.T + noise) * np.outer(half, half)
    before = None if default is None else polynomial.compare(default)
    num_fitted = int((values > 3).sum())
    return TableFit(names, theta, cov, np.abs(t) > 1 - 1e-3, before, polynomial.compare(theta), num_fitted, polynomial)


def _settled(
    polynomial: TablePolynomial, t: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The minimum of chi-squared near t (p,), the whitening of the values there (K, r), and their slopes (r, p)."""
    for _ in range(ROUNDS):
        w = polynomial.whitening_at(polynomial.to_theta(t))
        last, (t, slopes) = t, polynomial.minimum(t, w)
        if np.abs(t - last).max() < STANDSTILL:
            break
    return t, w, slopes
