"""What several real features do to one another when they are measured."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, Simulate, drawn, strength
from avobench.challenge.shapes.places import Single, Together, reflected


class Influenced(Single):
    """A change of one feature that depends on the others."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.task.num_features > 1

    @abstractmethod
    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """What the feature becomes: events (n, d) -> (n,)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        changed = x.copy()
        changed[:, self.place.columns] = reflected(self.place, self.influence(x.astype(float), rng)[:, None])
        return changed

    def one_of_others(self, draw: float) -> int:
        """A number in [0, 1] chooses one of the other features."""
        others = [j for j in range(self.place.task.num_features) if j not in self.place.columns]
        return others[min(int(draw * len(others)), len(others) - 1)]

    def standard(self, x: NDArray[np.float64], j: int) -> NDArray[np.float64]:
        """Feature j in standard deviations from its mean: (n, d) -> (n,)."""
        reference = self.place.reference[:, j]
        return (x[:, j] - reference.mean()) / reference.std()


@dataclass(frozen=True)
class RibbonCable(Influenced):
    """The signals run side by side in one cable, and each couples into the others through the capacitance between the
    wires. A share of all other signals is added to this one, the less the farther their wires are away.
    """

    name: ClassVar = "crosstalk"
    source: ClassVar = "ribbon cables of front-end electronics"

    strength: float = strength(0.015, 0.3)
    """Share that is coupled in from the next wire."""
    shielding: float = drawn(1.5, 4)
    """Factor by which the share falls from wire to wire."""

    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        j = self.place.columns[0]
        distance = np.abs(np.arange(x.shape[1]) - j)
        return x[:, j] + x @ np.where(distance > 0, self.strength * self.shielding ** (1.0 - distance), 0)


@dataclass(frozen=True)
class LeakyDiode(Influenced):
    """A diode between this channel and another one begins to conduct when the other's signal is large. What exceeds the
    diode's threshold flows over in part and is added to this signal.
    """

    name: ClassVar = "crosstalk"
    source: ClassVar = "protection diodes of a multiplexer"

    strength: float = strength(0.04, 0.8)
    """Share of the excess that flows over, both signals told in their standard deviations."""
    other: float = drawn(0, 1)
    """Chooses the other channel."""
    threshold: float = drawn(-0.5, 0.5, "std")

    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        excess = np.maximum(self.standard(x, self.one_of_others(self.other)) - self.threshold, 0)
        return x[:, self.place.columns[0]] + self.strength * self.place.std[0] * excess


@dataclass(frozen=True)
class TimeWalk(Influenced):
    """A small pulse crosses the threshold of the discriminator later than a large one, and the clock is set right for
    pulses of mean height. This feature is shifted one way for small pulses and the other way for large ones, where
    another feature tells the height.
    """

    name: ClassVar = "conditional_response"
    source: ClassVar = "leading-edge discriminator of a time-of-flight wall"

    strength: float = strength(0.05, 1, "std", sign=True)
    """Delay of a pulse of mean height, for which the clock is set."""
    other: float = drawn(0, 1)
    """Chooses the feature that tells the height of the pulse."""

    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        height = np.clip(1 + self.standard(x, self.one_of_others(self.other)) / 2, 0.15, 4)
        return x[:, self.place.columns[0]] + self.strength * self.place.std[0] * (1 / np.sqrt(height) - 1)


@dataclass(frozen=True)
class BehindTheRail(Influenced):
    """Behind the rails that carry the detector particles are scattered before they are measured. Where another feature
    lies beyond the border of the rails, this one is smeared out; elsewhere it is exact.
    """

    name: ClassVar = "conditional_response"
    source: ClassVar = "material before an electromagnetic calorimeter"

    strength: float = strength(0.12, 1.2, "std")
    other: float = drawn(0, 1)
    """Chooses the feature that tells where the rails are."""
    border: float = drawn(-0.7, 0.7, "std")

    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        behind = self.standard(x, self.one_of_others(self.other)) > self.border
        return x[:, self.place.columns[0]] + self.strength * self.place.std[0] * behind * rng.standard_normal(len(x))


@dataclass(frozen=True)
class HallProbe(Influenced):
    """The gain of a sensor depends on its temperature, which is another feature, and no correction is made for it. The
    deviation from the mean is enlarged where it is warm and reduced where it is cold.
    """

    name: ClassVar = "conditional_response"
    source: ClassVar = "temperature coefficient of a Hall probe"

    strength: float = strength(0.015, 0.3, sign=True)
    """Relative change of the gain for one standard deviation of the temperature."""
    other: float = drawn(0, 1)
    """Chooses the feature that is the temperature."""

    def influence(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        j = self.place.columns[0]
        warmth = np.clip(self.standard(x, self.one_of_others(self.other)), -2.5, 2.5)
        return x[:, j] + self.strength * warmth * self.place.std[0] * self.standard(x, j)


@dataclass(frozen=True)
class CommonGround(Together, Change):
    """All channels are measured against one ground, whose voltage wanders at random. Each event has the same error in
    all of its features, and each channel has a little noise of its own besides.
    """

    name: ClassVar = "correlation"
    source: ClassVar = "common-mode noise of a silicon strip module"

    strength: float = strength(0.05, 0.6, "std")
    own: float = drawn(0, 0.3)
    """Noise of a channel relative to that of the ground."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        noise = rng.standard_normal((len(x), 1)) + self.own * rng.standard_normal(x.shape)
        return x + self.strength * self.place.std * noise


@dataclass(frozen=True)
class HumOfMains(Together, Change):
    """The hum of the mains rides on all channels, which are read one shortly after the other. The error of each feature
    is the same oscillation, a little later in its phase than for the feature before.
    """

    name: ClassVar = "correlation"
    source: ClassVar = "50 Hz pick-up of a multichannel recorder"

    strength: float = strength(0.06, 0.9, "std")
    """Amplitude of the hum."""
    delay: float = drawn(0.03, 0.3, "rad")
    """Phase between one feature and the next."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.uniform(0, 2 * np.pi, (len(x), 1)) + self.delay * np.arange(x.shape[1])
        return x + self.strength * self.place.std * np.sin(phase)


FAMILIES: tuple[type[Injection], ...] = (
    RibbonCable,
    LeakyDiode,
    TimeWalk,
    BehindTheRail,
    HallProbe,
    CommonGround,
    HumOfMains,
)
