"""Effects on what is measured of each value: a resolution, an offset, a scale, outliers, a tail or a wrong sign."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter
from avobench.effects.noise import skewed_noise

TAIL_WIDTH = 3
"""Width of the tail, in widths of the core, in the shape `tails`: wide enough to be told from the core."""
WIDEST_ANGLE = 1.5
"""Largest smearing of an angle [rad]: beyond a right angle nothing of the value is left."""
FARTHEST_OFFSET = 0.7
"""Largest offset in half ranges, or of an angle in rad."""
TAIL_INDEX = 3
"""Power by which the density of a radiative tail falls: its mean is finite, its variance is not."""


@dataclass(frozen=True)
class Resolution(Change):
    """Each value is smeared with standard deviation `sigma`.

    In the shapes `rising` and `falling` that is at one end of the range, and its square falls evenly to the other: as
    of charges that spread while they drift.
    """

    shape: str = "gaussian"
    name = "resolution"
    position = 1
    sentence = "Values are measured with a finite resolution that the simulation lacks."
    source = "Particle Data Group, Review of Particle Physics (2022), Section 35"
    SHAPES: ClassVar = {
        "gaussian": (),
        "skewed": (Parameter("skewness", -2, 2, None, "1"),),
        "tails": (Parameter("tail", 0.02, 0.5, None, "1"),),
        "proportional": (),
        "rising": (),
        "falling": (),
    }

    def strength(self) -> Parameter:
        if self.shape == "angle":
            return Parameter("sigma", 0, WIDEST_ANGLE, 0, "rad")
        return Parameter("sigma", 0, self.half, 0, "of the feature")

    def variants(self):
        return self.SHAPES | ({"reflected": (), "angle": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        error = phi[:, 0] * self._noise(phi, rng)
        if self.shape == "proportional":
            return x + error * np.abs(span.unit(x))
        if self.shape == "angle":
            return span.cosine(span.angle(x) + error)
        if self.shape in ("rising", "falling"):
            far = (1 + (span.unit(x) if self.shape == "rising" else -span.unit(x))) / 2
            moved = x + error * np.sqrt(np.clip(far, 0, 1))
            return span.reflect(moved) if span.bounded else moved
        return span.reflect(x + error) if self.shape == "reflected" else x + error

    def _noise(self, phi, rng):
        """Errors of standard deviation 1: phi (n, q) -> (n,)."""
        if self.shape == "skewed":
            return skewed_noise(phi[:, 1], rng)
        noise = rng.standard_normal(len(phi))
        if self.shape == "tails":  # a share `tail` of the values has a wider error than the core
            wide = rng.random(len(phi)) < phi[:, 1]
            noise = noise * np.where(wide, TAIL_WIDTH, 1) / np.sqrt(1 + (TAIL_WIDTH**2 - 1) * phi[:, 1])
        return noise


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted.

    In the shape `part` those of a share of the events, as after a step in time. In `creeping` the shift approaches its
    last value exponentially while the data are taken, as of electronics that warm up.
    """

    shape: str = "plain"
    name = "offset"
    position = 2
    sentence = "The zero of the scale is wrong."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 5"

    def strength(self) -> Parameter:
        high = FARTHEST_OFFSET * (1 if self.shape == "angle" else self.half)
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        of_some = {"part": (Parameter("share", 0.01, 1, None, "1"),)}
        of_most = {"creeping": (Parameter("warm_up", 0.01, 1, None, "of the data"),)}
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {}) | of_some | of_most

    def apply(self, simulate, theta, phi, rng):
        if self.shape not in ("part", "creeping"):
            return super().apply(simulate, theta, phi, rng)
        x, time = simulate(theta, rng), rng.random(len(theta))  # one time for all features of an event
        present = time < phi[:, 1] if self.shape == "part" else -np.expm1(-time / phi[:, 1])
        x[:, list(self.columns)] += (phi[:, 0] * present)[:, None]
        return self.wrapped(x)

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]


