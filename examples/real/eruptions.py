"""How long eruptions of Old Faithful last (Azzalini and Bowman 1990): a Gaussian, were there one kind of them."""

from pathlib import Path

import numpy as np

import avobench


def eruptions(theta, rng):
    return rng.normal(theta[:, 0], theta[:, 1])


prior = {"mean": (2, 5), "std": (0.3, 2)}
task = avobench.task(eruptions, prior=prior, units={"mean": "min", "std": "min"}, features=["duration"])
measured = np.loadtxt(Path(__file__).with_suffix(".csv"))

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
