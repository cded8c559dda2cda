"""Alpha particles in intervals of 7.5 s (Rutherford and Geiger 1910): a Poisson distribution."""

from pathlib import Path

import numpy as np

import avobench


def alpha_particles(theta, rng):
    return rng.poisson(theta[:, 0])


task = avobench.task(alpha_particles, prior={"rate": (1, 10)}, features=["particles"])
value, times = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", dtype=int, unpack=True)
measured = np.repeat(value, times)

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
