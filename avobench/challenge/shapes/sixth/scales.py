"""The scale on which a real value is read: where it ends, and the steps that it has."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, drawn, strength
from avobench.challenge.shapes.places import Single, clipped


class Reading(Single, Change):
    """A value that is read from a scale."""

    stage = 4

    def limit(self, share: float) -> NDArray[np.float64]:
        """What a share of the values does not exceed: (1,)."""
        return np.quantile(self.place.reference[:, self.place.columns], share, axis=0)


@dataclass(frozen=True)
class TubeCompression(Reading):
    """The output stage of an amplifier comes near its rail. Above a limit the signal hardly grows any more, however
    large the input is.
    """

    name = "saturation"
    source = "compression in the output stage of valve amplifiers"

    strength: float = strength(0.01, 0.4)
    """Share of the values beyond the limit."""
    room: float = drawn(0.02, 0.15, "half ranges")
    """Between the limit and the rail."""
    side: float = drawn(1, 1, sign=True)
    """The end of the range with the rail."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = self.limit(1 - self.strength if self.side > 0 else self.strength)
        over, room = np.maximum(self.side * (x - limit), 0), self.room * self.place.half_range
        return np.where(over > 0, limit - self.side * room * np.expm1(-over / room), x)


@dataclass(frozen=True)
class NeedleAtStop(Reading):
    """The needle of an instrument runs against a stop at each end of its scale. It rests there, or is read while it
    bounces back a little.
    """

    name = "saturation"
    source = "pen recorders that hit their stops"

    strength: float = strength(0.01, 0.4)
    """Share of the values beyond the stops, half of it at each."""
    bounce: float = drawn(0.002, 0.03, "half ranges", log=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        low, high = self.limit(self.strength / 2), self.limit(1 - self.strength / 2)
        back = np.minimum(rng.standard_exponential(x.shape) * self.bounce, 0.2) * self.place.half_range
        return np.where(x < low, low + back, np.where(x > high, high - back, x))


@dataclass(frozen=True)
class UnevenCodes(Reading):
    """An analogue-to-digital converter has wide and narrow steps in turn. Every value becomes the code of its step, so
    every other code is read too often.
    """

    name = "quantisation"
    source = "differential non-linearity of converters"

    strength: float = strength(0.02, 1.5, "std")
    """Mean step."""
    imbalance: float = drawn(0.0, 0.8)
    """Of two neighbouring steps."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.strength * self.place.std
        pair, rest = np.divmod(x - self.place.centre, 2 * step)
        upper = rest > (1 + self.imbalance) * step
        return clipped(self.place, self.place.centre + (2 * pair + upper + 0.5) * step)


@dataclass(frozen=True)
class WirePitch(Reading):
    """A chamber measures a coordinate by which of its wires has fired. When a particle passes midway between two, both
    fire, and the coordinate is taken to lie halfway.
    """

    name = "quantisation"
    source = "clusters of one and two wires in wire chambers"

    strength: float = strength(0.03, 2.0, "std")
    """Distance of the wires."""
    sharing: float = drawn(0.05, 0.4)
    """Width of the strip in which two fire, as a share of that distance."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        pitch = self.strength * self.place.std
        wires = (x - self.place.centre) / pitch
        nearest, midway = np.rint(wires), np.floor(wires) + 0.5
        fired = np.where(np.abs(wires - midway) < self.sharing / 2, midway, nearest)
        return clipped(self.place, self.place.centre + fired * pitch)
