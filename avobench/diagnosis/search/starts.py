"""Where fits of an effect begin: its shapes are screened from one set of events, or searched with theta."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.scan import scan
from avobench.diagnosis.gates.regions import spots
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect, Parameter
from avobench.effects.model import Model

STRENGTHS = (0.001, 0.005, 0.02, 0.08, 0.25, 0.7)
"""Of the range of a strength; between them the effect is taken as linear."""
MOVED_EVENTS = 200
"""Of each point, from which the share of events that change bins is taken."""
LOCATIONS = 12
"""Grid points of a location: what is narrower than a twelfth of the range is found by `Sample.places`."""
SHAPES = 8
"""Grid points of a single shape parameter."""
WIDTHS = 3
"""Grid points of a width beside a location: narrow, middling and wide."""
FINALISTS = 6
"""Points of the grid that are looked at again, with more events: the first look is too noisy to choose one."""
FINAL_EVENTS = 5
"""Times the events of the first look, for the second: as many again in all, since a grid has some 100 points."""
CLOSER = 3
"""Of these, those that are looked at beside once more: an edge must be met within a fit's first design."""
LOOKS = (1 / 2, 1 / 4, None)
"""How far beside the best points of a look the next one looks, in steps of the grid."""
ABSORBED = 0.3
"""Share of an effect's signal below which theta hides it, so that it is also looked for where it is strong. Chosen
by trial."""
NEAR = np.array([0.05, 0.1])
"""Strengths, as shares of the range, at which it is found out whether theta hides an effect: weak, but above noise."""
FAR = np.linspace(0.1, 1, 10)
"""Strengths, as shares of the range, at which an effect that theta hides is looked for: the rest of the range."""
MODES = 2
"""Places at which a fit begins that were found in this way, at most, to either side."""
COARSE = 10
"""Points of theta a parameter, in each search for it beside a strength; the last strength's theta is not far."""
FOLLOWED = 2
"""Linear steps of theta that follow such a search."""
ROUGH = 0.5
"""How far a strength from a grid may be off, as a share of it: the steps of STRENGTHS are factors of three to five."""
GUESSED = 0.003
"""How far a strength that is read off the data may be off, as a share of it: an edge, known to about one event."""
GAIN = 3.0
"""How far a strength may be moved from its grid point by linearity: to about the next point of STRENGTHS."""


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


def grid(effect: Effect) -> NDArray[np.float64]:
    """Points at which to screen an effect: (m, q)."""
    strength, *shape = effect.parameters
    sides = [side for side in (strength.high, strength.low) if side != strength.null]
    strengths = [strength.null + share * (side - strength.null) for side in sides for share in STRENGTHS]
    axes = [_spread(p, n) for p, n in zip(shape, _counts(shape), strict=True)]
    return np.array(list(product(strengths, *axes)))


def _counts(shape: Sequence[Parameter]) -> list[int]:
    """Grid points of each shape parameter."""
    return [SHAPES] if len(shape) == 1 else [LOCATIONS, WIDTHS, *[2] * (len(shape) - 2)][: len(shape)]


