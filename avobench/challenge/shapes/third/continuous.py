"""Effects hidden in features that are real numbers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import (
    Change,
    Injection,
    Place,
    Replacement,
    Selection,
    Simulate,
    drawn,
    strength,
)

Values = NDArray[np.float64]


def is_continuous(place: Place) -> bool:
    """Whether the events are a plain list of real numbers."""
    return np.issubdtype(np.dtype(place.task.dtype), np.floating) and not place.task.event_shape


def run_time(n: int) -> Values:
    """When each of n events was taken, as a share of the run: (n, 1)."""
    return ((np.arange(n) + 0.5) / max(n, 1))[:, None]


def folded(x: Values) -> Values:
    """Cosines that left [-1, 1], reflected back into it."""
    beyond = np.mod(x + 1, 4)
    return np.clip(np.where(beyond > 2, 4 - beyond, beyond) - 1, -1, 1)


class OneFeature(Injection):
    """What acts on one feature."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return is_continuous(place) and isinstance(place.feature, int)

    def scale(self, x: NDArray) -> Values:
        """The feature where its range is [-1, 1]: (n, d) -> (n,)."""
        return self.place.scaled(x)[:, 0]


class AnyFeature(Injection):
    """What acts on one feature, or on all alike."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return is_continuous(place) and (
            isinstance(place.feature, int) or (place.feature == "all" and place.task.num_features > 1)
        )


class Cosine(OneFeature):
    """What acts on the cosine of an angle."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.cosine


class Unbounded(AnyFeature):
    """What acts on features that may have any value."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine


class AllFeatures(Injection):
    """What mixes the features of an event."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return is_continuous(place) and place.feature == "all" and place.task.num_features > 1


class WholeEvent(Injection):
    """What acts on the simulator's parameters.

    Not for one cosine, whose density is linear in the asymmetry: there a mixture is the simulator at another value.
    """

    @classmethod
    def suits(cls, place: Place) -> bool:
        return is_continuous(place) and place.feature in (None, "all") and place.task.num_features > 1

    def moved(self, theta: Values, shift: Values) -> Values:
        """Parameters moved by a part of the prior's widths, within the support: (n, p), (n, p)."""
        box = self.place.task.support
        return np.clip(theta + shift * self.place.task.prior.width, box.low, box.high)

    def direction(self, angle: float) -> Values:
        """Of unit length in the space of the parameters: (p,)."""
        count = len(self.place.task.prior.low)
        return np.array([np.cos(angle - i * np.pi / 2) for i in range(count)]) if count > 1 else np.ones(1)


class ValueChange(Change):
    """A change on the scale where the range is [-1, 1]; a cosine that leaves it is reflected."""

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        """(n, k) -> (n, k)."""
        raise NotImplementedError

    @property
    def spread(self) -> Values:
        """Standard deviation of the columns on that scale: (k,)."""
        return self.place.std / self.place.half_range

    @property
    def gentle(self) -> float:
        """A third for a cosine, whose hard edges show whatever moves all one way, else one."""
        return 1 / 3 if self.place.cosine else 1

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        u = (x - self.place.centre) / self.place.half_range
        y = self.place.centre + self.place.half_range * self.moved(u, rng)
        return folded(y) if self.place.cosine else y


class FeatureReplacement(OneFeature, Replacement):
    """Foreign events on the scale where the range is [-1, 1]."""

    def at(self, n: int, rng: np.random.Generator) -> Values:
        """(n,)"""
        raise NotImplementedError

    def foreign(self, n: int, rng: np.random.Generator) -> Values:
        y = self.place.centre + self.place.half_range * self.at(n, rng)[:, None]
        return folded(y) if self.place.cosine else y


class FeatureSelection(OneFeature, Selection):
    """A loss of events that depends on one feature."""

    def kept(self, u: Values) -> Values:
        """Efficiency on the scale where the range is [-1, 1]: (n,) -> (n,)."""
        raise NotImplementedError

    def efficiency(self, x: NDArray) -> Values:
        return np.clip(self.kept(self.scale(x)), 0, 1)


