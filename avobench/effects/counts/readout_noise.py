"""Readout noise: the electronics adds an error of its own to each count."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole

NOISE = {
    "gaussian": lambda n, rng: rng.standard_normal(n),
    "laplace": lambda n, rng: rng.laplace(0, np.sqrt(0.5), n),
    "jumps": lambda n, rng: rng.choice([-1.0, 1.0], n),
    "hum": lambda n, rng: np.sqrt(2) * np.sin(2 * np.pi * rng.random(n)),
}
"""By shape: errors of standard deviation 1, of size n; others have the Gaussian one."""
UPSET = Parameter("fraction", 0, 1, 0, "1")
"""Of the readings, with a flipped bit."""


@dataclass(frozen=True)
class ReadoutNoise(CountEffect):
    """Noise of standard deviation `sigma` is added to each count, rounded, and cut at zero.

    In the shape `sometimes` to a share of the readings. In `jumps` a share of them is too high or too low by `sigma`,
    in `hum` each by what a sine wave has at some phase. In `upset` one bit of a share of them is the wrong one.
    """

    shape: str = "gaussian"

    stage = 4
    name = "readout_noise"
    position = 7
    STRENGTH = Parameter("sigma", 0, 30, 0, "counts", soft=True)
    SHAPES: ClassVar = {
        "gaussian": (),
        "laplace": (),
        "folded": (),
        "sometimes": (Parameter("share", 0.01, 1, None, "1"),),
        "jumps": (Parameter("share", 0.01, 1, None, "1"),),
        "hum": (),
        "upset": (Parameter("bits", 1, 8, None, "1"),),
    }
    sentence: ClassVar = "The electronics adds noise of its own to the readings."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.III"

    @property
    def parameters(self):
        return (UPSET, *self.SHAPES["upset"]) if self.shape == "upset" else super().parameters

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.shape == "upset":
            read, n = whole(x[:, self.columns]), (len(x), len(self.columns))
            flipped = read ^ (1 << (phi[:, 1:] * rng.random(n)).astype(int))
            x[:, self.columns] = np.where(rng.random(n) < phi[:, :1], flipped, read)
            return x
        n = (len(x), len(self.columns))
        noise = NOISE.get(self.shape, NOISE["gaussian"])(n, rng)
        if self.shape in ("sometimes", "jumps"):
            noise = noise * (rng.random(n) < phi[:, 1:])
        y = np.rint(x[:, self.columns] + phi[:, :1] * noise)
        x[:, self.columns] = np.abs(y) if self.shape == "folded" else np.maximum(y, 0)
        return x
