"""What effects do to the summary of a fitted model over a grid of their parameters, and where their fits begin."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import scan, seen_at
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import ReferenceModel
from avobench.diagnosis.goodness_of_fit.regions import spots
from avobench.diagnosis.settings import FIT, SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect, Parameter
from avobench.effects.model import Model


def grid(effect: Effect) -> NDArray[np.float64]:
    """Points at which to screen an effect: (m, q)."""
    strength, *shape = effect.parameters
    sides = [side for side in (strength.high, strength.low) if side != strength.null]
    strengths = [strength.null + share * (side - strength.null) for side in sides for share in SEARCH.strengths]
    axes = [_spread(p, n) for p, n in zip(shape, _counts(shape), strict=True)]
    return np.array(list(product(strengths, *axes)))


def _counts(shape: Sequence[Parameter]) -> list[int]:
    """Grid points of each shape parameter."""
    return (
        [SEARCH.shapes] if len(shape) == 1 else [SEARCH.locations, SEARCH.widths, *[2] * (len(shape) - 2)][: len(shape)]
    )


def between(effect: Effect, points: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Points (m, q) beside these (k, q), to both sides in each shape parameter, by a share of the grid's step."""
    moved_points = []
    for j, (p, n) in enumerate(zip(effect.parameters[1:], _counts(effect.parameters[1:]), strict=True), start=1):
        for side in (share / n, -share / n):
            moved = points.copy()
            step = (p.high / p.low) ** side if p.logarithmic else side * (p.high - p.low)
            moved[:, j] = np.clip(moved[:, j] * step if p.logarithmic else moved[:, j] + step, p.low, p.high)
            moved_points.append(moved)
    return np.concatenate([points, *moved_points])


def _spread(p: Parameter, n: int) -> NDArray[np.float64]:
    share = (np.arange(n) + 0.5) / n
    return p.low * (p.high / p.low) ** share if p.logarithmic else p.low + share * (p.high - p.low)


