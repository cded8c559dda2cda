"""The minimiser of the Jensen-Shannon divergence, where `avo` can end in place of a match of moments.

Let p be the density of the events simulated at theta, r that of the observed ones, and d = r / (p + r) the best
discriminator. The gradient of the divergence in theta is half of E_p[s log(1 - d)], with s the score of p (from
Equation 3 of the paper). What is solved here is

    E_p[s (log(1 - d) + d)] = E_r[s (1 - d)].

With the best d it is the same, since E_p[s d] = E_r[s (1 - d)]. But its derivative in d vanishes there, so that an
error of the discriminator counts squared only (Chernozhukov et al., Econometrics Journal 21 (2018) C1). An observed
event moves the solution by its score times 1 - d = p / (p + r): one that the simulator does not make moves nothing.
Where the simulator is right d = 1/2, and this is the match of the mean of s.

For any feature g the mean of the simulated events moves with theta as E_p[s g]. So the combination of features that
stands for the score has the coefficients C^-1 dE[g]/dtheta, with C the covariance of the features: its projection.
`docs/robust.md` has the derivation, and what was measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_expit

from avobench.methods.leeway import is_open
from avobench.methods.polish import RIDGE, Neighbours, Polished, Response, TooFewEvents, descend, kernel_of
from avobench.tasks.quadratic import quadratic

MOST_STEPS = 15
"""Largest number of steps, each with a discriminator of its own: three to five are the rule."""
STANDS_STILL = 0.1
"""The search ends with a step below this share of the standard error."""
SHARP = 0.3
"""Width of the kernel that stands for "simulated at theta", in units of that of the polish. A quadratic in theta takes
what the width adds out of the mean of a statistic, but nothing takes it out of the density that the discriminator
sees."""
STRAIGHT = 0.75
"""Width of the kernel within which it is told how features move with theta, in the same units. Features that are nearly
combinations of each other enlarge what that fit has wrong, hence its terms of third order. Of 0.5, 0.75 and 1 this one
lost least where the simulator is right among those that were within their errors where it is wrong."""
INDEPENDENT = 1e-5
"""Least variance of a combination of the discriminator's features, each of unit variance, that is made use of."""

Pair = tuple[NDArray[np.float32], NDArray[np.float32]]
"""The same features of observed (N, k) and of simulated events (n, k)."""


@dataclass(frozen=True)
class Score:
    """The projection of the score on features, p combinations of them."""

    weights: NDArray[np.float64]
    """(k, p)"""
    precision: NDArray[np.float64]
    """Inverse of the covariance of the features (k, k)."""
    noise: NDArray[np.float64]
    """Covariance (p, p) of the weights of a feature of unit variance that does not move with theta."""


