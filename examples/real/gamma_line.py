"""Energies in a germanium detector beside europium-152, 850 to 885 keV: a smooth background, were there no line."""

from pathlib import Path

import numpy as np

import avobench

LOW, HIGH, CHANNEL = 849.9866, 884.9244, 0.182920552715
"""Where the first channel begins and the last one ends, and how wide one is, in keV."""


def background(theta, rng):
    slope = theta[:, 0]  # the density is (1 + slope x) / 2 for x from -1 to 1
    x, y = rng.uniform(-1, 1, (2, len(theta)))
    x = np.where(rng.random(len(theta)) < np.abs(slope), np.sign(slope) * np.maximum(x, y), x)
    return (LOW + HIGH) / 2 + (HIGH - LOW) / 2 * x


task = avobench.task(background, prior={"slope": (-0.9, 0.9)}, features=["energy"], name="gamma-line")
energy, counts = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", unpack=True)
# Where in its channel an event lies is not known. A channel is a tenth of the line's width.
place = np.random.default_rng(0).uniform(-CHANNEL / 2, CHANNEL / 2, int(counts.sum()))
measured = np.repeat(energy, counts.astype(int)) + place

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
