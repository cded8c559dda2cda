"""Magnitudes of earthquakes in California, from 0 on: an exponential distribution, were all of them noticed."""

from pathlib import Path

import numpy as np

import avobench


def earthquakes(theta, rng):
    return rng.exponential(theta[:, 0])


task = avobench.task(earthquakes, prior={"mean": (0.2, 2)}, features=["magnitude"])
magnitude = np.loadtxt(Path(__file__).with_suffix(".csv"))
measured = magnitude[magnitude >= 0]

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