def between(effect: Effect, points: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Points (m, q) beside these (k, q), to both sides in each shape parameter, by a share of the grid's step."""
    found = []
    for j, (p, n) in enumerate(zip(effect.parameters[1:], _counts(effect.parameters[1:]), strict=True), start=1):
        for side in (share / n, -share / n):
            moved = points.copy()
            step = (p.high / p.low) ** side if p.logarithmic else side * (p.high - p.low)
            moved[:, j] = np.clip(moved[:, j] * step if p.logarithmic else moved[:, j] + step, p.low, p.high)
            found.append(moved)
    return np.concatenate([points, *found])


def _spread(p: Parameter, n: int) -> NDArray[np.float64]:
    share = (np.arange(n) + 0.5) / n
    return p.low * (p.high / p.low) ** share if p.logarithmic else p.low + share * (p.high - p.low)


class Sample:
    """Events of a fitted model, which all effects that are screened start from, and their summary.

    Only what an effect changes counts, so that the events' own scatter cancels.
    """

    def __init__(self, fit: Fit, target: Target, num_events: int, rng: np.random.Generator) -> None:
        self.fit, self.target = fit, target
        self.x = fit.model.simulate(np.tile(fit.params, (num_events, 1)), rng)
        self._means: dict[tuple[int, int], NDArray[np.float64]] = {}
        self._spots: dict[int | str | None, list[tuple[float, float, int]]] = {}

    def changes(
        self, effect: Effect, points: NDArray[np.float64], events: int, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What an effect at each of the points (m, q) does to the summary, whitened: (m, r).

        Also the square (m,) that the scatter of its few events adds, which makes an effect look stronger than it is.
        """
        m = len(points)
        params = np.tile(self.fit.params, (m * events, 1))
        phi = np.repeat(points, events, axis=0)
        model = self.fit.model.plus(effect)
        if not model.newest_acts_last:  # events from one seed are the next best
            seed = rng.integers(2**63)
            untouched = self.fit.model.simulate(params, np.random.default_rng(seed))
            changed = model.simulate(np.hstack([params, phi]), np.random.default_rng(seed))
            return self._change(untouched, changed, m, self.target.summary.mean(untouched, m))
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
        return self._change(untouched, changed, m, self._means[m, events])

    def _change(
        self, untouched: NDArray, changed: NDArray, m: int, means: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What `changes` gives, from events at m points without and with an effect; the former have `means` (m, K)."""
        target, n = self.target, len(changed)
        change = target.whiten(target.summary.mean(changed, m) - means)
        some = np.linspace(0, n, m * MOVED_EVENTS, endpoint=False, dtype=int)
        moved = target.moved(untouched[some], changed[some]).reshape(m, -1).mean(axis=1)
        return change, target.num_events * m / n * target.rank * moved

    def places(self, effect: Effect) -> NDArray[np.float64]:
        """Points (m, q) at which an effect acts where measured events and these disagree most; none without a place."""
        strength, *shape = effect.parameters
        side = strength.high if strength.high != strength.null else strength.low
        strong = strength.null + STRENGTHS[-1] * (side - strength.null)
        low, high = [p.low for p in shape], [p.high for p in shape]
        if effect.feature not in self._spots:
            self._spots[effect.feature] = spots(self.fit, self.target, self.x, effect.feature)
        inside = [effect.within(*spot) for spot in self._spots[effect.feature]]
        rows = [np.r_[strong, np.clip(values, low, high)] for values in inside if values is not None]
        return np.array(rows).reshape(-1, 1 + len(shape))


def screen(sample: Sample, effect: Effect, x: NDArray, rng: np.random.Generator, effort: Effort) -> list[Start]:
    """The best one or two grid points of one shape of an effect added to a fitted model.

    Theta follows linearly, and the strength is moved to where a linear effect would fit best.
    """
    fit = sample.fit
    model = fit.model.plus(effect)
    guesses = effect.guess(x)
    if guesses is not None and len(guesses) == 0:
        return []
    points = grid(effect) if guesses is None else guesses
    q = points.shape[1]
    strength = effect.parameters[0]
    events = max(effort.screen // len(points), effort.screen // 50)
    free = fit.projector()
    left = fit.residual @ free
    for number, share in zip((events, FINAL_EVENTS * events, FINAL_EVENTS * events), LOOKS, strict=True):
        change, scatter = sample.changes(effect, points, number, rng)
        moved = change @ free
        size = np.maximum((moved**2).sum(axis=1) - scatter, 0.5 * (moved**2).sum(axis=1)) + 1e-9
        along = moved @ left
        gain = np.clip(along / size, 0, GAIN)
        reach = np.where(points[:, 0] > strength.null, strength.high, strength.low) - strength.null
        gain = np.minimum(gain, reach / (points[:, 0] - strength.null))
        if guesses is not None:
            gain = np.ones_like(gain)
        expected = left @ left - 2 * gain * along + gain**2 * size
        if share is None:
            break
        # What looks best is looked at with more events, and beside it; and where the events disagree.
        best = points[np.argsort(expected)[: FINALISTS if number == events else CLOSER]]
        points = best if guesses is not None else between(effect, best, share)
        points = np.concatenate([points, sample.places(effect)])
    order = np.argsort(expected)
    chosen = [order[0]]
    if q > 1:
        far = [i for i in order if np.abs(points[i, 1:] - points[order[0], 1:]).max() > 1e-12]
        chosen += far[:1]
    starts = []
    for i in chosen:
        phi = points[i].copy()
        phi[0] = strength.null + max(gain[i], 0.05) * (phi[0] - strength.null)
        shift = fit.follow(fit.residual - gain[i] * change[i])
        theta = np.clip(fit.point + np.clip(shift, -0.1, 0.1), 0, 1)
        point = np.concatenate([theta, model.to_cube(np.concatenate([fit.params, phi]))[fit.model.dim :]])
        step = (points[i, 0] - strength.null) / (strength.high - strength.low)
        along = -fit.follow(change[i]) / step
        off = ROUGH if guesses is None else GUESSED
        starts.append(Start(model, point, float(expected[i]), off * model.strengths(point)[fit.model.dim], along))
    return starts


def hidden(sample: Sample, start: Start, rng: np.random.Generator, effort: Effort) -> list[Start]:
    """Starts at large strengths, to either side, of an effect whose small strength theta hides; else none.

    Theta is searched for at each of a row of strengths, near where it was at the one before; where it then fits better
    than beside it, a fit may begin.
    """
    fit, target, effect = sample.fit, sample.target, start.model.effects[-1]
    strength, p = effect.parameters[0], fit.model.dim
    of_theta, _ = np.linalg.qr(fit.jacobian[:, : fit.model.num_theta])
    free, shape = fit.projector(), start.model.from_cube(start.point)[p + 1 :]
    starts = []
    for side in [side for side in (strength.high, strength.low) if side != strength.null]:
        near, points = (
            np.array([[strength.null + share * (side - strength.null), *shape] for share in shares])
            for shares in (NEAR, FAR)
        )
        change, scatter = sample.changes(effect, near, effort.screen // 4, rng)
        moves = (change - change @ of_theta @ of_theta.T, change)
        kept, whole = ((each**2).sum(axis=1) - scatter for each in moves)
        seen = whole > 3 * scatter * np.sqrt(2 / target.rank)
        if not (seen & (kept < ABSORBED * whole)).any():
            continue
        row, size, theta = [], (min(COARSE**p, effort.scan[0] // 4), effort.scan[1]), fit.point
        for values in points:
            phi = start.model.to_cube(np.concatenate([fit.params, values]))[p:]
            point, _ = scan(start.model, target, rng, fixed=phi, around=theta, size=size)
            for _ in range(FOLLOWED):
                x = start.model.simulate(np.tile(start.model.from_cube(point), (effort.fit // FOLLOWED, 1)), rng)
                left = target.whiten(target.mean - target.summary.mean(x)[0])
                theta = point[:p] = np.clip(point[:p] + np.clip(fit.follow(left), -0.1, 0.1), 0, 1)
            noise = target.num_events / len(x) * target.rank
            row.append((point, float(((left @ free) ** 2).sum()) - noise))
        places, expected = np.array([point for point, _ in row]), np.array([value for _, value in row])
        along = np.gradient(places[:, :p], places[:, p], axis=0)
        between = np.abs(np.diff(places[:, p])).mean()
        beside = np.minimum(np.r_[np.inf, expected[:-1]], np.r_[expected[1:], np.inf])
        lowest = [i for i in np.argsort(expected) if expected[i] < beside[i]]
        starts += [Start(start.model, places[i], expected[i], between, along[i]) for i in lowest[:MODES]]
    return starts
