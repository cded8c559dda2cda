"""A simulator with effects added to it, as one simulator with more parameters."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from avobench.effects import Effect
from avobench.effects.bank import Bank
from avobench.effects.pool import Alter, Pool
from avobench.tasks import Task
from avobench.tasks.sample import SampleTask

WIDEST = 0.1
"""Share of a parameter's range over which the mean of events is about quadratic, at most."""
SPACINGS = 4
"""Spacings of the thetas of a sample, to either side, over which a slope is looked for: it needs several of them."""
LEAST_STRENGTH = 0.003
"""Least such share for a small strength: below, a step is lost in the noise of the simulation."""
AT_ONCE = 100_000
"""Events simulated at a time, to bound memory."""
Source = Callable[..., NDArray]
"""theta (n, p), rng and, of a task that generates something first, what alters that -> (n, d)"""


@dataclass(frozen=True)
class Model:
    """A task and effects in the order in which they were added; parameters are theta and then their phi.

    Effects act one after the other, those of an earlier stage first. `events` stands for the simulator.
    """

    task: Task
    effects: tuple[Effect, ...] = ()
    events: Bank | Source | None = field(default=None, compare=False)
    stretch: tuple[float, ...] = ()
    """Factor by which the upper bound of each effect's strength is raised; 1 where it is not."""

    def plus(self, effect: Effect) -> "Model":
        stretch = (*self.stretch, 1.0) if self.stretch else ()
        return replace(self, effects=(*self.effects, effect), stretch=stretch)

    def minus(self, k: int) -> "Model":
        stretch = self.stretch[:k] + self.stretch[k + 1 :]
        return replace(self, effects=self.effects[:k] + self.effects[k + 1 :], stretch=stretch)

    def columns(self, k: int) -> slice:
        """Where the parameters of the k-th effect stand."""
        start = self.num_theta + sum(len(effect.parameters) for effect in self.effects[:k])
        return slice(start, start + len(self.effects[k].parameters))

    @cached_property
    def low(self) -> NDArray[np.float64]:
        """(P,)"""
        return np.array([*self.task.support.low, *(p.low for e in self.effects for p in e.parameters)])

    @cached_property
    def high(self) -> NDArray[np.float64]:
        """(P,)"""
        high = list(self.task.support.high)
        for effect, stretch in zip(self.effects, self.stretch or (1.0,) * len(self.effects), strict=True):
            strength, *rest = effect.parameters
            high += [strength.high * stretch, *(p.high for p in rest)]
        return np.array(high)

    @cached_property
    def logarithmic(self) -> NDArray[np.bool_]:
        """(P,)"""
        return np.array([False] * self.num_theta + [p.logarithmic for e in self.effects for p in e.parameters])

    @cached_property
    def units(self) -> tuple[str, ...]:
        """(P,)"""
        units = list(self.task.parameter_units)
        for effect in self.effects:
            units += [effect.unit(p, self.task.feature_units) for p in effect.parameters]
        return tuple(units)

    @property
    def at_once(self) -> int:
        """How many events are to be simulated at a time: of a pool as many as it holds, so that none comes twice."""
        return self.events.size if isinstance(self.events, Pool) else AT_ONCE

    @property
    def num_theta(self) -> int:
        return len(self.task.parameter_names)

    @property
    def dim(self) -> int:
        return len(self.low)

    def reach(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far from a point (P,) of the unit cube the mean of events is about quadratic, at most: (P,)."""
        reach = np.full(self.dim, WIDEST)
        if isinstance(self.task, SampleTask) and self.num_theta:
            reach[: self.num_theta] = np.clip(SPACINGS * self.task.spacing, WIDEST, 1)
        for at, strength in self.strengths(unit).items():
            reach[at] = np.clip(strength, LEAST_STRENGTH, WIDEST)
        return reach

    @property
    def nulls(self) -> dict[int, float]:
        """Where in the unit cube each effect is none, by the column of its strength."""
        strengths = {self.columns(k).start: effect.parameters[0] for k, effect in enumerate(self.effects)}
        return {at: float((p.null - self.low[at]) / (self.high[at] - self.low[at])) for at, p in strengths.items()}

    def strengths(self, unit: NDArray[np.float64]) -> dict[int, float]:
        """How far a point (P,) of the unit cube is from each effect's null value, by the column of its strength."""
        return {at: float(abs(unit[at] - null)) for at, null in self.nulls.items()}

    def from_cube(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """Parameters from the unit cube, logarithmic where that is their scale: (n, P) -> (n, P)."""
        params = self.low + u * (self.high - self.low)
        columns = np.flatnonzero(self.logarithmic)
        if len(columns):
            low, high = self.low[columns], self.high[columns]
            params[..., columns] = low * (high / low) ** u[..., columns]
        # Rounding may leave the bounds, which a simulator need not bear: 0.3 + 1 * (0.9 - 0.3) is more than 0.9.
        return np.clip(params, self.low, self.high)

    def to_cube(self, params: NDArray[np.float64]) -> NDArray[np.float64]:
        """The inverse of `from_cube`."""
        u = (params - self.low) / (self.high - self.low)
        columns = np.flatnonzero(self.logarithmic)
        low, high = self.low[columns], self.high[columns]
        u[..., columns] = np.log(params[..., columns] / low) / np.log(high / low)
        return u

    def allowed(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The nearest points of the unit cube at which the simulator works: (P,) or (n, P), the same shape back."""
        u, p, region = np.clip(u, 0, 1), self.num_theta, getattr(self.task, "region", None)
        if region is not None:
            low, width = self.low[:p], self.high[:p] - self.low[:p]
            theta = low + u[..., :p] * width
            u[..., :p] = (region.within(theta.reshape(-1, p)).reshape(theta.shape) - low) / width
        return u

    def source(self) -> Source:
        return self.events.session() if isinstance(self.events, Bank) else self.events or self.task.simulate

    def simulate(self, params: NDArray[np.float64], rng: np.random.Generator, source: Source | None = None) -> NDArray:
        """One event per row, from `source` if it is given: (n, P) -> (n, d).

        Each effect has a random stream of its own, so that one more effect changes the same events.
        """
        seed = int(rng.spawn(1)[0].integers(2**63))
        streams = [np.random.default_rng([seed, crc32(repr(effect.key).encode())]) for effect in self.effects]
        return self._with_effects(len(self.effects), params, rng, streams, source or self.source())

    @cached_property
    def _chain(self) -> list[tuple[int, slice]]:
        """The effects in the order in which they act, by their stages, with the columns of their parameters."""
        order = sorted(range(len(self.effects)), key=lambda k: self.effects[k].stage)
        return [(k, self.columns(k)) for k in order]

    @property
    def newest_acts_last(self) -> bool:
        """Whether the effect that was added last changes the finished events of the model without it."""
        newest = self.effects[-1]
        return newest.stage > 0 and not newest.moves_theta and self._chain[-1][0] == len(self.effects) - 1

    def _with_effects(
        self,
        k: int,
        params: NDArray[np.float64],
        rng: np.random.Generator,
        streams: list[np.random.Generator],
        source: Source,
        alter: Alter | None = None,
    ) -> NDArray:
        """Events with the first k effects that act. An effect sees those before it as the simulator, and all parameters
        as theta, so that it may ask for any rows again."""
        if k == 0:
            theta = params[:, : self.num_theta]
            return source(theta, rng) if alter is None else source(theta, rng, alter)

        def before(params: NDArray, _: np.random.Generator, earlier: Alter | None = None) -> NDArray:
            return self._with_effects(k - 1, params, rng, streams, source, _both(earlier, alter))

        added, columns = self._chain[k - 1]
        return self.effects[added].apply(before, params, params[:, columns], streams[added])


def _both(first: Alter | None, then: Alter | None) -> Alter | None:
    if first is None or then is None:
        return first or then
    return lambda generated, rows: then(first(generated, rows), rows)
