"""What effects do to the summary of a fitted model, over a grid of their parameters.

Each shape is looked at a few times. What it does hardly depends on which other effects a model has, so that a look
serves beside others too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.goodness_of_fit.regions import spots
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect, Parameter

STRENGTHS = (0.001, 0.005, 0.02, 0.08, 0.25, 0.7)
"""Of the range of a strength; between them the effect is taken as linear."""
MOVED_EVENTS = 100
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
LOOKS = (1 / 2, 1 / 4)
"""How far beside the best points of a look the next one looks, in steps of the grid."""
GAIN = 3.0
"""How far a strength may be moved from its grid point by linearity: to about the next point of STRENGTHS."""


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

    def look(
        self, effect: Effect, points: NDArray[np.float64], events: int, rng: np.random.Generator, guessed: bool
    ) -> "Look":
        """At points (m, q), with so many events each."""
        return Look(effect, points, *self.changes(effect, points, events, rng), events, guessed)

    def closer(self, look: "Look", most: int, share: float, events: int, rng: np.random.Generator) -> "Look":
        """A look at what looked best, beside it, and where measured events and these disagree."""
        points = np.concatenate([look.beside(self.fit, most, share), self.places(look.effect)])
        return self.look(look.effect, points, events, rng, look.guessed)

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
    """Of each point."""
    guessed: bool
    """Whether the points were read off the data, the strength with them."""

    def expected(self, fit: Fit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Q of a fit with this effect added, theta following linearly, at each point: (m,).

        Also by what its strength is then multiplied, to where a linear effect would fit best: (m,).
        """
        strength, reach = self.effect.parameters[0], fit.reach
        moved, left = (each - (each @ reach) @ reach.T for each in (self.change, fit.residual))
        size = np.maximum((moved**2).sum(axis=1) - self.scatter, 0.5 * (moved**2).sum(axis=1)) + 1e-9
        along = moved @ left
        gain = np.clip(along / size, 0, GAIN)
        reach = np.where(self.points[:, 0] > strength.null, strength.high, strength.low) - strength.null
        gain = np.minimum(gain, reach / (self.points[:, 0] - strength.null))
        if self.guessed:
            gain = np.ones_like(gain)
        return left @ left - 2 * gain * along + gain**2 * size, gain

    def best(self, fit: Fit, most: int) -> NDArray[np.float64]:
        """The points (k, q) that look best."""
        return self.points[np.argsort(self.expected(fit)[0])[:most]]

    def beside(self, fit: Fit, most: int, share: float) -> NDArray[np.float64]:
        """The best points and others beside them, by a share of the grid's step: where to look again."""
        best = self.best(fit, most)
        return best if self.guessed else between(self.effect, best, share)


def glance(sample: Sample, effect: Effect, x: NDArray, rng: np.random.Generator, effort: Effort) -> Look | None:
    """A first look at one shape of an effect, over a grid and where measured events x (N, d) and others disagree.

    None where the measured events rule it out.
    """
    points = effect.guess(x)
    guessed = points is not None
    if guessed and len(points) == 0:
        return None
    points = points if guessed else grid(effect)
    events = max(effort.screen // len(points), effort.screen // 50)
    return sample.look(effect, np.concatenate([points, sample.places(effect)]), events, rng, guessed)


def closer(sample: Sample, look: Look, rng: np.random.Generator) -> Look:
    """A look with more events at what looked best at first, and beside it, and where the events disagree."""
    events = FINAL_EVENTS * look.events
    second = sample.closer(look, FINALISTS, LOOKS[0], events, rng)
    return sample.closer(second, CLOSER, LOOKS[1], events, rng)
