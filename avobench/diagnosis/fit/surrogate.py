"""A black-box simulator's mean summary as a quadratic polynomial, from events that each have their own parameters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.summary.target import Target, Vectors
from avobench.effects.model import Model

COMPARED = 10_000
"""Events that are compared one by one with what the same seed makes elsewhere."""
SHRINK = 3.0
"""How much narrower a design may be than the one before."""
BENT = 0.1
"""Share of Q that a surrogate may lack for being no better polynomial: less than that hardly moves the minimum.
Chosen by trial."""
NARROWER = 3
"""How often a design is narrowed by SHRINK, at most: to a twenty-seventh."""
FALLS = 0.5
"""Share of the lack that a narrower design may leave, at most. A cubic term falls to a ninth; noise or a jump stays."""
CLEAR = 3.0
"""Standard errors by simulation from which a squared slope is one, and a point is worse than another."""


@dataclass(frozen=True)
class Design:
    """Where parameters are drawn from: u = centre + axes t, with t in [-1, 1]^P, kept within the unit cube."""

    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    """(P, P), invertible."""

    @classmethod
    def box(cls, centre: NDArray[np.float64], half: NDArray[np.float64]) -> "Design":
        return cls(np.clip(centre, 0, 1), np.diag(half))

    def to_t(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., P) -> (..., P)"""
        return (u - self.centre) @ np.linalg.inv(self.axes).T

    def to_u(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., P) -> (..., P), within the unit cube."""
        return np.clip(self.centre + t @ self.axes.T, 0, 1)


@dataclass(frozen=True)
class Surrogate:
    """E[s] as a quadratic polynomial in a design's t, from a linear regression on simulated events."""

    design: Design
    coefficients: NDArray[np.float64]
    """(b, K)"""
    num_events: int
    inverse: NDArray[np.float64]
    """(b, b), of the normal equations: the covariance of the coefficients in units of that of one event."""
    bend: NDArray[np.float64]
    """(K,), at the centre, from events that are spread minus from those there: noise, unless E[s] is no quadratic."""
    bend_variance: float
    """In units of that of one event."""

    def noiseless_q_at_centre(self, target: Target) -> tuple[float, float]:
        """Q at the centre of the design, without what simulation adds on average, and its standard error."""
        return _without_noise(target, target.mean - self.coefficients[0], float(self.inverse[0, 0]))

    def lack(self, target: Target) -> tuple[float, float]:
        """What the polynomial lacks at the centre, in Q, and its standard error: the test of response surfaces."""
        return _without_noise(target, self.bend, self.bend_variance)

    def bends(self, target: Target) -> bool:
        """Whether E[s] is plainly no quadratic over the design."""
        lack, error = self.lack(target)
        return lack > max(CLEAR * error, BENT * self.noiseless_q_at_centre(target)[0])

    def at(self, u: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean summary at u (P,) and its derivative: (K,), (P, K)."""
        t = self.design.to_t(u)
        slope = np.linalg.inv(self.design.axes).T @ basis_slope(t).T @ self.coefficients
        return basis(t[None])[0] @ self.coefficients, slope

    def variance_at(self, u: NDArray[np.float64]) -> float:
        """Variance of `at` by simulation, in units of that of one event."""
        b = basis(self.design.to_t(u)[None])[0]
        return float(b @ self.inverse @ b)


def _without_noise(target: Target, difference: NDArray[np.float64], variance: float) -> tuple[float, float]:
    """Q of a difference (K,) of simulated means, without what their variance adds, and its standard error."""
    noise = target.num_events * variance
    q = float((target.whiten(difference) ** 2).sum())
    return q - noise * target.rank, float(np.sqrt(2 * target.rank * noise**2 + 4 * q * noise))


def basis(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """1, t_i, and all products t_i t_j: (n, P) -> (n, 1 + P + P (P + 1) / 2)."""
    n, p = t.shape
    rows = np.empty(((p + 1) * (p + 2) // 2, n))
    rows[0], rows[1 : p + 1] = 1, t.T
    at = p + 1
    for i in range(p):
        np.multiply(rows[1 + i], rows[1 + i : p + 1], out=rows[at : at + p - i])
        at += p - i
    return rows.T


def basis_slope(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivative of `basis` at one point: (P,) -> (b, P)."""
    p = len(t)
    i, j = np.triu_indices(p)
    products = np.eye(p)[i] * t[j][:, None] + np.eye(p)[j] * t[i][:, None]
    return np.concatenate([np.zeros((1, p)), np.eye(p), products])


def surrogate(model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator) -> Surrogate:
    """The mean vector over a design, from events of which half lie at its centre and half are spread over it.

    Each spread event has a twin at the centre, simulated from the same seed. Where a simulator makes much the same of
    the same seed, the differences of twins tell the slopes with little noise; where it does not, a plain regression
    does. Places and events come from two streams, so that from one seed all models get the same events.
    """
    places, happenings = rng.spawn(2)
    pairs, k = max(num_events // 2, 1), (model.dim + 1) * (model.dim + 2) // 2
    normal, at_centre, spread, unlike = np.zeros((k, k)), 0.0, 0.0, 0.0
    left = pairs
    while left > 0:
        n = min(left, model.at_once)
        u = design.to_u(places.uniform(-1, 1, (n, model.dim)))
        b = basis(design.to_t(u))
        seed = int(happenings.integers(2**63))
        twins = model.simulate(model.from_cube(np.tile(design.centre, (n, 1))), np.random.default_rng(seed))
        x = model.simulate(model.from_cube(u), np.random.default_rng(seed))
        normal += b.T @ b
        at_centre = at_centre + vectors.moments(twins, b)
        spread = spread + vectors.moments(x, b)
        unlike += n / pairs * float(vectors.moved(twins[:COMPARED], x[:COMPARED]).mean())
        left -= n
    alone = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
    if unlike < 1:
        bend, bend_variance = alone[0] @ (spread - at_centre), unlike * alone[0, 0]
        inverse = np.zeros((k, k))
        inverse[0, 0] = 1 / pairs
        slopes = np.linalg.pinv(normal[1:, 1:], rcond=1e-12, hermitian=True)
        inverse[1:, 1:] = unlike * slopes
        coefficients = np.vstack([at_centre[0] / pairs, slopes @ (spread - at_centre)[1:]])
        return Surrogate(design, coefficients, num_events, inverse, bend, bend_variance)
    constant = np.eye(k)[0]  # the basis at the centre
    inverse = np.linalg.pinv(normal + pairs * np.outer(constant, constant), rcond=1e-12, hermitian=True)
    coefficients = inverse @ (spread + np.outer(constant, at_centre[0]))
    bend, bend_variance = alone[0] @ spread - at_centre[0] / pairs, alone[0, 0] + 1 / pairs
    return Surrogate(design, coefficients, num_events, inverse, bend, bend_variance)


def quadratic(make: Callable[[Design], Surrogate], design: Design, target: Target) -> Surrogate:
    """The surrogate over a design, or over a narrower one where that is plainly no quadratic, and this one more so."""
    s = make(design)
    for _ in range(NARROWER):
        if not s.bends(target):
            break
        narrower = make(Design(s.design.centre, s.design.axes / SHRINK))
        if narrower.lack(target)[0] > FALLS * s.lack(target)[0]:
            break  # it is noise, or a jump
        s = narrower
    return s
