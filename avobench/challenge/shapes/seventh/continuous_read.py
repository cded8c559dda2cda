"""Real features whose sign, steps or ends are read wrongly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Change, Place, drawn, strength
from avobench.challenge.shapes.places import Real, Single, clipped


@dataclass(frozen=True)
class Signed(Single):
    """What happens to the sign of a feature that has both."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        if not super().suits(place):
            return False
        positive = (place.reference[:, place.columns] > 0).mean()
        return bool(0.1 < positive < 0.9)


@dataclass(frozen=True)
class StiffTracks(Signed, Change):
    """The charge is the sign of a track's curvature, and fast particles bend little. The larger a value is, the more
    often its sign is taken wrongly.

    The curvature, the inverse of the value, has a Gaussian error; only its effect on the sign is kept.
    """

    strength: float = strength(0.28, 2.5, "1 / rms")
    """Error of the curvature."""

    name = "charge_misid"
    source = "sagitta of stiff tracks in a magnetic spectrometer"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        rms = np.sqrt((self.place.reference[:, self.place.columns] ** 2).mean())
        curvature = rms / np.maximum(np.abs(x), 1e-9 * rms)
        return np.where(rng.random(x.shape) < ndtr(-curvature / self.strength), -x, x)


@dataclass(frozen=True)
class LostSignBit(Signed, Change):
    """The line that carries the sign has a loose contact, and without it the other sign is assumed. Some values of one
    sign are recorded with the opposite one, never the other way round."""

    strength: float = strength(0.01, 0.5)
    """Share of the values of that sign that lose it."""
    lost: float = drawn(1, 1, sign=True)
    """Which sign is lost."""

    name = "charge_misid"
    source = "polarity line of a sign-magnitude digitiser"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where((rng.random(x.shape) < self.strength) & (self.lost * x > 0), -x, x)


@dataclass(frozen=True)
class ShortMantissa(Real, Change):
    """Values are stored by the logarithm of their size, in few bits. They come in steps that are fine near zero and
    grow in proportion to the value."""

    strength: float = strength(0.01, 0.5)
    """Step relative to the value."""

    name = "quantisation"
    source = "companded samples of telephony"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        size = np.maximum(np.abs(x) / self.place.std, 1e-12)
        step = np.log1p(self.strength)
        return clipped(self.place, np.sign(x) * self.place.std * np.exp(step * np.rint(np.log(size) / step)))


@dataclass(frozen=True)
class DigitPreference(Real, Change):
    """Some readings of the dial are given as a round number, the others as they are. Values gather at the round
    numbers."""

    strength: float = strength(0.02, 0.9)
    """Share of the readings that are rounded."""
    step: float = drawn(0.1, 0.5, "std", log=True)
    """Between round numbers."""

    name = "quantisation"
    source = "terminal digit preference in blood pressure readings"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.step * self.place.std
        return np.where(rng.random(x.shape) < self.strength, clipped(self.place, step * np.rint(x / step)), x)


@dataclass(frozen=True)
class Ended(Single):
    """What happens at the ends of the scale of a feature that could go on."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def quantile(self, share: float) -> float:
        """What a share of the values does not exceed."""
        return float(np.quantile(self.place.reference[:, self.place.columns], share))


@dataclass(frozen=True)
class AmplifierCompression(Ended, Change):
    """Beyond a knee the amplifier answers with the logarithm of its input instead of the input. Large values on one
    side are recorded as too small, the largest most."""

    strength: float = strength(0.01, 0.35)
    """Share of the values beyond the knee."""
    softness: float = drawn(0.08, 0.4, "std", log=True)
    """Input beyond the knee that the logarithm brings down to 0.69 of itself."""
    side: float = drawn(1, 1, sign=True)

    name = "saturation"
    source = "gain compression of a radio receiver"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        knee = self.quantile(1 - self.strength if self.side > 0 else self.strength)
        unit = self.softness * self.place.std
        beyond = np.maximum(self.side * (x - knee), 0)
        return np.where(beyond > 0, knee + self.side * unit * np.log1p(beyond / unit), x)


@dataclass(frozen=True)
class SupplyRails(Ended, Change):
    """No output can go beyond the supply voltages, which have a small ripple from the mains. Values beyond either end
    are recorded as that end, as it stands at the moment."""

    strength: float = strength(0.006, 0.3)
    """Share of the values beyond both ends together."""
    ripple: float = drawn(0.005, 0.06, "std", log=True)
    """Amplitude of the ripple of each supply."""

    name = "saturation"
    source = "operational amplifier driven to its rails"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        low, high = self.quantile(self.strength / 2), self.quantile(1 - self.strength / 2)
        ripple = self.ripple * self.place.std * np.sin(2 * np.pi * rng.random(x.shape))
        return np.minimum(np.maximum(x, low + ripple), high - ripple)
