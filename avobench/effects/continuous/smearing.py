"""Resolution and outliers: a value is recorded with an error."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter, skewed_noise

PDG = "Particle Data Group, Review of Particle Physics (2022), "


@dataclass(frozen=True)
class Resolution(Change):
    """Each value is smeared with standard deviation `sigma`."""

    shape: str = "gaussian"
    name = "resolution"
    sentence = "Values are measured with a finite resolution that the simulation lacks."
    source = PDG + "Section 35"

    def strength(self) -> Parameter:
        if self.shape == "angle":
            return Parameter("sigma", 0, 1.5, 0, "rad")
        return Parameter("sigma", 0, self.half, 0, "of the feature")

    def variants(self):
        shapes = {
            "gaussian": (),
            "skewed": (Parameter("skewness", -2, 2, None, "1"),),
            "tails": (Parameter("tail", 0.02, 0.5, None, "1"),),
            "proportional": (),
        }
        return shapes | ({"reflected": (), "angle": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        n, sigma = len(x), phi[:, 0]
        noise = skewed_noise(phi[:, 1], rng) if self.shape == "skewed" else rng.standard_normal(n)
        if self.shape == "tails":  # a share `tail` has three times the width of the core
            wide = rng.random(n) < phi[:, 1]
            noise = noise * np.where(wide, 3, 1) / np.sqrt(1 + 8 * phi[:, 1])
        if self.shape == "proportional":
            return x + sigma * noise * np.abs(span.unit(x))
        if self.shape == "angle":
            return span.cosine(span.angle(x) + sigma * noise)
        return span.reflect(x + sigma * noise) if self.shape == "reflected" else x + sigma * noise


@dataclass(frozen=True)
class Outliers(Change):
    """A share of the values has a large error: `width` times half the range, or as an angle."""

    shape: str = "gaussian"
    name = "outliers"
    sentence = "A few values are far off, as from a failed reconstruction."
    source = "P. J. Huber, Robust Statistics (1981), Section 1.1"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        width = Parameter("width", 0.5, 20, None, "of half the range")
        angle = Parameter("width", 0.3, 3, None, "rad")
        shapes = {"gaussian": (width,), "cauchy": (width,)}
        return shapes | ({"angle": (angle,)} if self.bounded else {"above": (width,), "below": (width,)})

    def changed(self, x, span, phi, rng):
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        n, width = len(rows), phi[rows, 1] * span.half
        x = x.copy()
        if self.shape == "angle":
            x[rows] = span.cosine(span.angle(x[rows]) + phi[rows, 1] * rng.standard_normal(n))
        elif self.shape == "cauchy":
            x[rows] += 0.3 * width * rng.standard_cauchy(n)
        elif self.shape in ("above", "below"):  # to one side only, as a loss of energy is
            x[rows] += (1 if self.shape == "above" else -1) * width * rng.standard_exponential(n)
        else:
            x[rows] += width * rng.standard_normal(n)
        return x
