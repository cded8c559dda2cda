"""Boys among 12 children (Geissler 1889): a binomial distribution, were all families alike."""

from pathlib import Path

import numpy as np

import avobench


def families(theta, rng):
    return rng.binomial(12, theta[:, 0])


task = avobench.task(families, prior={"probability": (0.3, 0.7)}, support={"probability": (0, 1)}, features=["boys"])
value, times = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", dtype=int, unpack=True)
measured = np.repeat(value, times)

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