@dataclass(frozen=True)
class WorseOnOneSide(AnyFeature, ValueChange):
    """The measurement is sharp at one end of the range and gets blurrier, faster and faster, towards the other."""

    strength: float = strength(0.1, 0.55, "std")
    growth: float = drawn(0.8, 2, sign=True)

    name = "resolution"
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 35: momentum resolution"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        width = np.exp(self.growth * np.clip(u, -1.5, 1.5)) / np.exp(abs(self.growth) / 2)
        return u + self.strength * self.spread * width * rng.standard_normal(u.shape)


@dataclass(frozen=True)
class Straggling(AnyFeature, ValueChange):
    """Fluctuations have a long tail on one side, as of energy loss; their mean is calibrated away."""

    strength: float = strength(0.1, 0.5, "std")
    side: float = drawn(1, 1, sign=True)
    shape: float = drawn(0.4, 1.5)

    name = "resolution"
    source = "Landau, J. Phys. USSR 8 (1944) 201; Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 1"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        tail = (rng.gamma(self.shape, size=u.shape) - self.shape) / np.sqrt(self.shape)
        return u + self.strength * self.gentle * self.spread * self.side * tail


@dataclass(frozen=True)
class AgeingSensor(AnyFeature, ValueChange):
    """Radiation ages the sensor: early in the run it measures well, and in the end with a large random error."""

    strength: float = strength(0.2, 0.9, "std")
    power: float = drawn(0.5, 2.5)

    name = "resolution"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 2: radiation damage"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        width = self.strength * self.spread * run_time(len(u)) ** self.power
        return u + width * rng.laplace(scale=np.sqrt(0.5), size=u.shape)


@dataclass(frozen=True)
class WarmUp(AnyFeature, ValueChange):
    """The zero point drifts while the electronics warm up and then stays where it has come to."""

    strength: float = strength(0.02, 0.2, "std", sign=True)
    time: float = drawn(0.05, 0.5, "run")

    name = "offset"
    source = "Barlow, Systematic errors: facts and fictions, arXiv:hep-ex/0207026"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        return u + self.strength * self.gentle * self.spread * (1 - np.exp(-run_time(len(u)) / self.time))


@dataclass(frozen=True)
class KnockedSurvey(AnyFeature, ValueChange):
    """In the middle of the run somebody knocks against the frame: from then on all is displaced, and half mended."""

    strength: float = strength(0.03, 0.25, "std", sign=True)
    knock: float = drawn(0.1, 0.5, "run")
    mended: float = drawn(0.6, 0.9, "run")

    name = "offset"
    source = "Blobel and Kleinwort, A new method for the alignment of track detectors, arXiv:hep-ex/0208021"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        time = run_time(len(u))
        size = np.where(time < self.knock, 0, np.where(time < self.mended, 1, 0.5))
        return u + self.strength * self.gentle * self.spread * size


@dataclass(frozen=True)
class GainByTemperature(AnyFeature, ValueChange):
    """The gain follows the temperature of the hall: it swings between nominal and wrong with day and night."""

    strength: float = strength(0.012, 0.15, sign=True)
    days: float = drawn(1.5, 8, "1/run")

    name = "scale"
    source = "Wigmans, Calorimetry, 2nd ed. (2017), Ch. 6"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        return u * (1 + self.strength * self.gentle * np.sin(np.pi * self.days * run_time(len(u))) ** 2)


@dataclass(frozen=True)
class TwoSlopes(AnyFeature, ValueChange):
    """Two amplifiers share the range, one on each side of the middle, and have gains that are wrong by unlike amounts.

    Both err in the same direction.
    """

    strength: float = strength(0.012, 0.14, sign=True)
    other: float = drawn(0.1, 0.7)
    side: float = drawn(1, 1, sign=True)

    name = "scale"
    source = "Wigmans, Calorimetry, 2nd ed. (2017), Ch. 6: inter-calibration of gain ranges"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        return u * (1 + self.strength * self.gentle * np.where(self.side * u > 0, 1, self.other))


