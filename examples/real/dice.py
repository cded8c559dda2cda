"""Dice with 5 or 6 among 12 (Weldon's throws, Pearson 1900): a binomial distribution."""

from pathlib import Path

import numpy as np

import avobench


def dice(theta, rng):
    return rng.binomial(12, theta[:, 0])


task = avobench.task(dice, prior={"probability": (0.2, 0.5)}, support={"probability": (0, 1)}, features=["dice"])
value, times = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", dtype=int, unpack=True)
measured = np.repeat(value, times)

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
