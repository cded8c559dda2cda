"""Fits of a black-box simulator to a summary, by a quadratic surrogate."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import chi2

from avobench.diagnosis.fit.known import Base
from avobench.diagnosis.fit.surrogate import CLEAR, SHRINK, Design, Surrogate, basis_slope, quadratic, surrogate
from avobench.diagnosis.summary.target import Target
from avobench.effects.model import Model

BASE_SIGMAS = 25.0
"""How far around a fit its model is made known, in standard errors."""
MIN_SIGMAS = 4.0
"""Half the width of a design, in standard errors, at least."""
SLOPE_NOISE = 0.2
"""Standard error of a slope over a design, in units of the slope that is one standard error of the parameter."""
WORSE = 2.0
"""Standard errors by which the end of a step must be worse than its start, to be given up."""
MORE_ROUNDS = 2
"""Of a descent that would end at a promise."""
ANCHOR = 0.1
"""What moving to the edge of the design costs in Q: it keeps parameters still that the data say nothing about."""
POLISHES = 4
"""Rounds of a polish, at most."""
WALL = 1e4
"""Slope of the penalty that keeps a fit within the unit cube, in standard errors."""
IDENTIFIED = 5.0
"""A direction is identified if moving across its range changes the summary by so many standard errors."""
INSIDE = 0.9
"""Of a design: a minimum further out may lie beyond it."""
SEARCHED, LESS = 0.2, 10
"""How far from where it may be, in unit coordinates, a point is looked for; with how much fewer events it is seen where
that is hopeless."""


@dataclass(frozen=True)
class Fit:
    """The best parameters of a model for a target."""

    model: Model
    unit: NDArray[np.float64]
    """Parameters in the unit cube (P,)."""
    residual: NDArray[np.float64]
    """Measured minus simulated mean, whitened: (r,)."""
    jacobian: NDArray[np.float64]
    """Derivative of the simulated mean, whitened, with respect to the unit coordinates: (r, P)."""
    jacobian_noise: NDArray[np.float64]
    """What simulation adds to jacobian^T jacobian: (P, P)."""
    slope_error: float
    """Of a slope by simulation, all summaries taken together, over the design: about sqrt(6 r N / n)."""
    noise: float
    """Variance that simulation adds, in units of that of the measurement."""
    predicted: NDArray[np.float64]
    """Simulated mean (K,)."""
    num_events: int
    """Simulated for it."""
    design: Design
    """Of the surrogate that the fit was made with."""

    @property
    def params(self) -> NDArray[np.float64]:
        """(P,)"""
        return self.model.from_unit(self.unit)

    @property
    def q(self) -> float:
        """N r^T C^+ r, divided by what simulation adds to its variance."""
        return float(self.residual @ self.residual) / (1 + self.noise)

    @cached_property
    def _directions(self) -> tuple[NDArray[np.float64], ...]:
        """Directions of the parameters with the squared slope of the summary along each, its scatter by simulation, and
        the squared length of their whole range: (P, P), and (P,) thrice.

        The noise of the slopes adds to their square, the more the more summaries there are. It is taken out, in the
        coordinates of the design, where it is much the same in all directions.
        """
        axes = self.design.axes
        slopes, noise = self.jacobian @ axes, axes.T @ self.jacobian_noise @ axes
        values, vectors = np.linalg.eigh(slopes.T @ slopes - noise)
        by_chance = np.sqrt(2 / max(len(self.residual), 1)) * np.einsum("ik,ij,jk->k", vectors, noise, vectors)
        back = vectors.T @ np.linalg.inv(axes)
        whole_range = 1 / np.maximum((np.linalg.inv(back) ** 2).sum(axis=0), 1e-30)
        return back, values, by_chance, whole_range

    @cached_property
    def information(self) -> tuple[NDArray[np.float64], int]:
        """Fisher information in unit coordinates (P, P), and its rank: how many directions the data identify.

        A direction counts only if its slope stands out of the simulation's noise.
        """
        back, values, by_chance, whole_range = self._directions
        seen = (values > CLEAR * by_chance) & (values * whole_range > IDENTIFIED**2)
        return (back[seen].T * values[seen]) @ back[seen] / (1 + self.noise), int(seen.sum())

    @property
    def undecided(self) -> bool:
        """Whether a direction may be identified, but its slope does not stand out of the simulation's noise."""
        _, values, by_chance, whole_range = self._directions
        return bool(((values < CLEAR * by_chance) & ((values + CLEAR * by_chance) * whole_range > IDENTIFIED**2)).any())

    @property
    def gap(self) -> float:
        """An unbiased estimate of the Q that endless simulation would give, to compare models with."""
        return float(self.residual @ self.residual) - self.noise * self.dof

    @property
    def gap_error(self) -> float:
        """Standard error of `gap` by simulation."""
        return float(np.sqrt(2 * self.dof * self.noise**2 + 4 * max(self.gap, self.dof) * self.noise))

    @property
    def num_identified(self) -> int:
        return self.information[1]

    @property
    def dof(self) -> int:
        return len(self.residual) - self.num_identified

    @property
    def p_value(self) -> float:
        """Of `q`; 1 where as many parameters are fitted as there are bins."""
        return float(chi2.sf(self.q, self.dof)) if self.dof else 1.0

    @cached_property
    def unit_covariance(self) -> NDArray[np.float64]:
        """Of the unit coordinates, (P, P); where the data say less than the range, that of the range."""
        values, vectors = np.linalg.eigh(self.information[0])
        return (vectors / np.maximum(values, 12)) @ vectors.T

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard errors of the parameters (P,), linearised."""
        spread = np.sqrt(np.diag(self.unit_covariance))
        above, below = (self.model.from_unit(np.clip(self.unit + s * spread, 0, 1)) for s in (1, -1))
        moved = np.clip(self.unit + spread, 0, 1) - np.clip(self.unit - spread, 0, 1)
        return (above - below) / np.maximum(moved, 1e-12) * spread

    @property
    def at_bound(self) -> NDArray[np.int_]:
        """1 for parameters that ended within half a thousandth of the upper end of their range, -1 for the lower."""
        return (self.unit > 1 - 5e-4).astype(int) - (self.unit < 5e-4)

    def follow(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far the parameters move, in unit coordinates (P,), if the whitened mean of the data moves by `change`."""
        return np.linalg.pinv(self.information[0], hermitian=True) @ self.jacobian.T @ change / (1 + self.noise)

    def projector(self) -> NDArray[np.float64]:
        """Projects whitened means (r, r) onto what no change of the parameters can make."""
        _, vectors = np.linalg.eigh(self.information[0])
        reach, _ = np.linalg.qr(self.jacobian @ vectors[:, self.model.dim - self.num_identified :])
        return np.eye(len(self.residual)) - reach @ reach.T

    def next_design(self, least: float = 0.0, ratio: float = 1.0) -> Design:
        """A design around the fit for `ratio` times its events, with `least` as in `around`."""
        return self.around(max(MIN_SIGMAS, self.slope_error / np.sqrt(ratio) / SLOPE_NOISE), least)

    def known(self, target: Target, num_events: int, rng: np.random.Generator) -> Base:
        """The model, made known with so many events over a wide design around the fit."""
        make = partial(surrogate, self.model, target, num_events=num_events, rng=rng)
        return Base(self.model, quadratic(make, self.around(BASE_SIGMAS), target))

    def around(self, sigmas: float, least: float = 0.0) -> Design:
        """A design along the directions of the Fisher information, so many standard errors wide to either side.

        At most as wide as the model can bear, see `Model.reach`, and `least` of that at least.
        """
        reach = self.model.reach(self.unit)
        values, vectors = np.linalg.eigh(self.information[0] * np.outer(reach, reach))
        half = np.clip(sigmas / np.sqrt(np.maximum(values, 1e-9)), max(least, 1e-4), 1)
        return Design(self.unit, reach[:, None] * vectors * half)