@dataclass(frozen=True)
class Vignetting(FeatureSelection):
    """The light collected falls off towards both ends of the range, so that ever more events are lost there."""

    strength: float = strength(0.08, 0.9)
    power: float = drawn(3, 9)

    name = "edge_acceptance"
    source = "Leroy and Rancoita, Principles of Radiation Interaction in Matter and Detection, 4th ed. (2016)"

    def kept(self, u: Values) -> Values:
        return 1 - self.strength * np.minimum(np.abs(u), 1) ** self.power


@dataclass(frozen=True)
class RaisedCollimator(FeatureSelection):
    """A collimator shadows one end of the range: for part of the run it stands further in than planned."""

    strength: float = strength(0.08, 0.9)
    edge: float = drawn(0.55, 0.85)
    step: float = drawn(0.05, 0.2)
    side: float = drawn(1, 1, sign=True)

    name = "edge_acceptance"
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: angular acceptance"

    def kept(self, u: Values) -> Values:
        v = self.side * u
        return 1 - self.strength * ((v > self.edge).astype(float) + (v > self.edge + self.step)) / 2


@dataclass(frozen=True)
class WornSpot(FeatureSelection):
    """A spot of the sensor is worn by the beam: most events are lost at its middle and ever fewer around it."""

    strength: float = strength(0.04, 0.8)
    at: float = drawn(-0.6, 0.6)
    width: float = drawn(0.04, 0.15)

    name = "dead_region"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 2: radiation damage"

    def kept(self, u: Values) -> Values:
        return 1 - self.strength * np.exp(-(((u - self.at) / self.width) ** 2) / 2)


@dataclass(frozen=True)
class SlidingHole(FeatureSelection):
    """A hole that records nothing slides along the feature during part of the run, and so leaves a shallow trough."""

    strength: float = strength(0.04, 0.6)
    at: float = drawn(-0.5, 0.5)
    hole: float = drawn(0.05, 0.15)
    path: float = drawn(0.1, 0.3)

    name = "dead_region"
    source = "Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 7"

    def kept(self, u: Values) -> Values:
        wide, narrow = self.hole + self.path, abs(self.hole - self.path)
        slope = np.maximum(wide - narrow, 1e-6)
        return 1 - self.strength * np.clip((wide - np.abs(u - self.at)) / slope, 0, 1)


@dataclass(frozen=True)
class SpacerRibs(FeatureSelection):
    """Ribs that hold the chamber together stand at equal distances in part of the range, and are blind."""

    strength: float = strength(0.04, 0.6)
    start: float = drawn(-0.6, 0.0)
    period: float = drawn(0.15, 0.3)
    blind: float = drawn(0.2, 0.4)

    name = "dead_region"
    source = "Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 7: spacers of gas chambers"

    def kept(self, u: Values) -> Values:
        count = np.floor((u - self.start) / self.period)
        inside = (count >= 0) & (count < 3) & (np.mod(u - self.start, self.period) < self.blind * self.period)
        return 1 - self.strength * inside


@dataclass(frozen=True)
class StrayLight(FeatureReplacement):
    """Stray light makes events all over the range, a little more of them towards one end."""

    strength: float = strength(0.008, 0.15)
    tilt: float = drawn(0, 0.4, sign=True)
    reach: float = drawn(0.95, 1.3)

    name = "flat_background"
    source = "Cowan, Statistical Data Analysis (1998), Ch. 6"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def at(self, n: int, rng: np.random.Generator) -> Values:
        v = rng.uniform(-1, 1, n)
        return self.reach * np.where(rng.random(n) < (1 + self.tilt * v) / 2, v, -v)


@dataclass(frozen=True)
class BeamGasSpells(FeatureReplacement):
    """Beam-gas events come in spells when the vacuum is poor; they are spread widely, with soft ends on both sides."""

    strength: float = strength(0.014, 0.25)
    ends: float = drawn(0.6, 0.95)

    name = "flat_background"
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: beam-gas background"

    def at(self, n: int, rng: np.random.Generator) -> Values:
        v = self.ends * rng.uniform(-1, 1, n) + (1 - self.ends) * rng.triangular(-1, 0, 1, n)
        return v if self.place.cosine else 1.25 * v