class Sample:
    """Events of a fitted model, which all effects that are screened start from, and their summary.

    Only what an effect changes counts, so that the events' own scatter cancels.
    """

    def __init__(
        self, fit: Fit, target: Target, num_events: int, rng: np.random.Generator, around: "Around | None" = None
    ) -> None:
        self.fit, self.target, self.around, self.point = fit, target, around, fit.point
        self._simulate(num_events, rng)
        self._spots: dict[int | str | None, list[tuple[float, float, int]]] = {}

    def _simulate(self, num_events: int, rng: np.random.Generator) -> None:
        self.params = self.fit.model.from_cube(self.point)
        self.x = self.fit.model.simulate(np.tile(self.params, (num_events, 1)), rng)
        self._means: dict[tuple[int, int], NDArray[np.float64]] = {}

    def elsewhere(self, point: NDArray[np.float64], num_events: int, rng: np.random.Generator) -> "Sample":
        """Events of the same model with other parameters, a point (p,) of the unit cube."""
        other = copy(self)
        other.point = point
        other._simulate(num_events, rng)
        return other

    def changes(
        self,
        effect: Effect,
        points: NDArray[np.float64],
        events: int,
        rng: np.random.Generator,
        compared: int = SEARCH.moved_events,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What an effect at each of the points (m, q) does to the summary, whitened: (m, r).

        Also the square (m,) that the scatter of its few events adds, which makes an effect look stronger than it is. At
        each point so many events as `compared` tell how many of them the effect moves.
        """
        m = len(points)
        params = np.tile(self.params, (m * events, 1))
        phi = np.repeat(points, events, axis=0)
        model = self.fit.model.plus(effect)
        if not model.newest_acts_last:  # events from one seed are the next best
            seed = rng.integers(2**63)
            untouched = self.fit.model.simulate(params, np.random.default_rng(seed))
            changed = model.simulate(np.hstack([params, phi]), np.random.default_rng(seed))
            return self._change(untouched, changed, m, self.target.summary.mean(untouched, m), compared)
        first = True

        def simulate(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
            nonlocal first
            if not np.array_equal(theta, params[: len(theta)]):
                return self.fit.model.simulate(theta, rng)
            rows = np.arange(m * events) % len(self.x) if first else rng.integers(len(self.x), size=len(theta))
            first = False
            return self.x[rows]

        changed = effect.apply(simulate, params, phi, rng)
        untouched = self.x[np.arange(m * events) % len(self.x)]
        if (m, events) not in self._means:
            self._means[m, events] = self.target.summary.mean(untouched, m)
        return self._change(untouched, changed, m, self._means[m, events], compared)

    def _change(
        self, untouched: NDArray, changed: NDArray, m: int, means: NDArray[np.float64], compared: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What `changes` gives, from events at m points without and with an effect; the former have `means` (m, K)."""
        target, n = self.target, len(changed)
        change = target.whiten(target.summary.mean(changed, m) - means)
        some = np.linspace(0, n, m * compared, endpoint=False, dtype=int)
        moved = target.moved(untouched[some], changed[some]).reshape(m, -1).mean(axis=1)
        return change, target.num_events * m / n * target.rank * moved

    def look(
        self, effect: Effect, points: NDArray[np.float64], events: int, rng: np.random.Generator, guessed: bool
    ) -> "Look":
        """At points (m, q), with so many events each."""
        return Look(effect, points, *self.changes(effect, points, events, rng), events, guessed)

    def places(self, effect: Effect) -> NDArray[np.float64]:
        """Points (m, q) at which an effect acts where measured events and these disagree most; none without a place."""
        strength, *shape = effect.parameters
        side = strength.high if strength.high != strength.null else strength.low
        strong = strength.null + SEARCH.strengths[-1] * (side - strength.null)
        low, high = [p.low for p in shape], [p.high for p in shape]
        if effect.feature not in self._spots:
            self._spots[effect.feature] = spots(self.fit, self.target, self.x, effect.feature)
        inside = [effect.within(*spot) for spot in self._spots[effect.feature]]
        rows = [np.r_[strong, np.clip(values, low, high)] for values in inside if values is not None]
        return np.array(rows).reshape(-1, 1 + len(shape))


@dataclass(frozen=True)
class Look:
    """What one shape of an effect does to the summary, at points of its parameters."""

    effect: Effect
    points: NDArray[np.float64]
    """(m, q)"""
    change: NDArray[np.float64]
    """Of the summary, whitened (m, r)."""
    scatter: NDArray[np.float64]
    """Square that the scatter of the events adds to it (m,)."""
    events: int
    """Simulated events of each point."""
    guessed: bool
    """Whether the points were read off the data, the strength with them."""

    def expected(self, sample: "Sample", steps: int = 1) -> "Expected":
        """What fits with this effect may reach from each point, theta following."""
        strength = self.effect.parameters[0]
        reach = np.where(self.points[:, 0] > strength.null, strength.high, strength.low) - strength.null
        most = np.minimum(SEARCH.gain, reach / (self.points[:, 0] - strength.null))
        return sample.around.expected(self.change, self.scatter, None if self.guessed else most, sample.point, steps)

    def beside(self, sample: "Sample", most: int, share: float) -> NDArray[np.float64]:
        """The best points and others beside them, by a share of the grid's step: where to look again."""
        best = self.points[np.argsort(self.expected(sample, SEARCH.followed).q)[:most]]
        return best if self.guessed else between(self.effect, best, share)


@dataclass(frozen=True)
class Expected:
    """What fits with one more effect may reach, from m points of its parameters."""

    q: NDArray[np.float64]
    """Chi-squared without what simulation adds (m,)."""
    gain: NDArray[np.float64]
    """By what the strength is multiplied, as if an effect were linear in it (m,)."""
    point: NDArray[np.float64]
    """Where the parameters without the effect are then, in the unit cube (m, p)."""


class Around:
    """What Q is near a fitted model if the change by an effect is added to its surrogate."""

    def __init__(self, reference: ReferenceModel, target: Target) -> None:
        self.surrogate, self.target = reference.surrogate, target
        self._residual, self._slopes, self._bends = self.surrogate.residual(target)

    def holds(self, point: NDArray[np.float64]) -> bool:
        """Whether a point (p,) of the unit cube lies within where the model is known; theta may be far beyond."""
        return bool(np.abs(self.surrogate.design.to_t(point)).max(initial=0) < FIT.inside)

    def expected(
        self,
        change: NDArray[np.float64],
        scatter: NDArray[np.float64],
        most: NDArray[np.float64] | None,
        start: NDArray[np.float64],
        steps: int,
    ) -> Expected:
        """What is reached by Gauss-Newton `steps` of the parameters, from `start` (p,), and of the gain together.

        The gain stays between 0 and `most` (m,), or at 1 if `most` is None. `change` (m, r) is what an effect does to
        the whitened summary, and `scatter` (m,) the part of its square that comes from the scatter of events. A step
        that would leave the unit cube is taken once more along the wall.
        """
        m, p, design = len(change), len(self._slopes), self.surrogate.design
        t, gain = np.tile(np.clip(design.to_t(start), -1, 1), (m, 1)), np.ones(m)
        scatter = np.minimum(scatter, (change**2).sum(axis=1) / 2)
        lowest, reached, best = np.full(m, np.inf), gain.copy(), t.copy()
        for _ in range(steps):
            bent = np.tensordot(t, self._bends, 1)
            residual = self._residual + np.einsum("mi,mir->mr", t, self._slopes + bent) + gain[:, None] * change
            slope = np.concatenate([self._slopes + 2 * bent, change[:, None]], axis=1)
            down = np.einsum("mir,mr->mi", slope, residual)
            down[:, p] -= gain * scatter
            square = slope @ slope.transpose(0, 2, 1)
            square[:, range(p + 1), range(p + 1)] += FIT.anchor
            square[:, p, p] -= scatter
            if most is None:
                square[:, p], square[:, :, p], down[:, p] = 0, 0, 0
                square[:, p, p] = 1
            step = np.linalg.solve(square, down[..., None])[..., 0]
            u = design.centre + (t - step[:, :p]) @ design.axes.T
            outside = (u < 0) | (u > 1)
            if outside.any():
                wall = FIT.wall * outside[..., None] * design.axes
                off = FIT.wall * outside * (design.centre + t @ design.axes.T - np.clip(u, 0, 1))
                square[:, :p, :p] += wall.transpose(0, 2, 1) @ wall
                down[:, :p] += np.einsum("mi,mij->mj", off, wall)
                step = np.linalg.solve(square, down[..., None])[..., 0]
            t = design.to_t(design.to_u(np.clip(t - step[:, :p], -1, 1)))
            gain = gain - step[:, p]
            if most is not None:
                gain = np.clip(gain, 0, most)
            q = self.q(t, gain, change, scatter)
            lower = q < lowest
            lowest[lower], reached[lower], best[lower] = q[lower], gain[lower], t[lower]
        return Expected(lowest, reached, design.to_u(best))

    def q(
        self,
        t: NDArray[np.float64],
        gain: NDArray[np.float64],
        change: NDArray[np.float64],
        scatter: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Chi-squared at points t (m, p) of the design, with `gain` (m,) times a change (m, r): (m,).

        The noise of the model at its centre is taken out. What it is more elsewhere is left in: a place of which little
        is known promises nothing.
        """
        residual = self._residual + np.einsum("mi,mir->mr", t, self._slopes + np.tensordot(t, self._bends, 1))
        residual = residual + gain[:, None] * change
        noise = self.target.num_events * self.surrogate.inverse[0, 0]
        return (residual**2).sum(axis=1) - gain**2 * scatter - noise * self.target.rank


def glance(
    sample: Sample, effect: Effect, guess: NDArray[np.float64] | None, rng: np.random.Generator, effort: Effort
) -> Look:
    """A first look at one shape of an effect: at points (m, q) guessed by the measured events, or over a grid.

    Places where measured and simulated events disagree most are added.
    """
    guessed, points = guess is not None, grid(effect) if guess is None else guess
    events = effort.screen // int(np.clip(len(points), *SEARCH.points))
    return sample.look(effect, np.concatenate([points, sample.places(effect)]), events, rng, guessed)


def looked_again(sample: Sample, look: Look, rng: np.random.Generator) -> Look:
    """A look with more events at what looked best at first, and beside it, and where the events disagree."""
    finished = sample.fit.model.plus(look.effect).newest_acts_last
    events = (SEARCH.final_events if finished else SEARCH.dear_events) * look.events
    for most, share in SEARCH.looks:
        points = np.concatenate([look.beside(sample, most, share), sample.places(look.effect)])
        look = sample.look(look.effect, points, events, rng, look.guessed)
    return look


@dataclass(frozen=True)
class Start:
    """Where to begin a fit: a shape, its cube coordinates with theta, and the Q that screening expects there."""

    model: Model
    point: NDArray[np.float64]
    expected: float
    near: float
    """How far the strength may be off, in cube coordinates."""
    along: NDArray[np.float64] | float = 0.0
    """How the fit's parameters move, in cube coordinates (P,), with that of the strength."""
    half: NDArray[np.float64] | None = None
    """How far off each parameter may be, in cube coordinates (P,), where that is known."""
    slope: NDArray[np.float64] | None = None
    """What the strength does to the summary, whitened (r,), per unit of its cube coordinate, where that is known."""


def starts_of(sample: Sample, look: Look) -> list[Start]:
    """The best one or two points of a look at an effect, to add it to a fitted model there."""
    fit, strength, points = sample.fit, look.effect.parameters[0], look.points
    model, expected = fit.model.plus(look.effect), look.expected(sample, SEARCH.followed)
    order = np.argsort(expected.q)
    chosen = [order[0]]
    if points.shape[1] > 1:
        far = [i for i in order if np.abs(points[i, 1:] - points[order[0], 1:]).max() > 1e-12]
        chosen += far[:1]
    starts = []
    for i in chosen:
        phi = points[i].copy()
        phi[0] = strength.null + max(expected.gain[i], 0.05) * (phi[0] - strength.null)
        theta = expected.point[i]
        if not sample.around.holds(theta):
            shift = fit.follow(fit.residual - expected.gain[i] * look.change[i])
            theta = np.clip(fit.point + np.clip(shift, -SEARCH.stride, SEARCH.stride), 0, 1)
        point = np.concatenate([theta, model.to_cube(np.concatenate([fit.params, phi]))[fit.model.dim :]])
        step = (points[i, 0] - strength.null) / (strength.high - strength.low)
        slope = look.change[i] / step
        off = (SEARCH.guessed if look.guessed else SEARCH.rough) * model.strengths(point)[fit.model.dim]
        starts.append(Start(model, point, float(expected.q[i]), off, -fit.follow(slope), slope=slope))
    return starts


def hidden(sample: Sample, start: Start, rng: np.random.Generator, effort: Effort) -> list[Start]:
    """Starts at large strengths, to either side, of an effect that theta hides where it is weak; else none.

    Theta is searched for along a row of strengths, at each from where it was at the one before. A fit may begin where
    chi-squared is lower than at the strengths next to it.
    """
    fit, target, effect = sample.fit, sample.target, start.model.effects[-1]
    strength, p = effect.parameters[0], fit.model.dim
    of_theta, _ = np.linalg.qr(fit.jacobian[:, : fit.model.num_theta])
    free, shape = fit.projector(), start.model.from_cube(start.point)[p + 1 :]
    events = effort.fit // SEARCH.stepped
    noise = target.num_events / events * target.rank
    starts = []
    for side in [side for side in (strength.high, strength.low) if side != strength.null]:
        near, points = (
            np.array([[strength.null + share * (side - strength.null), *shape] for share in shares])
            for shares in (SEARCH.weak, SEARCH.strong)
        )
        change, scatter = sample.changes(effect, near, effort.screen // 4, rng)
        moves = (change - change @ of_theta @ of_theta.T, change)
        kept, whole = ((each**2).sum(axis=1) - scatter for each in moves)
        visible = whole > 3 * scatter * np.sqrt(2 / target.rank)
        if not (visible & (kept < SEARCH.absorbed * whole)).any():
            continue
        row, size, theta = [], (min(SEARCH.coarse_points**p, effort.scan[0] // 4), effort.scan[1]), fit.point
        for values in points:
            phi = start.model.to_cube(np.concatenate([fit.params, values]))[p:]
            point, _ = scan(start.model, target, rng, fixed=phi, around=theta, size=size)
            for _ in range(SEARCH.stepped):
                residual, _ = seen_at(start.model, point, target, rng, events)
                step = np.clip(fit.follow(residual), -SEARCH.stride, SEARCH.stride)
                theta = point[:p] = np.clip(point[:p] + step, 0, 1)
            row.append((point, float(((residual @ free) ** 2).sum()) - noise))
        places, expected = np.array([point for point, _ in row]), np.array([value for _, value in row])
        along = np.gradient(places[:, :p], places[:, p], axis=0)
        between = np.abs(np.diff(places[:, p])).mean()
        beside = np.minimum(np.r_[np.inf, expected[:-1]], np.r_[expected[1:], np.inf])
        lowest = [i for i in np.argsort(expected) if expected[i] < beside[i]]
        starts += [Start(start.model, places[i], expected[i], between, along[i]) for i in lowest[: SEARCH.modes]]
    return starts
