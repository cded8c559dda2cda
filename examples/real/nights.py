"""How long eruptions of Old Faithful last, by day and by night (Azzalini and Bowman 1990): two Gaussians.

The simulator does not know that the eruptions of the night were noted as short, medium or long.
"""

from pathlib import Path

import numpy as np

import avobench


def nights(theta, rng):
    share, short, short_std, long, long_std = theta.T
    is_short = rng.random(len(theta)) < share
    return rng.normal(np.where(is_short, short, long), np.where(is_short, short_std, long_std))


prior = {"share": (0.1, 0.6), "short": (1.5, 2.5), "short_std": (0.1, 0.6), "long": (3.5, 5), "long_std": (0.1, 0.8)}
units = dict.fromkeys(("short", "short_std", "long", "long_std"), "min")
task = avobench.task(nights, prior=prior, units=units, features=["duration"])
measured = np.loadtxt(Path(__file__).with_suffix(".csv"))

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
