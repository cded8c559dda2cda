"""The polish, a phase of `avo`: discriminator and proposal brought to rest on the events already simulated."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from avobench.tasks.quadratic import quadratic

WIDTH = 2.5
"""Width of the kernel over theta with one parameter, in standard deviations of the proposal. With p parameters it is
p^(1/4) times that, which weighs the proposal's events alike to a few per cent whatever p is. Events of earlier, wider
proposals count as well, and are needed: the further they are apart, the better they show how the mean of phi moves."""
REACH = 3.0
"""Events are left out whose squared distance in kernel widths is above REACH^2 plus the number of parameters. Each of
them would weigh less than 0.7 % of an event at the mean."""
CONSTANT = 1e-6
"""A feature that varies by less than this share of the one that varies most is constant to single precision."""
RIDGE = 1e-4
"""Share of its variance that is added to each feature's, for features that are nearly copies of each other."""
SIGNIFICANT = 3.0
"""Least ratio of the information along a combination of parameters to what mere noise would show. Noise itself is a
chi-squared over its degrees of freedom, one a feature, and stays well below."""
LIKELY = 0.5
"""Information on a combination of parameters, in the same units, that noise is as likely as not to hide."""
MAX_STEPS = 50
"""Largest number of steps: several times what it takes where the polish converges. Elsewhere the answer says so."""
STANDS_STILL = 1e-3
"""The polish ends with a step below this share of the standard error, in 3 to 10 steps as a rule."""
FARTHEST = 2.0
"""Largest distance from the center of the fit, in kernel widths: beyond it the fit describes next to no events."""
MANY = 20
"""Events for each feature from which a misfit can be told: the covariance of the features must be known well."""
KNOWN = 40
"""Observed events for each feature from which they tell its covariance. With fewer its noise would count as knowledge;
then simulated events tell it, which show long tails as well."""
LARGER_OF_FEW = 1.05
"""Factor by which errors are larger over a narrower kernel, from which those of the wider one do not stand, where the
observed events are too few to tell a covariance: their errors are wide, and over ten of them the means bend."""
UNLIKE = 100.0
"""Factor by which a simulated event would enlarge the observed variance along its direction, from which the observed
events are said not to know that variance. It stayed below 30 on 15 targets of poisson and one or two of six other
tasks. Where pixels are never hit it is mostly a million and more, and some hundred for pairs of rare ones."""
SAME = 2.0
"""Standard errors within which, over all parameters, a closer look at the same events must find the answer again."""
SLOPES = 8.0
"""Ratio of the information to what noise alone would show, from which the errors of a closer look are believed: over a
narrow kernel the means hardly differ, so noise could hide how they move."""
LOOKS = 10
"""Largest number of closer looks. One is the rule; a far start with a strong curve needs 2 or 3."""
FEWEST = 4
"""Least number of events within reach for each coefficient of the local quadratic; with fewer there is no fit."""


@dataclass(frozen=True)
class Polished:
    """The answer of a polish, in the standardised coordinates of the proposal."""

    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    """Covariance of the mean (p, p); as large as the prior's along a direction that the events leave open."""
    num_steps: int
    converged: bool
    significance: float = 0.0
    """Least information on a combination of the parameters, in units of what mere noise would show."""
    alone: NDArray[np.float64] | None = None
    """Covariance (p, p) by what the events say without the prior; None where that was not asked of them. Along what
    they do not tell it is about as small as it can be without their telling it."""
    hidden: float = 0.0
    """Largest information that noise may hide on a combination of which the slopes are not known, a prior's is 1."""

    @property
    def error(self) -> NDArray[np.float64]:
        return np.sqrt(np.diag(self.covariance))


class TooFewEvents(Exception):
    """There is no local fit, since next to no simulated events are near."""