@dataclass(frozen=True)
class ResonantLine(FeatureReplacement):
    """A narrow resonance that the simulator leaves out: a line with the long wings of Breit and Wigner."""

    strength: float = strength(0.003, 0.06)
    at_value: float = drawn(-0.6, 0.6)
    width: float = drawn(0.015, 0.06)

    name = "peak_background"
    source = "Breit and Wigner, Phys. Rev. 49 (1936) 519"

    def at(self, n: int, rng: np.random.Generator) -> Values:
        low, high = (np.arctan((end - self.at_value) / self.width) for end in (-1, 1))
        return self.at_value + self.width * np.tan(rng.uniform(low, high, n))


@dataclass(frozen=True)
class Doublet(FeatureReplacement):
    """Events of a calibration source leak in: two neighbouring lines, one stronger than the other."""

    strength: float = strength(0.003, 0.06)
    at_value: float = drawn(-0.7, 0.4)
    apart: float = drawn(0.08, 0.25)
    first: float = drawn(0.5, 0.85)

    name = "peak_background"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 12: doublets"

    def at(self, n: int, rng: np.random.Generator) -> Values:
        line = self.at_value + np.where(rng.random(n) < self.first, 0, self.apart)
        return line + self.apart / 4 * rng.standard_normal(n)


@dataclass(frozen=True)
class TailedPeak(FeatureReplacement):
    """Fakes pile up at one value, with a steep front and an exponential tail behind it."""

    strength: float = strength(0.004, 0.06)
    at_value: float = drawn(-0.4, 0.4)
    width: float = drawn(0.02, 0.06)
    tail: float = drawn(0.05, 0.15, sign=True)

    name = "peak_background"
    source = "Gaiser, PhD thesis, SLAC-R-255 (1982): peaks with a radiative tail"

    def at(self, n: int, rng: np.random.Generator) -> Values:
        return self.at_value + self.width * rng.standard_normal(n) + self.tail * rng.standard_exponential(n)


@dataclass(frozen=True)
class StraightTracksAgain(Cosine, Change):
    """Tracks that leave close to the beam bend over so short a lever arm that their charge is often taken wrongly."""

    strength: float = strength(0.25, 0.6)
    power: float = drawn(3, 9)

    name = "charge_misid"
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: charge confusion"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        return np.where(rng.random(x.shape) < self.strength * np.abs(x) ** self.power, -x, x)


@dataclass(frozen=True)
class SagittaBias(Cosine, Change):
    """A twist of the tracker bends all tracks one way: of one charge some are taken for the other, never the reverse.

    The straighter the track, the likelier it is.
    """

    strength: float = strength(0.03, 0.4)
    side: float = drawn(1, 1, sign=True)
    slope: float = drawn(-0.8, 0.8)

    name = "charge_misid"
    source = "ATLAS, Eur. Phys. J. C 80 (2020) 1194: weak modes and sagitta bias"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        chance = self.strength * (1 + self.slope * (2 * np.abs(x) - 1)) / (1 + abs(self.slope))
        return np.where((self.side * x > 0) & (rng.random(x.shape) < chance), -x, x)


@dataclass(frozen=True)
class HalfPowered(Cosine, FeatureSelection):
    """One half of the detector runs at low voltage for some time, and events in its hemisphere are lost."""

    strength: float = strength(0.04, 0.5)
    soft: float = drawn(0.03, 0.2)
    side: float = drawn(1, 1, sign=True)

    name = "forward_backward_acceptance"
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257"

    def kept(self, u: Values) -> Values:
        return 1 - self.strength * (1 + np.tanh(self.side * u / self.soft)) / 2


@dataclass(frozen=True)
class MaterialInFront(Cosine, FeatureSelection):
    """Cables run out on one side only: there an event is absorbed with a chance that rises with the path through them.

    The path grows as the direction nears the beam; the other hemisphere is untouched.
    """

    strength: float = strength(0.08, 0.8)
    power: float = drawn(0.3, 1.0)
    side: float = drawn(1, 1, sign=True)

    name = "forward_backward_acceptance"
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 34"

    def kept(self, u: Values) -> Values:
        return np.exp(-self.strength * np.maximum(self.side * u, 0) ** self.power)


