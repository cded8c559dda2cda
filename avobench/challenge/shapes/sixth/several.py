"""What several real features do to each other, or suffer together."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import Change, Place, Simulate, drawn, strength
from avobench.challenge.shapes.places import Real, Together


class Driven(Real):
    """A feature that feels another one: its driver, the same number of places further on for each."""

    distance: float

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.task.num_features > 1

    @property
    def drivers(self) -> list[int]:
        """One a column of the place."""
        d = self.place.task.num_features
        return [(column + 1 + int(self.distance * (d - 1))) % d for column in self.place.columns]

    @abstractmethod
    def felt(self, x: NDArray[np.float64], driver: NDArray[np.float64]) -> NDArray[np.float64]:
        """The columns of the place, beside their drivers in standard deviations from their mean: (n, k)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        known = self.place.reference[:, self.drivers]
        driver = (x[:, self.drivers] - known.mean(axis=0)) / known.std(axis=0)
        changed = x.copy()
        changed[:, self.place.columns] = self.felt(x[:, self.place.columns], driver)
        return changed


@dataclass(frozen=True)
class MultiplexerMemory(Driven):
    """One converter reads many channels in turn. Its input keeps some of the charge of the channel before, which is
    mixed into the next one.
    """

    name = "crosstalk"
    source = "residual charge in multiplexed data loggers"

    strength: float = strength(0.01, 0.4)
    """Share of the charge that is kept."""
    distance: float = drawn(0, 1)
    """To the channel read before, from the next one (0) to the last (1)."""

    def felt(self, x: NDArray[np.float64], driver: NDArray[np.float64]) -> NDArray[np.float64]:
        return (1 - self.strength) * x + self.strength * self.place.std * driver


@dataclass(frozen=True)
class DiodeLeak(Driven):
    """A protection diode between two channels opens when one of them is high. What it has above that level leaks into
    the other.
    """

    name = "crosstalk"
    source = "leakage through clamp diodes of input circuits"

    strength: float = strength(0.02, 0.8, sign=True)
    """Share that leaks, both in standard deviations."""
    level: float = drawn(-0.5, 1.0, "std")
    """At which it opens."""
    distance: float = drawn(0, 1)
    """To the high channel, from the next one (0) to the last (1)."""

    def felt(self, x: NDArray[np.float64], driver: NDArray[np.float64]) -> NDArray[np.float64]:
        return x + self.strength * self.place.std * np.maximum(driver - self.level, 0)


@dataclass(frozen=True)
class TemperatureGain(Driven):
    """The light of a crystal depends on its temperature, which is recorded beside it and not corrected for: the gain
    of one feature follows another one.
    """

    name = "conditional_response"
    source = "light yield of lead tungstate against temperature"

    strength: float = strength(0.02, 0.6, sign=True)
    """Change of the gain from the mean to a high temperature."""
    softness: float = drawn(0.7, 2.0, "std")
    """Change of the temperature over which it levels off."""
    distance: float = drawn(0, 1)
    """To the temperature, from the next feature (0) to the last (1)."""

    def felt(self, x: NDArray[np.float64], driver: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.place.centre + (x - self.place.centre) * (1 + self.strength * np.tanh(driver / self.softness))


@dataclass(frozen=True)
class LeakageBehindEdge(Driven):
    """Particles that enter a calorimeter near its edge lose part of their shower through the side. The response to the
    energy is lower where the other feature, the position, is beyond the edge.
    """

    name = "conditional_response"
    source = "lateral leakage of showers near the edge of a calorimeter"

    strength: float = strength(0.02, 0.6)
    """Share of the energy that is lost."""
    edge: float = drawn(-0.5, 1.0, "std")
    distance: float = drawn(0, 1)
    """To the position, from the next feature (0) to the last (1)."""

    def felt(self, x: NDArray[np.float64], driver: NDArray[np.float64]) -> NDArray[np.float64]:
        empty = self.place.centre - self.place.half_range
        lost = self.strength * expit((driver - self.edge) / 0.2)
        return empty + (x - empty) * (1 - lost)


@dataclass(frozen=True)
class MainsHum(Together, Change):
    """All channels pick up the hum of the mains. An event falls at any phase of it, and each channel lags a little
    behind the one before.
    """

    name = "correlation"
    source = "fifty-hertz hum on the cables of seismic arrays"

    strength: float = strength(0.05, 0.8, "std")
    """Root mean square of the hum."""
    lag: float = drawn(0.0, 0.3, "rad")
    """From channel to channel."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.uniform(0, 2 * np.pi, (len(x), 1)) - self.lag * np.arange(x.shape[1])
        return x + self.strength * self.place.std * np.sqrt(2) * np.sin(phase)


@dataclass(frozen=True)
class GroundBounce(Together, Change):
    """When many outputs switch at once the ground of the board jumps, up or down. All channels of such an event move
    together, by an amount that differs from event to event.
    """

    name = "correlation"
    source = "simultaneous switching noise of front-end boards"

    strength: float = strength(0.07, 1.0, "std")
    """Mean size of a jump."""
    busy: float = drawn(0.3, 1.0)
    """Share of the events with a jump."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        jump = rng.laplace(0, self.strength, (len(x), 1)) * (rng.random((len(x), 1)) < self.busy)
        return x + self.place.std * jump
