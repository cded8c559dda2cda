"""What effects on real features share: the columns to act on, and three ways to act on them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import OF_FEATURE, Effect, Family, Parameter
from avobench.effects.ranges import Range
from avobench.effects.rejection import accepted
from avobench.effects.site import Site

REPEATED = 5
"""Number of equal values of a continuous feature that are no chance."""
KNOWN = 1e-9
"""Relative error of a step or a limit that is read off the data."""


@dataclass(frozen=True)
class FeatureEffect(Family):
    """An effect on one feature or on all alike."""

    feature: int | Literal["all"] = 0
    ranges: tuple[Range, ...] = ()
    shape: str = ""

    domains = ("continuous",)
    on_all: ClassVar[bool] = True

    @classmethod
    def entries(cls, site: Site) -> list[Effect]:
        """One a feature, and one that acts on all of them where there are several and it may."""
        features = [feature for feature in site.features if cls.on_all or feature != "all"]
        return [cls(j, site.ranges) for j in features if j == "all" or cls.acts_on(site.ranges[j])]

    @classmethod
    def acts_on(cls, span: Range) -> bool:
        """Whether it may act on a single feature of this range."""
        return True

    def unit(self, parameter: Parameter, units: Sequence[str] = ()) -> str:
        """The unit of the feature in place of `of the feature`; for half a range also which range is meant."""
        if parameter.unit not in (OF_FEATURE, "of half the range"):
            return parameter.unit
        if self.feature == "all":
            return "in the unit of each feature" if parameter.unit == OF_FEATURE else "of half the range of each"
        if parameter.unit == OF_FEATURE:
            return super().unit(parameter, units)
        unit = units[self.feature] if units else ""
        return f"of half the range {self.low:.4g} to {self.high:.4g}{'' if unit in ('', '1') else f' {unit}'}"

    @property
    def columns(self) -> range:
        return range(len(self.ranges)) if self.feature == "all" else range(self.feature, self.feature + 1)

    @property
    def bounded(self) -> bool:
        return all(self.ranges[j].bounded for j in self.columns)

    @property
    def half(self) -> float:
        """Half the range; the widest where the effect acts on all features."""
        return max(self.ranges[j].half for j in self.columns)

    @property
    def low(self) -> float:
        return min(self.ranges[j].low for j in self.columns)

    @property
    def high(self) -> float:
        return max(self.ranges[j].high for j in self.columns)

    def adapted(self, x):
        acts_on = self.columns
        shown = (span.shown(x[:, j]) if j in acts_on else span for j, span in enumerate(self.ranges))
        return replace(self, ranges=tuple(shown))

    def place(self, narrow: float, wide: float) -> tuple[Parameter, Parameter]:
        """A centre and a width, the bounds of which are given in half ranges: of the feature; of each where all."""
        scale, low, high, unit = self.half, self.low, self.high, "of the feature"
        if self.feature == "all":
            scale, low, high, unit = 1.0, -1.0, 1.0, "of half the range"
        return (
            Parameter("centre", low, high, None, unit),
            Parameter("width", narrow * scale, wide * scale, None, unit),
        )

    def placed(self, x: NDArray[np.float64], span: Range) -> NDArray[np.float64]:
        """Values of a feature in the units of `place`."""
        return span.unit(x) if self.feature == "all" else x

    def wrapped(self, x: NDArray) -> NDArray:
        """Events x (n, d), in which the angles that it acts on are brought back into their range."""
        for j in self.columns:
            x[:, j] = self.ranges[j].wrapped(x[:, j])
        return x


@dataclass(frozen=True)
class Change(FeatureEffect):
    """An effect that changes the value of a feature."""

    def changed(self, x, span, phi, rng):
        """New values of one feature: x (n,), its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        for j in self.columns:
            x[:, j] = self.ranges[j].wrapped(self.changed(x[:, j], self.ranges[j], phi, rng))
        return x


@dataclass(frozen=True)
class Background(FeatureEffect):
    """An effect by which a share of the events, its strength, comes from elsewhere: in all the features it acts on."""

    stage = 4

    def drawn(self, span, phi, rng):
        """Values of one feature: its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        for j in self.columns:
            x[rows, j] = self.ranges[j].wrapped(self.drawn(self.ranges[j], phi[rows], rng))
        return x


@dataclass(frozen=True)
class Acceptance(FeatureEffect):
    """An effect that loses events, with a probability that depends on a feature."""

    stage = 3

    def kept(self, x, span, phi):
        """The chance to be recorded: x (n,), its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        def keep(x, rows):
            return np.prod([self.kept(x[:, j], self.ranges[j], phi[rows]) for j in self.columns], axis=0)

        return accepted(simulate, theta, keep, rng)
