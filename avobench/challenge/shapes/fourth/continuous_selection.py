"""Real features: which events are lost, and which are of another origin."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Place, Replacement, Selection, drawn, strength
from avobench.challenge.shapes.fourth.scales import cotangent, real, single, value


class Along(Selection):
    """A loss that depends on one feature."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return single(place)

    @abstractmethod
    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The probability to be kept by the feature, whose range is [-1, 1]: (n,) -> (n,)."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return self.kept(self.place.scaled(x)[:, 0])

    def quantile(self, share: float) -> float:
        """Below which a share of the reference lies."""
        return float(np.quantile(self.place.scaled(self.place.reference)[:, 0], share))


class AlongCosine(Along):
    """A loss that depends on a cosine."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.cosine


class AlongReal(Along):
    """A loss that depends on a feature that is not a cosine."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return real(place)


@dataclass(frozen=True)
class ShortLeverArm(AlongCosine):
    """A track at a small angle to the beam leaves the barrel through its end after only some of the layers, and the
    fewer layers it has crossed the more often it is not found."""

    name = "edge_acceptance"
    source = "barrel trackers of finite length"

    strength: float = strength(0.05, 3.0, "power of the share of layers")
    length: float = drawn(1.0, 2.5, "half length over radius")

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.minimum(self.length / np.maximum(np.abs(cotangent(u)), 1e-9), 1) ** self.strength


@dataclass(frozen=True)
class LeakingEdge(AlongReal):
    """Close to one end of the range part of the signal leaves through the wall, and such events often fail the
    selection."""

    name = "edge_acceptance"
    source = "lateral leakage of calorimeters"

    strength: float = strength(0.1, 1.0, "lost at the edge")
    depth: float = drawn(0.1, 0.4, "of the half range")
    side: float = drawn(1.0, 1.0, sign=True)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * np.exp(-np.maximum(1 - self.side * u, 0) / self.depth)


@dataclass(frozen=True)
class ElectronAttachment(AlongCosine):
    """The charge of a track drifts to the one end plate that is read out and is attached on its way, so that tracks far
    from this plate are found less often."""

    name = "forward_backward_acceptance"
    source = "oxygen in the gas of time projection chambers"

    strength: float = strength(0.03, 0.9, "attachment lengths", sign=True)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(-np.abs(self.strength) * (1 - np.sign(self.strength) * u) / 2)


@dataclass(frozen=True)
class WeakerHalf(Along):
    """The two halves of the detector have separate triggers, and that of one half misses a share of its events; the
    border between them is washed out."""

    name = "forward_backward_acceptance"
    source = "trigger counters of detector halves"

    strength: float = strength(0.02, 0.6, "lost in the weaker half")
    border: float = drawn(0.02, 0.15, "of the half range")
    side: float = drawn(1.0, 1.0, sign=True)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * (1 + np.tanh(self.side * u / self.border)) / 2


@dataclass(frozen=True)
class WindowFrame(Along):
    """A frame stands in front of a narrow part of the range and nothing is recorded behind its middle, less and less
    towards its borders."""

    name = "dead_region"
    source = "support frames between chambers"

    strength: float = strength(0.006, 0.15, "of the half range, half width")
    at: float = drawn(-0.6, 0.6, "of the half range")

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip(2 * np.abs(u - self.at) / self.strength - 1, 0, 1)


@dataclass(frozen=True)
class CableGap(AlongCosine):
    """Between the barrel and each of its end caps is a gap for the cables, in which tracks are recorded seldom or not
    at all."""

    name = "dead_region"
    source = "transition between barrel and end cap"

    strength: float = strength(0.05, 1.0, "lost in the gaps")
    at: float = drawn(0.5, 0.8)
    width: float = drawn(0.03, 0.1)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * (np.abs(np.abs(u) - self.at) < self.width / 2)