class Contrast:
    """One half of the events, seen by networks that learnt from the other half only.

    `phi` are the features from which the score is learnt, `psi` those of the discriminator, which is a logistic
    regression. It learns from `training`, the features of the other half by the same networks. The simulated events of
    this half are at u (n, p), those of the other at `training_u`.
    """

    def __init__(
        self, phi: Pair, psi: Pair, training: Pair, u: NDArray[np.float64], training_u: NDArray[np.float64]
    ) -> None:
        from sklearn.linear_model import LogisticRegression

        self.phi, self.psi, self.training, self.u, self.training_u = phi, psi, training, u, training_u
        self.model = LogisticRegression(solver="newton-cholesky", warm_start=True)
        self.whitened = False
        self.divergence, self.is_minimum = np.inf, False

    def score(self, mean: NDArray[np.float64], kernel: NDArray[np.float64]) -> Score:
        """What stands for the score at `mean` (p,). Raises TooFewEvents."""
        near, wide = Neighbours(self.u, mean, SHARP * kernel), Neighbours(self.u, mean, STRAIGHT * kernel, cubic)
        at, around = (self.phi[1][each.rows].astype(float) for each in (near, wide))
        precision, linear = np.linalg.pinv(near.covariance(at, at), hermitian=True), slice(1, 1 + len(mean))
        slope, noise = wide.fit(around)[linear], wide.spread[linear, linear]
        return Score(precision @ slope.T @ wide.unit, precision, wide.unit.T @ noise @ wide.unit)

    def response(self, score: Score, mean: NDArray[np.float64], kernel: NDArray[np.float64]) -> Response:
        """How the two sides of the equation differ at `mean` (p,), and how that depends on theta. Raises TooFewEvents.

        The derivative of E_p[h] in theta is E_p[h score], and the score is the one combination of s whose mean moves
        with theta as that of s does. That is known from a wide kernel, where the mean of h itself would be curved.
        """
        wide, near = Neighbours(self.u, mean, kernel), Neighbours(self.u, mean, SHARP * kernel)
        observed, simulated = self._logits(mean, kernel, near)
        all_phi, phi = (self.phi[1][rows].astype(float) for rows in (wide.rows, near.rows))
        f = log_expit(-simulated)
        center, mean_f = wide.fit(all_phi)[0], near.fit(f)[0]
        s = (phi - center) @ score.weights
        # with the mean of f taken out the derivative in the center vanishes too, and that in theta is the whole one
        left = s * (f + expit(simulated) - mean_f)[:, None]
        right = ((clipped(self.phi[0], phi) - center) @ score.weights) * expit(-observed)[:, None]
        slope = np.linalg.pinv(near.covariance(s, s), hermitian=True) @ near.covariance(s, left)
        rest = left - s @ slope  # the mean of s is 0: what is left of h where the simulator is right is nothing
        self.is_minimum = bool((np.linalg.eigvals(slope).real > 0).all())
        self.divergence = float(np.log(2) + (log_expit(observed).mean() + mean_f) / 2)

        p, spread = len(mean), wide.spread
        spread[1 : 1 + p, 1 : 1 + p] *= len(center) / p
        coefficients = np.zeros((len(spread), p))
        coefficients[0] = near.fit(rest)[0] - right.mean(axis=0)
        coefficients[1 : 1 + p] = wide.fit(all_phi @ score.weights)[1 : 1 + p] @ slope
        pull = near.covariance(phi, f[:, None])[:, 0]
        covariance = near.covariance(rest, rest) * near.spread[0, 0]
        covariance += near.covariance(s @ slope, s @ slope) * spread[0, 0]
        covariance += np.atleast_2d(np.cov(right, rowvar=False)) / len(right)
        covariance += score.noise * (pull @ score.precision @ pull)
        covariance += RIDGE * np.diag(np.diag(covariance))
        inverse = np.linalg.inv(covariance / (spread[0, 0] + 1 / len(right)))
        return Response(mean, wide.unit, coefficients, spread, inverse, len(right))

    def _logits(
        self, mean: NDArray[np.float64], kernel: NDArray[np.float64], judged: Neighbours
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The logit of d at `mean` (p,), of the observed events (N,) and of the judged ones (n,)."""
        near = Neighbours(self.training_u, mean, SHARP * kernel)
        if not self.whitened:
            self._whiten(near.rows)
        (real, made), n = self.training, len(self.training[0])
        weights = np.concatenate([np.ones(n), near.weights * n / near.weights.sum()])
        self.model.fit(np.concatenate([real, made[near.rows]]), np.arange(len(weights)) < n, weights)
        observed, simulated = self.psi[0], self.psi[1][judged.rows]
        return tuple(self.model.decision_function(x).astype(float) for x in (observed, simulated))

    def _whiten(self, rows: NDArray[np.intp]) -> None:
        """Decorrelate what the discriminator sees, within the range of the simulated events of these rows."""
        simulated = self.training[1][rows]
        x = np.concatenate([clipped(self.training[0], simulated), simulated]).astype(float)
        shift, scale = x.mean(axis=0), x.std(axis=0)
        scale[scale == 0] = 1
        variance, axes = np.linalg.eigh(np.cov(x / scale, rowvar=False))
        kept = variance > INDEPENDENT
        turn = (axes[:, kept] / np.sqrt(variance[kept]) / scale[:, None]).astype(np.float32)
        self.training, self.psi = (
            tuple((clipped(x, simulated) - shift.astype(np.float32)) @ turn for x in pair)
            for pair in (self.training, self.psi)
        )
        self.whitened = True


def cubic(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """The terms of a quadratic, and z_i z_j^2, which of third order are those that a slope in z_i is told apart from.

    (n, p) -> (n, m).
    """
    return np.hstack([quadratic(z), (z[:, :, None] * z[:, None] ** 2).reshape(len(z), -1)])


def clipped(x: NDArray[np.float32], simulated: NDArray) -> NDArray:
    """Features x (n, k) within the range of the simulated ones (m, k): nothing is learnt of what lies outside."""
    return np.clip(x, simulated.min(axis=0), simulated.max(axis=0))


class Minimum(NamedTuple):
    """Where the divergence is least, as seen from one place."""

    answer: Polished
    divergence: float
    """The Jensen-Shannon divergence there, in nats."""


def minimise(
    contrasts: Sequence[Contrast],
    mean: NDArray[np.float64],
    root: NDArray[np.float64],
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
    toward: NDArray[np.float64] | float,
) -> Minimum:
    """Solve the equation from `mean` (p,), with the scores there.

    The other arguments are those of `polish`. At a solution that is no minimum the answer has not converged.
    """
    kernel = kernel_of(root)

    def responses(mean: NDArray[np.float64]) -> list[Response]:
        return [one.response(score, mean, kernel) for one, score in zip(contrasts, scores, strict=True)]

    try:
        scores = [one.score(mean, kernel) for one in contrasts]
    except TooFewEvents:
        return Minimum(Polished(mean, root @ root.T, 0, converged=False), np.inf)
    answer = descend(responses, mean, root, bounds, toward, MOST_STEPS, STANDS_STILL)
    if not is_open(answer) and not all(one.is_minimum for one in contrasts):
        answer = replace(answer, converged=False)
    return Minimum(answer, float(np.mean([one.divergence for one in contrasts])))
