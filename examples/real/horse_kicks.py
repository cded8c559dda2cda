"""Deaths by horse kick in a corps and year (Bortkiewicz 1898): a Poisson distribution."""

from pathlib import Path

import numpy as np

import avobench


def horse_kicks(theta, rng):
    return rng.poisson(theta[:, 0])


task = avobench.task(horse_kicks, prior={"rate": (0.1, 3)}, features=["deaths"])
value, times = np.loadtxt(Path(__file__).with_suffix(".csv"), delimiter=",", dtype=int, unpack=True)
measured = np.repeat(value, times)

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
