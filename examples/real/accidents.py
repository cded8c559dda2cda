"""Accidents of a worker (Greenwood and Yule 1920): a Poisson distribution, were all equally liable to them."""

from pathlib import Path

import numpy as np

import avobench


def accidents(theta, rng):
    return rng.poisson(theta[:, 0])


task = avobench.task(accidents, prior={"rate": (0.1, 3)}, features=["accidents"])
value, times = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", dtype=int, unpack=True)
measured = np.repeat(value, times)

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