@dataclass(frozen=True)
class Scale(Change):
    """Every value is stretched: about zero, about the centre of the angle, or more the larger it is.

    In the shape `two_gains` values on one side of the centre are stretched by a share of what those on the other are.
    In the shape `bowed` the scale is right at the centre and at both ends, where it was calibrated, and not between; so
    it is for the cosine of an angle where lengths along the axis are stretched. It, too, may differ on either side.
    In `above` and `below` values beyond a level are stretched away from it, as by an amplifier that changes its range.
    """

    shape: str = "linear"
    name = "scale"
    position = 3
    sentence = "The unit of the scale is wrong."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 5"
    STRENGTH = Parameter("stretch", -0.5, 0.5, 0, "1")

    def variants(self):
        share = Parameter("share", 0, 1, None, "of the stretch")
        level = replace(self.place(0.5, 1)[0], name="level")
        plain = {"linear": (), "cubic": (), "bowed": ()} | ({"angle": ()} if self.bounded else {})
        on_a_side = {f"{kind}_{side}": (share,) for kind in ("two_gains", "bowed") for side in ("low", "high")}
        return plain | on_a_side | {"above": (level,), "below": (level,)}

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(np.pi / 2 + (1 + phi[:, 0]) * (span.angle(x) - np.pi / 2))
        side = self.shape.rpartition("_")[2]
        less = (x < span.centre) if side == "low" else (x > span.centre)
        gain = phi[:, 0] * np.where(less, phi[:, 1], 1) if side in ("low", "high") else phi[:, 0]
        if self.shape.startswith("two_gains"):
            return span.centre + (x - span.centre) * (1 + gain)
        if self.shape.startswith("bowed"):
            return x + gain * (x - span.centre) * np.maximum(1 - span.unit(x) ** 2, 0)
        if self.shape in ("above", "below"):
            beyond = x - (span.centre + span.half * phi[:, 1] if self.feature == "all" else phi[:, 1])
            return x + phi[:, 0] * (np.maximum if self.shape == "above" else np.minimum)(beyond, 0)
        growth = span.relative(x) ** 2 if self.shape == "cubic" else 1
        return x * (1 + phi[:, 0] * growth)


CAUCHY_SHARE = 0.3
"""Scale of a Cauchy error in units of the width: about as many errors reach the width as Gaussian ones do."""
WIDTH = Parameter("width", 0.5, 20, None, "of half the range")
ANGLE = Parameter("width", 0.3, 3, None, "rad")

ERRORS = {
    "gaussian": lambda width, rng: width * rng.standard_normal(len(width)),
    "cauchy": lambda width, rng: CAUCHY_SHARE * width * rng.standard_cauchy(len(width)),
    # to one side only, as a loss of energy is
    "above": lambda width, rng: width * rng.standard_exponential(len(width)),
    "below": lambda width, rng: -width * rng.standard_exponential(len(width)),
}
"""Random errors (n,) of widths (n,), by shape."""
TOGETHER = "together"
"""Ends the names of shapes in which a whole event is far off."""


@dataclass(frozen=True)
class Outliers(Change):
    """A share of the values has a large error: `width` times half the range, or as an angle.

    On all features alike in the shapes `together` an event is far off in all of them, and else a value by itself.
    """

    shape: str = "gaussian"
    name = "outliers"
    position = 10
    sentence = "A few values are far off, as from a failed reconstruction."
    source = "P. J. Huber, Robust Statistics (1981), Section 1.1"
    STRENGTH = Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        shapes = {"gaussian": (WIDTH,), "cauchy": (WIDTH,)}
        shapes |= {"angle": (ANGLE,)} if self.bounded else {"above": (WIDTH,), "below": (WIDTH,)}
        whole = {f"{each} {TOGETHER}": (WIDTH,) for each in shapes if each in ERRORS}
        return shapes | (whole if self.feature == "all" else {})

    def apply(self, simulate, theta, phi, rng):
        if not self.shape.endswith(TOGETHER):
            return super().apply(simulate, theta, phi, rng)
        x = simulate(theta, rng)
        rows, errors = np.flatnonzero(rng.random(len(x)) < phi[:, 0]), ERRORS[self.shape.split()[0]]
        for j in self.columns:
            x[rows, j] += errors(phi[rows, 1] * self.ranges[j].half, rng)
        return self.wrapped(x)

    def changed(self, x, span, phi, rng):
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        x, width = x.copy(), phi[rows, 1]
        if self.shape == "angle":
            x[rows] = span.cosine(span.angle(x[rows]) + width * rng.standard_normal(len(rows)))
        else:
            x[rows] += ERRORS[self.shape](width * span.half, rng)
        return x