class Neighbours:
    """The simulated events near a point (p,), with weights of a Gaussian kernel of covariance kernel @ kernel.T (p, p).

    What is fitted to them is a quadratic in z = unit (u - point), or other `terms` that begin with 1 and z. Raises
    TooFewEvents where there are too few for it.
    """

    def __init__(
        self,
        u: NDArray[np.float64],
        point: NDArray[np.float64],
        kernel: NDArray[np.float64],
        terms: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None,
    ) -> None:
        self.unit = np.linalg.inv(kernel)
        z = (u - point) @ self.unit.T
        distance = (z**2).sum(axis=1)
        self.rows = np.flatnonzero(distance < REACH**2 + len(point))
        self.z = z[self.rows]
        fitted = (terms or quadratic)(self.z)
        if len(self.rows) < FEWEST * fitted.shape[1]:
            raise TooFewEvents
        self.weights = np.exp(-distance[self.rows] / 2)
        self._weighted = fitted * self.weights[:, None]
        self._inverse = np.linalg.pinv(fitted.T @ self._weighted, hermitian=True)

    def fit(self, values: NDArray) -> NDArray:
        """Coefficients (m, k) of what describes values (n, k) of the events near by."""
        return self._inverse @ (self._weighted.astype(values.dtype).T @ values)

    @property
    def spread(self) -> NDArray[np.float64]:
        """Covariance (m, m) of the coefficients where the values have unit variance."""
        return self._inverse @ (self._weighted.T @ self._weighted) @ self._inverse

    def covariance(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        """The weighted covariance (k, m) of values a (n, k) and b (n, m) of these events."""
        a, b = (x - np.average(x, axis=0, weights=self.weights) for x in (a, b))
        return (a * (self.weights / self.weights.sum())[:, None]).T @ b


class Fold:
    """Events on which a discriminator was not trained, as its last layer sees them.

    `real` (N, k) are the features phi of the observed events, and `synthetic` (n, k) those of the events simulated at
    u (n, p); see `polish`. From `known` observed events for each feature on, they tell the covariance for an answer.
    """

    def __init__(
        self, real: NDArray[np.float32], synthetic: NDArray[np.float32], u: NDArray[np.float64], least: int = KNOWN
    ) -> None:
        scale, simulated = real.std(axis=0, dtype=float), synthetic.std(axis=0, dtype=float)
        alike = scale.max() <= CONSTANT * simulated.max()
        if alike:  # they may scatter as if one event in N were as far off as a simulated one is
            scale = simulated / np.sqrt(len(real))
        kept = scale > CONSTANT * scale.max()
        self.kept, self.shift, self.scale = kept, real.mean(axis=0, dtype=float)[kept], scale[kept]
        real = self._standardised(real)
        covariance = np.eye(kept.sum()) if alike else (real.T @ real).astype(float) / len(real)
        self.covariance = covariance + RIDGE * np.eye(len(covariance))
        self.inverse = np.linalg.inv(self.covariance)
        self.num_observations, self.is_known = len(real), len(real) >= least * kept.sum()
        self.synthetic, self.u = self._standardised(synthetic), u

    def _standardised(self, phi: NDArray[np.float32]) -> NDArray[np.float32]:
        return ((phi[:, self.kept] - self.shift) / self.scale).astype(np.float32)

    def add(self, synthetic: NDArray[np.float32], u: NDArray[np.float64]) -> None:
        self.synthetic = np.concatenate([self.synthetic, self._standardised(synthetic)])
        self.u = np.concatenate([self.u, u])

    def near(self, center: NDArray[np.float64], kernel: NDArray[np.float64], *, test: bool = False) -> "Response":
        """How the mean of phi depends on theta near center (p,); the kernel's covariance is kernel @ kernel.T (p, p).

        The covariance is that of the observed events, or of the simulated ones about their mean, see KNOWN, which is
        also what counts for a `test`. Raises TooFewEvents.
        """
        near = Neighbours(self.u, center, kernel)
        synthetic = self.synthetic[near.rows]
        coefficients = near.fit(synthetic)
        if self.is_known or (test and self.num_observations >= KNOWN * len(self.shift)):
            inverse = self.inverse_beside(synthetic, near.weights)
        else:
            scatter = synthetic - quadratic(near.z) @ coefficients
            inverse = ridged_inverse(near.covariance(scatter, scatter))
        return Response(center, near.unit, coefficients, near.spread, inverse, self.num_observations)

    def inverse_beside(self, synthetic: NDArray[np.float32], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """The inverse covariance (k, k) of the observed events and of those simulated ones (n, k) that are unlike them.

        The simulated events have weights (n,). Unlike is one that hits a pixel that was never hit, for example.
        """
        leverage = weights * ((synthetic @ self.inverse.astype(np.float32)) * synthetic).sum(axis=1)
        unlike = leverage > UNLIKE * self.num_observations
        if not unlike.any():
            return self.inverse
        rows = synthetic[unlike] * np.sqrt(weights[unlike])[:, None]
        return np.linalg.inv(self.covariance + rows.T @ rows / self.num_observations)

    def misfit(self, mean: NDArray[np.float64], root: NDArray[np.float64]) -> float:
        """The squared difference of the means of phi at `mean` (p,) from the observed ones, over what chance makes it.

        It is about 1 where `mean` is right, and 1 by definition where there are too few events to tell. Raises
        TooFewEvents.
        """
        response = self.near(mean, kernel_of(root), test=True)
        difference = response.coefficients[0]
        if response.num_effective < MANY * len(difference):
            return 1.0
        return float(difference @ response.inverse @ difference * response.num_effective / len(difference))


@dataclass(frozen=True)
class Response:
    """E[phi | u] as a quadratic in z = unit (u - center), fitted to the events of a fold."""

    center: NDArray[np.float64]
    unit: NDArray[np.float64]
    coefficients: NDArray[np.float64]
    spread: NDArray[np.float64]
    """Covariance of the coefficients where phi has unit variance (m, m)."""
    inverse: NDArray[np.float64]
    num_observations: int

    @property
    def num_effective(self) -> float:
        """Number of events that would leave the difference of the means at the center as uncertain as it is."""
        return 1 / (1 / self.num_observations + self.spread[0, 0])

    def at(self, mean: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Gradient (p,) in the proposal's mean (p,), information (p, p), and what information mere noise would show.

        They hold for all events of the fold together. The Jacobian is that at the center, where it is known best.
        """
        value = quadratic((self.unit @ (mean - self.center))[None])[0]
        linear = slice(1, 1 + len(mean))
        difference, jacobian = -value @ self.coefficients, self.unit.T @ self.coefficients[linear]  # observed mean: 0
        num_effective = 1 / (1 / self.num_observations + value @ self.spread @ value)
        weighted = jacobian @ self.inverse
        noise = len(difference) * self.unit.T @ self.spread[linear, linear] @ self.unit
        return num_effective * weighted @ difference, num_effective * weighted @ jacobian.T, num_effective * noise


def polish(
    folds: list[Fold],
    mean: NDArray[np.float64],
    root: NDArray[np.float64],
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
    toward: NDArray[np.float64] | float = 0.0,
) -> Polished:
    """Where the proposal's mean stands still: there the simulated mean of phi agrees best with the observed one.

    phi is what each fold holds of an event. The proposal's mean (p,) is where to begin, and its covariance, root (p, p)
    times its transpose, says how far to look; the answer lies within bounds, (p,) each. The prior has mean 0 and
    variance 1. Each fold has events of which its phi was not learnt: it knows the events it was learnt from too well.

    A linear discriminator on phi near the solution, where d is close to 1/2 and the cross-entropy quadratic, has its
    optimum at Fisher's w = C^-1 (E[phi | real] - E[phi | mean]) with C the covariance of phi, and f = log(1 - d) is a
    constant minus w . phi / 2. The score-function gradient of E[f] in the mean is then -J w / 2, with J (p, k) the
    gradient of E[phi | mean]. Divided by the information J C^-1 J^T it is a natural gradient (Amari 1998), and one step
    of it goes all the way if E[phi] is linear.

    E[phi | mean] and J are a least-squares fit of phi by a quadratic in u - mean, weighted by a Gaussian kernel: the
    score-function estimate with a baseline that also removes what the proposal's width adds. The prior, as a Gaussian
    of its moments, moves theta by far less than a standard error where it is identified, and decides where it is not.
    """
    kernel = kernel_of(root)
    try:
        responses = [fold.near(mean, kernel) for fold in folds]
    except TooFewEvents:
        return Polished(mean, root @ root.T, 0, converged=False)
    return descend(lambda mean: responses, mean, root, bounds, toward)


def descend(
    responses_at: Callable[[NDArray[np.float64]], Sequence[Response]],
    mean: NDArray[np.float64],
    root: NDArray[np.float64],
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
    toward: NDArray[np.float64] | float,
    max_steps: int = MAX_STEPS,
    stands_still: float = STANDS_STILL,
) -> Polished:
    """Natural-gradient steps from `mean` (p,) until one is below `stands_still` standard errors, as in `polish`.

    `responses_at(mean)` says of each fold how its features respond to theta; it may raise TooFewEvents.
    """
    (low, high), kernel = bounds, kernel_of(root)
    unit, center, reach, last = np.linalg.inv(kernel), mean, 1.0, np.zeros_like(mean)
    for step in range(1, max_steps + 1):
        try:
            parts = zip(*(response.at(mean) for response in responses_at(mean)), strict=True)
        except TooFewEvents:
            return Polished(mean, root @ root.T, step - 1, converged=False)
        gradient, apparent, noise = (sum(part) for part in parts)
        gradient, information, significance = significant(gradient, apparent, noise)
        precision = information + np.eye(len(mean))
        force = gradient - (mean - toward)
        free = ~(((mean <= low) & (force < 0)) | ((mean >= high) & (force > 0)))  # the others rest on a bound
        move = np.zeros_like(mean)
        move[free] = np.linalg.solve(precision[np.ix_(free, free)], force[free])
        covariance = np.linalg.inv(precision)
        if (np.abs(move) < stands_still * np.sqrt(np.diag(covariance))).all():
            return Polished(mean, covariance, step, True, significance, *without_prior(apparent, noise))
        reach, last = (reach / 2 if (unit @ move) @ (unit @ last) < 0 else reach), move  # back and forth is too far
        mean = mean + move * min(1, reach / np.linalg.norm(unit @ move))
        mean = center + (mean - center) * min(1, FARTHEST / max(np.linalg.norm(unit @ (mean - center)), FARTHEST))
        mean = np.clip(mean, low, high)
    return Polished(mean, root @ root.T, max_steps, converged=False)


def polish_closer(
    folds: list[Fold],
    mean: NDArray[np.float64],
    root: NDArray[np.float64],
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
    narrowing: tuple[float, float],
    toward: NDArray[np.float64] | float = 0.0,
    larger: float = np.inf,
    *,
    alone: bool = False,
) -> tuple[Polished, NDArray[np.float64]]:
    """The polish, and the root (p, p) of the width at which it can be believed.

    Over a wide kernel E[phi | u] need not be a quadratic. A narrower kernel tells: where its answer is further away
    than its own errors explain, or its errors are known and `larger` times those of the wider one, it takes the place
    of the wider one's and is tested in its turn; else the wider one stands, as it uses more events. A closer look that
    does not come to rest tells nothing. How narrow that is follows from what the events say `alone`, or with the prior.
    Otherwise as `polish`.
    """
    answer = polish(folds, mean, root, bounds, toward)
    if np.isfinite(larger) and not all(fold.is_known for fold in folds):
        larger = LARGER_OF_FEW
    for _ in range(LOOKS):
        narrow = narrower(root, answer, *narrowing, np.sqrt((root**2).sum(axis=1)) if alone else None)
        again = polish(folds, answer.mean, narrow, bounds, toward)
        apart = np.linalg.norm(again.mean - answer.mean)
        moved = apart > SAME * np.linalg.norm(again.error)
        less_sure = again.significance > SLOPES and (again.error > larger * answer.error).any()
        same = not (again.converged and (moved or less_sure))
        if again.num_steps == 0 or (answer.converged and same):
            break
        answer, root = again, narrow
    return answer, root


def kernel_of(root: NDArray[np.float64]) -> NDArray[np.float64]:
    """The root of the kernel's covariance (p, p), from that of the proposal's covariance."""
    return WIDTH * len(root) ** 0.25 * root


def within_reach(u: NDArray[np.float64], point: NDArray[np.float64], root: NDArray[np.float64]) -> NDArray[np.int64]:
    """The rows of u (n, p) that a polish from a point (p,) uses; the proposal's covariance has this root (p, p)."""
    z = (u - point) @ np.linalg.inv(kernel_of(root)).T
    return np.flatnonzero((z**2).sum(axis=1) < REACH**2 + len(point))


def narrower(
    root: NDArray[np.float64],
    answer: Polished,
    shrink: float,
    errors: float,
    widest: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """The root (p, p) of the next proposal's covariance: `errors` standard errors of the answer along each axis.

    That is between `shrink` times and once as wide as the last proposal: a first answer may be far off, and along a
    combination of parameters of which the events say nothing it stays as wide as it is. With `widest` (p,) the errors
    are those of the events without the prior, and it grows up to these standard deviations: over a prior as narrow as
    these errors nobody sees how the events depend on theta.
    """
    unit, free = np.linalg.inv(root), widest is not None and answer.alone is not None
    variance, axes = np.linalg.eigh(unit @ (answer.alone if free else answer.covariance) @ unit.T)
    stretch = np.sqrt((errors**2 * variance).clip(shrink**2, np.inf if free else 1))
    root = root @ (axes * stretch) @ axes.T  # whatever axes eigh picks
    return root if widest is None else root * np.minimum(1, widest / np.sqrt((root**2).sum(axis=1)))[:, None]


def without_prior(information: NDArray[np.float64], noise: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """What the events say alone, `alone` (p, p) and `hidden` of `Polished`, by information and its noise (p, p)."""
    value, axes = in_noise(information, noise)
    back = noise @ axes[:, value < SLOPES]
    hidden = SIGNIFICANT * np.linalg.norm(back, 2) ** 2 if back.size else 0.0
    return (axes / np.maximum(value - 1, LIKELY)) @ axes.T, float(hidden)


def significant(
    gradient: NDArray[np.float64], information: NDArray[np.float64], noise: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """The parts of gradient (p,) and information (p, p) along what is more than noise (p, p), and the least ratio.

    Where E[phi] does not depend on a combination of the parameters, its Jacobian is noise, and so is the information
    that it seems to hold; left in, this would outweigh the prior and send the mean anywhere along a degeneracy.
    """
    value, axes = in_noise(information, noise)
    least = float(value[0])
    value, axes = value[value > SIGNIFICANT], axes[:, value > SIGNIFICANT]
    back = noise @ axes
    return back @ (axes.T @ gradient), back * (value - 1) @ back.T, least  # without what noise adds


def in_noise(
    information: NDArray[np.float64], noise: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The information (p, p) in units of its noise (p, p): ratios (p,), rising, and axes, axes.T @ noise @ axes = 1."""
    tiny = np.finfo(float).eps * np.trace(noise) + np.finfo(float).tiny  # the noise may vanish along a combination
    ratios, axes = eigh(information, noise + tiny * np.eye(len(noise)))
    return ratios, axes


def ridged_inverse(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of the covariance of simulated features (k, k), of which some may be nearly copies of others."""
    return np.linalg.inv(covariance + RIDGE * np.diag(1 + np.diag(covariance)))
