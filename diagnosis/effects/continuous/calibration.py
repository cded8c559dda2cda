"""Calibration: a value is recorded shifted, stretched, mixed with others, in steps, or cut."""

from dataclasses import dataclass

import numpy as np

from avobench.diagnosis.effects.base import Parameter
from avobench.diagnosis.effects.continuous.base import Change

LEO = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), "


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted."""

    shape: str = "plain"
    name = "offset"
    sentence = "The zero of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        high = 0.7 if self.shape == "angle" else 0.7 * self.half
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]


@dataclass(frozen=True)
class Scale(Change):
    """Every value is stretched: about zero, about the centre of the angle, or more the larger it is."""

    shape: str = "linear"
    name = "scale"
    sentence = "The unit of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        return Parameter("stretch", -0.5, 0.5, 0, "1")

    def variants(self):
        return {"linear": (), "cubic": ()} | ({"angle": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(np.pi / 2 + (1 + phi[:, 0]) * (span.angle(x) - np.pi / 2))
        growth = span.unit(x) ** 2 if self.shape == "cubic" else 1
        return x * (1 + phi[:, 0] * growth)


@dataclass(frozen=True)
class Crosstalk(Change):
    """A part of another feature is added: of the next one, of a given one, or of the mean of all others."""

    shape: str = "mean"
    name = "crosstalk"
    sentence = "A part of the signal of other channels leaks into this one."
    source = LEO + "Chapter 13"

    def strength(self) -> Parameter:
        return Parameter("coupling", -0.5, 0.5, 0, "1")

    def variants(self):
        if self.feature == "all":
            return {"mean": (), "next": (), "neighbours": ()}
        return {"mean": ()} | {f"x{j + 1}": () for j in range(len(self.ranges)) if j != self.feature}

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        d = x.shape[1]
        if self.shape == "mean":
            other = (x.sum(axis=1, keepdims=True) - x) / (d - 1)
        elif self.shape == "next":
            other = np.roll(x, -1, axis=1)
        elif self.shape == "neighbours":
            other = np.roll(x, -1, axis=1) + np.roll(x, 1, axis=1)
        else:
            other = np.repeat(x[:, [int(self.shape[1:]) - 1]], d, axis=1)
        columns = list(self.columns)
        x[:, columns] += phi[:, [0]] * other[:, columns]
        return x


@dataclass(frozen=True)
class Quantisation(Change):
    """Values are known only in steps."""

    shape: str = "nearest"
    name = "quantisation"
    sentence = "Values are recorded in coarse steps, as by a converter of few bits."
    source = LEO + "Section 14.9"

    def strength(self) -> Parameter:
        return Parameter("step", 0, self.half, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        return {"nearest": (), "down": (), "middle": ()} | ({"angle": ()} if self.bounded else {})

    def guess(self, x):
        """The typical distance of neighbouring values, where values repeat; nothing where they do not."""
        steps = []
        for j in self.columns:
            values = np.unique(self.ranges[j].angle(x[:, j]) if self.shape == "angle" else x[:, j])
            if len(values) < len(x) / 3:
                gaps = np.diff(values)
                steps += [np.median(gaps[gaps > 1e-6 * self.half])] if (gaps > 1e-6 * self.half).any() else []
        steps = np.unique(steps)
        return steps[steps < self.strength().high][:, None]

    def changed(self, x, span, phi, rng):
        step = np.where(phi[:, 0] > 0, phi[:, 0], 1)
        if self.shape == "angle":
            y = span.cosine(np.rint(span.angle(x) / step) * step)
        else:
            y = step * {"nearest": np.rint, "down": np.floor, "middle": lambda v: np.floor(v) + 0.5}[self.shape](
                x / step
            )
        return np.where(phi[:, 0] > 0, y, x)


@dataclass(frozen=True)
class Saturation(Change):
    """Values end at a limit, which is half the range over `strength`: sharply above, on both sides, or softly."""

    shape: str = "above"
    name = "saturation"
    sentence = "Large values are cut at the end of the scale."
    source = LEO + "Section 14.1"

    def strength(self) -> Parameter:
        return Parameter("compression", 0, 8, 0, "half ranges a limit")

    def variants(self):
        return {"above": (), "both": (), "below": (), "soft": ()}

    def changed(self, x, span, phi, rng):
        k, u = phi[:, 0], span.unit(x)
        if self.shape == "soft":
            return span.centre + span.half * u / np.sqrt(1 + (k * u) ** 2)
        limit = 1 / np.maximum(k, 1e-9)
        low = -limit if self.shape in ("both", "below") else -np.inf
        high = limit if self.shape in ("both", "above") else np.inf
        # x itself where nothing is cut: going there and back rounds, and an absent effect must change nothing
        return np.where((u < low) | (u > high), span.centre + span.half * np.clip(u, low, high), x)


@dataclass(frozen=True)
class ChargeMisid(Change):
    """The sign is taken wrongly with a fixed chance, or with one that grows towards the ends."""

    shape: str = "constant"
    name = "charge_misid"
    sentence = "The charge, hence the sign, of some events is taken wrongly."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        return {"constant": (), "growing": (Parameter("power", 0.5, 10, None, "1"),)}

    def changed(self, x, span, phi, rng):
        chance = phi[:, 0]
        if self.shape == "growing":
            chance = chance * np.minimum(np.abs(span.unit(x)), 1) ** phi[:, 1]
        return np.where(rng.random(len(x)) < chance, -x, x)
