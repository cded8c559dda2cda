"""Real values that are measured wrong: smeared, shifted, bent, of the wrong sign, or far off."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Place, drawn, strength
from avobench.challenge.shapes.places import Real, Single, reflected

LEAST_OF_A_SIGN = 0.2
"""Share of the values of either sign without which a wrong sign is not worth a word."""


@dataclass(frozen=True)
class MoffatSeeing(Real, Change):
    """Turbulent air spreads the image of a star. The spread has a core and wings that fall off as a power of the
    distance.
    """

    name = "resolution"
    source = "Moffat's profile of stellar images"

    strength: float = strength(0.05, 0.8, "std")
    """Half width of the image at half of its height."""
    beta: float = drawn(2.5, 4.8)
    """Power of the wings."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        core = self.strength / np.sqrt(2 ** (1 / self.beta) - 1)
        radius = core * np.sqrt(rng.uniform(0, 1, x.shape) ** (-1 / (self.beta - 1)) - 1)
        shift = radius * np.cos(rng.uniform(0, 2 * np.pi, x.shape))
        return reflected(self.place, x + self.place.std * shift)


@dataclass(frozen=True)
class DriftDiffusion(Single, Change):
    """Electrons drift through a gas to one end of the chamber and spread on their way: what happens far from that end
    is measured more coarsely, as the square root of the distance.
    """

    name = "resolution"
    source = "diffusion in time projection chambers"

    strength: float = strength(0.07, 1.0, "std")
    """Spread at the far end."""
    anode: float = drawn(0.5, 1.0, sign=True)
    """At which end they are read, and how much less they spread there."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        s = np.clip((x - self.place.centre) / self.place.half_range, -1, 1)
        spread = self.strength * self.place.std * np.sqrt((1 - self.anode * s) / (1 + abs(self.anode)))
        return reflected(self.place, x + spread * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class SlippedEncoder(Single, Change):
    """The shaft encoder of a turntable slips by some steps in the middle of the data taking. All that is measured
    afterwards is shifted.
    """

    name = "offset"
    source = "lost steps of incremental encoders"

    strength: float = strength(0.02, 1.0, "std", sign=True)
    after: float = drawn(0.5, 1.0)
    """Share of the data taken after it."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        slipped = np.arange(len(x))[:, None] >= (1 - self.after) * len(x)
        return reflected(self.place, x + self.strength * self.place.std * slipped)


@dataclass(frozen=True)
class PedestalWarmUp(Real, Change):
    """The pedestal was measured with cold electronics. It creeps away while they warm up and then stays at its new
    value, so that nearly all values are shifted alike.
    """

    name = "offset"
    source = "pedestals of charge digitisers after switching on"

    strength: float = strength(0.02, 1.0, "std", sign=True)
    """The shift in the end."""
    time: float = drawn(0.02, 0.3)
    """In which they warm up, as a share of the data taking."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        warm = -np.expm1(-np.arange(len(x))[:, None] / (self.time * len(x)))
        return reflected(self.place, x + self.strength * self.place.std * warm)


@dataclass(frozen=True)
class BirksQuenching(Single, Change):
    """A scintillator gives less light for each unit of a dense deposit than of a thin one. It was calibrated at both
    ends of the range, so in between values come out too large.
    """

    name = "scale"
    source = "Birks' law of scintillators"

    strength: float = strength(0.02, 1.5)
    """Birks' constant times the range."""
    empty: float = drawn(1, 1, sign=True)
    """The end of the range where nothing is deposited."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        deposit = (1 + self.empty * (x - self.place.centre) / self.place.half_range) / 2
        positive = np.maximum(deposit, 0)
        light = np.where(deposit > 0, positive * (1 + self.strength) / (1 + self.strength * positive), deposit)
        return self.place.centre + self.place.half_range * self.empty * (2 * light - 1)


@dataclass(frozen=True)
class GainRangeSwitch(Single, Change):
    """Above a certain value the amplifier switches to its low gain, whose factor is known wrongly: the values above it
    grow too fast or too slowly.
    """

    name = "scale"
    source = "gain-switching preamplifiers of calorimeters"

    strength: float = strength(0.02, 0.6, sign=True)
    """Error of the factor."""
    at: float = drawn(-0.7, 0.3, "half ranges")
    """Where it switches, from the middle of the range."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        switch = self.place.centre + self.at * self.place.half_range
        return reflected(self.place, x + self.strength * np.maximum(x - switch, 0))


class SignedValue(Single, Change):
    """A feature that has values of both signs."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        if not super().suits(place):
            return False
        positive = (place.reference[:, place.columns] > 0).mean()
        return bool(LEAST_OF_A_SIGN <= positive <= 1 - LEAST_OF_A_SIGN)

    def size(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of each value relative to the largest: (n, k) -> (n, k)."""
        return np.minimum(np.abs(x) / np.quantile(np.abs(self.place.reference[:, self.place.columns]), 0.99), 1)


@dataclass(frozen=True)
class BremConversion(SignedValue):
    """An electron radiates a photon that turns into a pair, and the track finder follows the wrong particle of it: the
    charge is flipped, and some of the momentum is lost. More radiate the harder they are.
    """

    name = "charge_misid"
    source = "electrons whose bremsstrahlung converts in the tracker"

    strength: float = strength(0.01, 0.5)
    """Probability for the hardest."""
    hardness: float = drawn(0.3, 1.5)
    """Power with which it grows."""
    loss: float = drawn(0.0, 0.4)
    """Largest share of the momentum that is lost."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        wrong = rng.random(x.shape) < self.strength * self.size(x) ** self.hardness
        return np.where(wrong, -x * (1 - self.loss * rng.random(x.shape)), x)


@dataclass(frozen=True)
class SwappedCables(SignedValue):
    """In one ring of the detector the cables of the two sides are plugged in the wrong way round on some modules. What
    is measured there comes out with the wrong sign.
    """

    name = "charge_misid"
    source = "left and right swapped in cabling maps"

    strength: float = strength(0.03, 1.0)
    """Share of the modules."""
    inner: float = drawn(0.1, 0.6)
    """Inner edge of the ring, where the largest value is 1."""
    width: float = drawn(0.2, 0.4)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        ring = (self.size(x) > self.inner) & (self.size(x) < self.inner + self.width)
        return np.where(ring & (rng.random(x.shape) < self.strength), -x, x)


@dataclass(frozen=True)
class CycleSlips(Single, Change):
    """A receiver loses lock and counts one or more whole wavelengths too many or too few. A few values are far off, by
    multiples of one number.
    """

    name = "outliers"
    source = "cycle slips in satellite navigation"

    strength: float = strength(0.003, 0.1)
    wavelength: float = drawn(0.5, 1.3, "half ranges")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        cycles = rng.geometric(0.6, x.shape) * rng.choice([-1, 1], x.shape)
        slipped = rng.random(x.shape) < self.strength
        return reflected(self.place, x + np.where(slipped, cycles, 0) * self.wavelength * self.place.half_range)


@dataclass(frozen=True)
class LightningPickup(Real, Change):
    """A stroke of lightning induces a pulse in the long cables of the array. The few values measured during it are far
    too large, all in the same direction.
    """

    name = "outliers"
    source = "sferics in magnetotelluric records"

    strength: float = strength(0.002, 0.08)
    size: float = drawn(2.0, 6.0, "std", sign=True)
    """Of the least pulse; its mean is twice that."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        struck = rng.random((len(x), 1)) < self.strength
        return x + struck * self.size * self.place.std * (1 + rng.standard_exponential(x.shape))