LOSSES = {
    "exponential": lambda n, rng: rng.standard_exponential(n),
    "power": lambda n, rng: (TAIL_INDEX - 2) * rng.pareto(TAIL_INDEX - 1, n),
}
"""Random losses (n,) in units of their mean, by shape."""
RADIATOR = "radiator"
"""The shape in which every value loses, as an electron does in matter."""


@dataclass(frozen=True)
class RadiativeTail(Change):
    """A share of the values is moved to one side, by an exponential or a power: by the range as a rule, at most.

    Or all lose a share z of their magnitude, with the density b z^(b - 1), where b is the thickness of a radiator in
    units of 3/4 radiation length; this acts on features without negative values. `outliers` to one side are those that
    are moved by more.
    """

    shape: str = "exponential_below"
    stage = 1
    on_all = False
    name = "radiative_tail"
    position = 24
    sentence = "Some values lie in a tail to one side, as of energy that was radiated, or of times with a delay."
    source = "Y.-S. Tsai, Rev. Mod. Phys. 46 (1974) 815"

    @classmethod
    def acts_on(cls, span):
        return span.positive or not (span.bounded or span.periodic)

    def strength(self) -> Parameter:
        if self.shape == RADIATOR:
            return Parameter("thickness", 0, 1, 0, "of 3/4 radiation length")
        return Parameter("fraction", 0, 0.95, 0, "1")

    def variants(self):
        tail = Parameter("tail", 0.01 * self.half, self.half, None, "of the feature")
        tails = {f"{law}_{side}": (tail,) for side in ("below", "above") for law in LOSSES}
        return tails | ({RADIATOR: ()} if self.ranges[self.feature].positive else {})

    def changed(self, x, span, phi, rng):
        if self.shape == RADIATOR:
            thickness = np.maximum(phi[:, 0], np.finfo(float).tiny)  # of one of nothing the power is zero
            return x * (1 - rng.random(len(x)) ** (1 / thickness))
        law, _, side = self.shape.partition("_")
        lost = phi[:, 1] * LOSSES[law](len(x), rng) * (rng.random(len(x)) < phi[:, 0])
        return x - lost if side == "below" else x + lost


@dataclass(frozen=True)
class ChargeMisid(Change):
    """The sign is taken wrongly with a fixed chance, or with one that grows with the magnitude.

    In the shapes `of_positive` and `of_negative` only that of values with this sign.
    """

    shape: str = "constant"
    name = "charge_misid"
    position = 9
    sentence = "The charge, hence the sign, of some events is taken wrongly."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"
    SHAPES: ClassVar = {
        "constant": (),
        "growing": (Parameter("power", 0.5, 10, None, "1"),),
        "of_positive": (),
        "of_negative": (),
    }

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1 if self.shape.startswith("of_") else 0.5, 0, "1")

    def changed(self, x, span, phi, rng):
        chance = phi[:, 0]
        if self.shape == "growing":
            chance = chance * np.minimum(np.abs(span.relative(x)), 1) ** phi[:, 1]
        wrong = rng.random(len(x)) < chance
        if self.shape.startswith("of_"):
            wrong &= (x > 0) if self.shape == "of_positive" else (x < 0)
        return np.where(wrong, -x, x)