def fit_at(model: Model, s: Surrogate, target: Target, u: NDArray[np.float64]) -> Fit:
    """What a surrogate says of the point u (P,) of its design."""
    mean, slope = s.at(u)
    back, steps = np.linalg.inv(s.design.axes), basis_slope(s.design.to_t(u))
    return Fit(
        model=model,
        unit=u,
        residual=target.whiten(target.mean - mean),
        jacobian=target.whiten(slope).T,
        jacobian_noise=target.num_events * target.rank * back.T @ steps.T @ s.inverse @ steps @ back,
        slope_error=float(np.sqrt(target.num_events * target.rank * np.diag(s.inverse)[1 : model.dim + 1].mean())),
        noise=target.num_events * s.variance_at(u),
        predicted=mean,
        num_events=s.num_events,
        design=s.design,
    )


def minimise(model: Model, s: Surrogate, target: Target) -> Fit:
    """The point of the design where the surrogate comes closest to the target.

    The noise of the coefficients adds to the distance, the more the further from the centre. That is left in: where the
    slopes stand out of it, as `next_design` sees to, it hardly matters, and where they do not, nothing should move.
    """
    terms, wanted = target.whiten(s.coefficients), target.whiten(target.mean)
    axes, centre, p = s.design.axes, s.design.centre, model.dim

    def outside(t: NDArray[np.float64]) -> NDArray[np.float64]:
        u = centre + axes @ t
        return u - np.clip(u, 0, 1)

    bends = np.zeros((p, p, terms.shape[1]))  # of the products of t, half for each order of the two factors
    i, j = np.triu_indices(p)
    bends[i, j] += terms[p + 1 :] / 2
    bends[j, i] += terms[p + 1 :] / 2

    def residual(t: NDArray[np.float64]) -> NDArray[np.float64]:
        left = terms[0] - wanted + t @ (terms[1 : p + 1] + np.tensordot(t, bends, 1))
        return np.concatenate([left, np.sqrt(ANCHOR) * t, WALL * outside(t)])

    def slope(t: NDArray[np.float64]) -> NDArray[np.float64]:
        wall = WALL * (outside(t) != 0)[:, None] * axes
        steps = terms[1 : p + 1] + 2 * np.tensordot(t, bends, 1)
        return np.concatenate([steps.T, np.sqrt(ANCHOR) * np.eye(p), wall])

    t = least_squares(residual, np.zeros(p), slope, bounds=(-1, 1), method="dogbox", max_nfev=60).x
    return fit_at(model, s, target, s.design.to_u(t))