@dataclass(frozen=True)
class WrongRange(Unbounded, Change):
    """A few events are read with the gain of another range, so that their distance from the middle is many times."""

    strength: float = strength(0.0004, 0.01)
    factor: float = drawn(4, 16, sign=True, log=True)

    name = "outliers"
    stage = 4
    source = "Huber, Robust Statistics (1981), Ch. 1: gross errors"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        hit = rng.random(len(x)) < self.strength
        hit = hit[:, None] & np.ones(x.shape, bool)
        return np.where(hit, self.place.centre + self.factor * (x - self.place.centre), x)


@dataclass(frozen=True)
class LightningStrikes(Unbounded, Change):
    """Discharges strike in bursts; each throws the value off by at least several widths, sometimes by very many."""

    strength: float = strength(0.0004, 0.008)
    least: float = drawn(3, 6, "std")
    tail: float = drawn(1.2, 3)
    positive: float = drawn(0.2, 1)

    name = "outliers"
    stage = 4
    source = "Hampel et al., Robust Statistics (1986), Ch. 1"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        length = 5
        struck = np.repeat(rng.random(len(x) // length + 1) < self.strength * 2, length)[: len(x)]
        struck &= rng.random(len(x)) < 0.5
        size = np.minimum(self.least * (1 + rng.pareto(self.tail, x.shape)), 50)
        sign = np.where(rng.random(x.shape) < self.positive, 1, -1)
        return np.where(struck[:, None], x + sign * size * self.place.std, x)


@dataclass(frozen=True)
class RectifiedLeak(AllFeatures, Change):
    """A feature leaks into the next one only while it is above its middle, as through a diode."""

    strength: float = strength(0.015, 0.18, "std", sign=True)
    knee: float = drawn(-0.3, 0.3, "std")

    name = "crosstalk"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 3: cross-talk"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        v = (x - self.place.centre) / self.place.std
        changed = x.copy()
        changed[:, 1:] += self.strength * np.maximum(v[:, :-1] - self.knee, 0) * self.place.std[1:]
        return changed


@dataclass(frozen=True)
class LooseGround(AllFeatures, Change):
    """A ground contact loosens in the run: a growing part of each feature appears in both its neighbours."""

    strength: float = strength(0.02, 0.25, "std", sign=True)
    onset: float = drawn(0, 0.6, "run")

    name = "crosstalk"
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 13: ground loops"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        v = (x - self.place.centre) / self.place.std
        leak = np.zeros_like(x)
        leak[:, 1:] += v[:, :-1]
        leak[:, :-1] += v[:, 1:]
        grown = np.clip((run_time(len(x)) - self.onset) / (1 - self.onset), 0, 1)
        return x + self.strength * grown * leak * self.place.std


@dataclass(frozen=True)
class CompandedSteps(AnyFeature, ValueChange):
    """The converter has fine steps around the middle of the range and ever coarser ones away from it."""

    strength: float = strength(0.003, 0.025)
    growth: float = drawn(1, 4)

    name = "quantisation"
    stage = 4
    source = "Widrow and Kollar, Quantization Noise (2008), Ch. 12; ITU-T G.711"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        code = np.arcsinh(self.growth * u) / self.strength
        return np.sinh(np.rint(code) * self.strength) / self.growth


@dataclass(frozen=True)
class UnevenCodes(AnyFeature, ValueChange):
    """In part of the run values come in codes that are wide and narrow by turns, recorded at their middles."""

    strength: float = strength(0.003, 0.06, "of events")
    step: float = drawn(0.08, 0.25)
    uneven: float = drawn(0.1, 0.6)

    name = "quantisation"
    stage = 4
    source = "IEEE Std 1241-2010, Analog-to-Digital Converters: differential non-linearity"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        pair, within = np.divmod(u / (2 * self.step), 1)
        split = (1 + self.uneven) / 2
        code = 2 * self.step * (pair + np.where(within < split, split / 2, (1 + split) / 2))
        return np.where(run_time(len(u)) > 1 - self.strength, code, u)


@dataclass(frozen=True)
class QuenchedTop(OneFeature, ValueChange):
    """Above a limit the light of dense deposits is quenched: what goes beyond grows ever more slowly."""

    strength: float = strength(0.02, 0.8)
    limit: float = drawn(0.1, 0.5)
    side: float = drawn(1, 1, sign=True)

    name = "saturation"
    source = "Birks, Proc. Phys. Soc. A 64 (1951) 874"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        beyond = np.maximum(self.side * u - self.limit, 0)
        return u - self.side * (beyond - beyond / (1 + self.strength * self.gentle * beyond))


@dataclass(frozen=True)
class TiredAmplifier(OneFeature, ValueChange):
    """The amplifier clips, and its ceiling is not fixed: it sinks a bit after a large event and differs by channel."""

    strength: float = strength(0.002, 0.03, "of events")
    loose: float = drawn(0.002, 0.03)
    tired: float = drawn(1.5, 3)
    side: float = drawn(1, 1, sign=True)

    name = "saturation"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 17: saturation and recovery"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        v = self.side * u
        share = self.strength * np.array([1, self.tired])
        fresh, tired = np.quantile(self.side * self.place.scaled(self.place.reference), 1 - share)
        ceiling = np.where(np.roll(v, 1, axis=0) > 0, tired, fresh) + self.loose * np.abs(rng.standard_normal(u.shape))
        return self.side * np.minimum(v, ceiling)


@dataclass(frozen=True)
class UnsteadyBeam(WholeEvent):
    """A parameter of the process is not the same for all events: it jitters about its value, mostly little."""

    strength: float = strength(0.1, 0.45, "prior widths")
    angle: float = drawn(0.2, 1.4, "rad", sign=True)

    name = "spread"
    stage = 1
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: centre-of-mass energy spread"

    def measure(self, simulate: Simulate, theta: Values, rng: np.random.Generator) -> NDArray:
        jitter = rng.laplace(scale=np.sqrt(0.5), size=(len(theta), 1))
        return simulate(self.moved(theta, self.strength * jitter * self.direction(self.angle)), rng)


@dataclass(frozen=True)
class SecondPopulation(WholeEvent):
    """Part of the run was taken at another setting, so that its events follow the same law with other parameters."""

    strength: float = strength(0.02, 0.4)
    angle: float = drawn(0.2, 2.9, "rad", sign=True)
    apart: float = drawn(0.4, 0.9, "prior widths")

    name = "mixture"
    stage = 1
    source = "McLachlan and Peel, Finite Mixture Models (2000)"

    def measure(self, simulate: Simulate, theta: Values, rng: np.random.Generator) -> NDArray:
        other = run_time(len(theta)) < self.strength
        return simulate(self.moved(theta, np.where(other, self.apart, 0) * self.direction(self.angle)), rng)


@dataclass(frozen=True)
class CutAway(FeatureSelection):
    """The recording ends at a limit: every event beyond it is lost, but for the few of a parallel channel."""

    strength: float = strength(0.001, 0.05, "of events")
    spared: float = drawn(0, 0.2)
    side: float = drawn(1, 1, sign=True)

    name = "truncation"
    source = "Hald, Biometrika 36 (1949) 119, truncated distributions"

    def kept(self, u: Values) -> Values:
        limit = np.quantile(self.side * self.scale(self.place.reference), 1 - self.strength)
        return np.where(self.side * u > limit, self.spared, 1)


@dataclass(frozen=True)
class FullScale(OneFeature, ValueChange):
    """What exceeds the full scale is recorded as full scale, of which there are two, one for each of two cards."""

    strength: float = strength(0.008, 0.08, "of events")
    other: float = drawn(0.2, 0.7)
    side: float = drawn(1, 1, sign=True)

    name = "censoring"
    stage = 4
    source = "Tobin, Econometrica 26 (1958) 24"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        share = self.strength * np.array([1, self.other])
        first, second = np.quantile(self.side * self.place.scaled(self.place.reference), 1 - share)
        return self.side * np.minimum(self.side * u, np.where(rng.random(u.shape) < 0.5, first, second))


@dataclass(frozen=True)
class RoundNumbers(AnyFeature, ValueChange):
    """Values read off a scale stick to its long marks when they are near to one, and else are written as they are."""

    strength: float = strength(0.008, 0.2)
    mark: float = drawn(0.15, 0.4)
    pull: float = drawn(0.1, 0.35)

    name = "heaping"
    stage = 4
    source = "Heitjan and Rubin, Ann. Stat. 19 (1991) 2244"

    def moved(self, u: Values, rng: np.random.Generator) -> Values:
        nearest = np.rint(u / self.mark) * self.mark
        near = np.abs(u - nearest) < self.pull * self.mark
        return np.where(near & (rng.random(u.shape) < self.strength), nearest, u)


@dataclass(frozen=True)
class LongRise(FeatureSelection):
    """The trigger's efficiency rises slowly along the range from one side and reaches its plateau beyond the middle."""

    strength: float = strength(0.12, 0.7)
    width: float = drawn(0.4, 0.8)
    side: float = drawn(1, 1, sign=True)

    name = "turn_on"
    source = "ATLAS, Eur. Phys. J. C 77 (2017) 317: trigger turn-on curves"

    def kept(self, u: Values) -> Values:
        return 1 - self.strength * np.exp(-(np.maximum(self.side * u + 1, 0) ** 2) / (2 * self.width**2))


@dataclass(frozen=True)
class DependentZero(AllFeatures, Change):
    """The zero point of one feature bends as a smooth function of another, and its blur grows along the same way."""

    strength: float = strength(0.04, 0.4, "std", sign=True)
    first: float = drawn(0, 1)
    second: float = drawn(0, 1)
    blur: float = drawn(0, 1)

    name = "conditional_response"
    source = "Blobel and Kleinwort, A new method for the alignment of track detectors, arXiv:hep-ex/0208021"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        d = x.shape[1]
        i = min(int(self.first * d), d - 1)
        j = (i + 1 + min(int(self.second * (d - 1)), d - 2)) % d
        v = (x[:, i] - self.place.centre[i]) / self.place.half_range[i]
        response = np.sin(2.2 * v) + self.blur * (1 + np.tanh(2 * v)) / 2 * rng.standard_normal(len(x))
        changed = x.copy()
        changed[:, j] += self.strength * response * self.place.std[j]
        return changed


@dataclass(frozen=True)
class SharedError(AllFeatures, Change):
    """Two features share a source of error, such as a common clock: both are moved by the same random amount.

    They move together or against each other.
    """

    strength: float = strength(0.09, 0.6, "std")
    first: float = drawn(0, 1)
    second: float = drawn(0, 1)
    ratio: float = drawn(0.6, 1.4, sign=True)
    tail: float = drawn(4, 12)

    name = "correlation"
    source = "Cowan, Statistical Data Analysis (1998), Ch. 7; Barlow, arXiv:hep-ex/0207026"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        d = x.shape[1]
        i = min(int(self.first * d), d - 1)
        j = (i + 1 + min(int(self.second * (d - 1)), d - 2)) % d
        error = self.strength * rng.standard_t(self.tail, len(x)) * np.sqrt(1 - 2 / self.tail)
        changed = x.copy()
        changed[:, i] += error * self.place.std[i]
        changed[:, j] += self.ratio * error * self.place.std[j]
        return changed


FAMILIES = (
    WorseOnOneSide,
    Straggling,
    AgeingSensor,
    WarmUp,
    KnockedSurvey,
    GainByTemperature,
    TwoSlopes,
    Vignetting,
    RaisedCollimator,
    WornSpot,
    SlidingHole,
    SpacerRibs,
    StrayLight,
    BeamGasSpells,
    ResonantLine,
    Doublet,
    TailedPeak,
    StraightTracksAgain,
    SagittaBias,
    HalfPowered,
    MaterialInFront,
    WrongRange,
    LightningStrikes,
    RectifiedLeak,
    LooseGround,
    CompandedSteps,
    UnevenCodes,
    QuenchedTop,
    TiredAmplifier,
)
NEW_FAMILIES = (
    UnsteadyBeam,
    SecondPopulation,
    CutAway,
    FullScale,
    RoundNumbers,
    LongRise,
    DependentZero,
    SharedError,
)