@dataclass(frozen=True)
class HillTrigger(AlongReal):
    """The trigger sees only part of the signal and so passes few of the small values and nearly all of the large ones,
    with a gradual rise between."""

    name = "turn_on"
    source = "trigger towers that see part of a shower"

    strength: float = strength(0.03, 0.4, "of events below half efficiency")
    steepness: float = drawn(4.0, 12.0)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        half = max(self.quantile(self.strength) + 1, 0.02)
        return 1 / (1 + (half / np.maximum(u + 1, 1e-3)) ** self.steepness)


@dataclass(frozen=True)
class ScatteredLevels(AlongReal):
    """Each event is triggered by one of many channels, whose levels lie evenly between a lowest and a highest one:
    between them the efficiency rises in a straight line."""

    name = "turn_on"
    source = "spread of discriminator levels"

    strength: float = strength(0.01, 0.4, "of events below the mean level")
    spread: float = drawn(0.1, 0.35, "of the half range")

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip((u - self.quantile(self.strength)) / (2 * self.spread) + 0.5, 0, 1)


@dataclass(frozen=True)
class BeamPipeCone(AlongCosine):
    """Tracks inside a cone around the beam, forward or backward, are not written to the sample at all."""

    name = "truncation"
    source = "fiducial cut around the beam pipe"

    strength: float = strength(0.05, 0.6, "rad")

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.abs(u) < np.cos(self.strength)).astype(float)


@dataclass(frozen=True)
class PreselectedSample(AlongReal):
    """The sample was written by a filter that passes nothing beyond a limit on one side of this feature."""

    name = "truncation"
    source = "flux-limited and skimmed samples"

    strength: float = strength(0.003, 0.3, "of events beyond the limit")
    side: float = drawn(1.0, 1.0, sign=True)

    def kept(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        limit = self.quantile(1 - self.strength if self.side > 0 else self.strength)
        return (self.side * u <= self.side * limit).astype(float)


class OneFeature(Replacement):
    """Events whose value in one feature is of another origin."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return single(place)


@dataclass(frozen=True)
class StrayTracks(OneFeature):
    """Some events are not of the collision but stray particles, which come evenly from everywhere between the two ends
    of the sensitive range."""

    name = "flat_background"
    source = "beam-gas and cosmic particles"

    strength: float = strength(0.005, 0.3, "of events")
    reach: float = drawn(0.9, 1.0, "of the half range")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return value(self.place, rng.uniform(-self.reach, self.reach, (n, 1)))


@dataclass(frozen=True)
class ScraperSpot(OneFeature):
    """Some events come from a round spot where stray beam hits a piece of metal, and all of them appear in one
    place."""

    name = "peak_background"
    source = "beam scrapers seen by the detector"

    strength: float = strength(0.002, 0.1, "of events")
    at: float = drawn(-0.75, 0.75, "of the half range")
    radius: float = drawn(0.03, 0.15, "of the half range")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        across = np.sqrt(rng.random((n, 1))) * np.cos(2 * np.pi * rng.random((n, 1)))
        return value(self.place, self.at + self.radius * across)


@dataclass(frozen=True)
class TailedLine(OneFeature):
    """Some events are of a radioactive line, which appears as a narrow peak with a short tail of incomplete collection
    on its lower side."""

    name = "peak_background"
    source = "natural radioactivity in germanium spectra"

    strength: float = strength(0.002, 0.1, "of events")
    at: float = drawn(-0.5, 0.8, "of the half range")
    width: float = drawn(0.015, 0.05, "of the half range")

    @classmethod
    def suits(cls, place: Place) -> bool:
        return real(place)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        shape = rng.standard_normal((n, 1)) - 1.5 * rng.exponential(size=(n, 1))
        return value(self.place, self.at + self.width * shape)


FAMILIES = (
    ShortLeverArm,
    LeakingEdge,
    ElectronAttachment,
    WeakerHalf,
    WindowFrame,
    CableGap,
    HillTrigger,
    ScatteredLevels,
    BeamPipeCone,
    PreselectedSample,
    StrayTracks,
    ScraperSpot,
    TailedLine,
)