def refine(
    model: Model,
    target: Target,
    start: NDArray[np.float64],
    half: NDArray[np.float64] | float,
    rng: np.random.Generator,
    *,
    num_events: int,
    max_rounds: int = 10,
    base: Base | None = None,
) -> Fit:
    """Fit from `start` (P,) in the unit cube, with designs that begin with half-width `half` and shrink.

    `num_events` are simulated for each. `base` is the model without its last effect, if that is known well.
    """
    half = np.broadcast_to(half, model.dim).astype(float)
    design = Design.box(start, half) if base is None else base.design(start, half)
    return descend(model, target, design, rng, num_events, max_rounds, base)


def descend(
    model: Model,
    target: Target,
    design: Design,
    rng: np.random.Generator,
    num_events: int,
    max_rounds: int,
    base: Base | None = None,
) -> Fit:
    """Go from design to design, each around the minimum of the last one's surrogate, until it stands still.

    What a surrogate promises is not believed: with many coefficients it follows the data by chance. But where the last
    of `max_rounds` promises much, MORE_ROUNDS at most see whether it is true. Where simulation at the end of a step is
    clearly worse than at its start, the step is taken back and tried in a narrower design. The start is then simulated
    anew: a value that was low by chance would keep every step away.

    Designs are as narrow as it takes for a quadratic to do. An effect with hard edges is none over a wide one.
    """
    best, lowest, gap, error = None, None, np.inf, 0.0
    scale = float(np.abs(design.axes / model.reach(design.centre)[:, None]).max())
    rounds, promises_much, narrow = 0, False, 1.0
    while rounds < max_rounds + (MORE_ROUNDS if promises_much else 0):
        rounds += 1
        inside = None if base is None else base.within(design)
        make = partial(surrogate if inside is None else base.extended, model, target)
        wanted = inside or design
        s = quadratic(partial(make, num_events=num_events, rng=rng), wanted, target)
        narrow *= np.linalg.norm(s.design.axes) / np.linalg.norm(wanted.axes)
        here, its_error = s.gap_at_centre(target)
        if here > gap + WORSE * np.hypot(error, its_error):
            scale /= SHRINK
            design = Design(best.unit, best.next_design(scale).axes * narrow / SHRINK)
            gap = np.inf
            continue
        best, gap, error = fit_at(model, s, target, s.design.centre), here, its_error
        lowest = best if lowest is None else min(lowest, best, key=lambda fit: fit.gap + fit.gap_error)
        step = minimise(model, s, target)
        moved = np.abs(s.design.to_t(step.unit)).max()
        design = step.next_design(scale if moved > 0.9 else scale / SHRINK)
        promises_much = step.gap < here - WORSE * its_error
        if moved < 0.3 and not promises_much and np.allclose(design.axes, step.next_design().axes):
            best = step
            break
        # A curved model is not known to be as sharp as its slope at a distance says.
        scale, narrow = (scale, min(narrow * SHRINK, 1.0)) if moved > 0.9 else (scale / SHRINK, narrow)
        design = Design(design.centre, design.axes * narrow)
    # The lowest of many values is low by chance; only a clear difference counts.
    return lowest if lowest.gap + lowest.gap_error < best.gap - best.gap_error else best


