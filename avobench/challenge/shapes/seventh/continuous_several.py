"""What several real features do to one another, or share."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Place, Simulate, drawn, strength
from avobench.challenge.shapes.places import Single, Together


@dataclass(frozen=True)
class Beside(Single):
    """What happens to one feature by way of the others."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.task.num_features > 1

    @property
    def own(self) -> int:
        """The column that changes."""
        return self.place.columns[0]

    def other(self, share: float) -> int:
        """One of the other columns, by a number in [0, 1]."""
        others = [j for j in range(self.place.task.num_features) if j != self.own]
        return others[min(int(share * len(others)), len(others) - 1)]

    def units(self, x: NDArray[np.float64], j: int) -> NDArray[np.float64]:
        """A column in standard deviations from its mean: (n,)."""
        return (x[:, j] - self.place.reference[:, j].mean()) / self.place.reference[:, j].std()

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        changed = x.copy()
        changed[:, self.own] = self.respond(x, rng)
        return changed

    @abstractmethod
    def respond(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """The column that changes, from the whole events: (n, d) -> (n,)."""


@dataclass(frozen=True)
class AnodeCoupling(Beside):
    """The anodes of the photomultiplier are coupled by their capacitance. A part of every other signal is added to this
    one, less with every step of distance."""

    strength: float = strength(0.012, 0.3, "std / std", sign=True)
    """Leaking from the next neighbours."""
    decrease: float = drawn(0.1, 0.7)
    """From one neighbour to the next."""

    name = "crosstalk"
    source = "multi-anode photomultiplier"

    def respond(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        distance = np.abs(np.arange(x.shape[1]) - self.own)
        weights = self.strength * self.decrease ** np.maximum(distance - 1, 0) * (distance > 0)
        return x[:, self.own] + (x / self.place.reference.std(axis=0)) @ weights * self.place.std[0]


@dataclass(frozen=True)
class MultiplexerMemory(Beside):
    """One digitiser reads the channels in turn and does not quite settle between them. The reading is a mixture of this
    channel and of the one read just before.

    How much of the old one is left falls exponentially with the time allowed, which jitters.
    """

    strength: float = strength(0.015, 0.35)
    """Left of the channel before, in units where all channels have the same spread."""
    jitter: float = drawn(0.05, 0.4)
    """Of the time allowed, in time constants."""

    name = "crosstalk"
    source = "multiplexed data logger"

    def respond(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        before = (self.own - 1) % x.shape[1]
        left = np.minimum(self.strength * np.exp(self.jitter * rng.uniform(-1, 1, len(x))), 1)
        spread = self.place.std[0] / self.place.reference[:, before].std()
        return (1 - left) * x[:, self.own] + left * spread * x[:, before]


@dataclass(frozen=True)
class GasGain(Beside):
    """The amplification in a gas grows exponentially with a quantity measured beside it, such as the temperature. The
    spread of this feature about its mean is stretched where the other is large and shrunk where it is small.
    """

    strength: float = strength(0.02, 0.35, "1 / std", sign=True)
    """Logarithm of the gain for one standard deviation of the other feature."""
    partner: float = drawn(0, 1)
    """Which of the other features it is."""

    name = "conditional_response"
    source = "temperature dependence of a proportional counter"

    def respond(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        condition = np.clip(self.units(x, self.other(self.partner)), -3, 3)
        mean = self.place.reference[:, self.own].mean()
        return mean + (x[:, self.own] - mean) * np.exp(self.strength * condition)


@dataclass(frozen=True)
class PumpVibration(Beside):
    """Above a certain flow the pump makes the instrument vibrate, the more the larger the flow. This feature is smeared
    in events where the flow, another feature, is above that."""

    strength: float = strength(0.2, 1.2, "std")
    """Width one standard deviation of the other feature above its threshold."""
    onset: float = drawn(-0.5, 0.8, "std")
    """Threshold of the other feature."""
    partner: float = drawn(0, 1)
    """Which of the other features it is."""

    name = "conditional_response"
    source = "flow-induced vibration of a balance"

    def respond(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        above = np.clip(self.units(x, self.other(self.partner)) - self.onset, 0, 3)
        return x[:, self.own] + self.strength * self.place.std[0] * above * rng.standard_normal(len(x))


@dataclass(frozen=True)
class MainsHum(Together, Change):
    """All channels pick up the hum of the mains through a common ground. At any moment the hum adds nearly the same
    error to all of them.

    Each channel lags a little behind the one before.
    """

    strength: float = strength(0.12, 0.9, "std")
    """Amplitude of the hum."""
    lag: float = drawn(0, 0.25, "rad")
    """Phase from one channel to the next."""

    name = "correlation"
    source = "ground loop in a multichannel recorder"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.uniform(0, 2 * np.pi, (len(x), 1)) - self.lag * np.arange(x.shape[1])
        return x + self.strength * self.place.std * np.sin(phase)


@dataclass(frozen=True)
class TiltingTable(Together, Change):
    """The table that carries all sensors tilts a little about a pivot, differently in every event. Sensors on one side
    of the pivot read too much when those on the other side read too little."""

    strength: float = strength(0.08, 0.6, "std")
    """Root mean square of the error, over events and sensors."""
    pivot: float = drawn(-1, 1)
    """Where the pivot is between the first and the last sensor, at -1 and 1."""

    name = "correlation"
    source = "rocking optical table"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        lever = np.linspace(-1, 1, x.shape[1]) - self.pivot
        lever /= np.sqrt((lever**2).mean())
        return x + self.strength * self.place.std * lever * rng.standard_normal((len(x), 1))