def polish(
    fit: Fit,
    target: Target,
    rng: np.random.Generator,
    num_events: int,
    rounds: int = POLISHES,
    base: Base | None = None,
) -> Fit:
    """The same fit with many events in small designs around it."""
    design = fit.next_design(ratio=max(num_events / fit.num_events, 1))
    return descend(fit.model, target, design, rng, num_events, rounds, base)


def settled(fit: Fit, target: Target, rng: np.random.Generator, num_events: int, ratios: tuple[float, ...]) -> Fit:
    """The same fit with one more step from many events, and more until it is plain which directions the data identify.

    The degrees of freedom that a fit takes up, and the errors that are quoted, hang on that. A step to the edge of its
    design, or one that promises much, only says where to look next: slopes at an edge are hardly known, and a promise
    may be none. No `Base`: a polynomial over so wide a design is not exact enough where the data say nearly nothing.
    """
    centre, best = fit.unit, None
    for ratio in ratios:
        more = int(ratio * num_events)
        axes = fit.next_design(ratio=more / fit.num_events).axes
        make = partial(surrogate, fit.model, target, num_events=more, rng=rng)
        s = quadratic(make, Design(centre, axes), target)
        here, step = fit_at(fit.model, s, target, s.design.centre), minimise(fit.model, s, target)
        at_edge = np.abs(s.design.to_t(step.unit)).max() > INSIDE
        believed = not at_edge and step.gap > here.gap - WORSE * here.gap_error
        fit, centre = step if believed else here, step.unit
        if best is None or fit.gap < best.gap + WORSE * np.hypot(fit.gap_error, best.gap_error):
            best = fit
        if believed and not best.undecided:
            break
    return best


def scan(
    model: Model,
    target: Target,
    rng: np.random.Generator,
    *,
    fixed: NDArray[np.float64] | None = None,
    around: NDArray[np.float64] | None = None,
    size: tuple[int, int] = (200, 300),
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A point (P,) of the unit cube near the best, and how near in each coordinate that was searched, from three
    searches, each around the last best.

    `fixed` are values of the last coordinates, which are then not searched; the others within SEARCHED of `around`, if
    that is given, and else everywhere. `size` is the number of points of a search and of events at each. As far as
    points lie that are not clearly worse than the best, it may be off.
    """
    points, events = size
    fixed = np.empty(0) if fixed is None else fixed
    p = model.dim - len(fixed)

    def gaps(u: NDArray[np.float64], events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        params = model.from_unit(np.hstack([u, np.tile(fixed, (len(u), 1))]))
        means = target.summary.mean(model.simulate(np.repeat(params, events, axis=0), rng), len(u))
        q, noise = (target.whiten(target.mean - means) ** 2).sum(axis=1), target.num_events / events
        return q, np.sqrt(2 * target.rank * noise**2 + 4 * q * noise)

    centre, half = (np.full(p, 0.5), np.full(p, 0.5)) if around is None else (around, np.full(p, SEARCHED))
    for _ in range(3):
        u = rng.uniform(np.maximum(centre - half, 0), np.minimum(centre + half, 1), (points, p))
        q, error = gaps(u, max(events // LESS, 1))
        u = u[q - q.min() <= CLEAR * error]
        q, error = gaps(u, events)
        centre, alike = u[q.argmin()], u[q - q.min() <= error]
        half = np.maximum(half * 3 * points ** (-1 / p), np.abs(alike - centre).max(axis=0))
    return np.concatenate([centre, fixed]), half
