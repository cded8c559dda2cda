from pathlib import Path

import numpy as np

import avobench


def background(theta, rng):  # a simulator: an energy in keV for each row of parameters, its density a straight line
    slope, (x, y) = theta[:, 0], rng.uniform(-1, 1, (2, len(theta)))
    return 867.46 + 17.47 * np.where(rng.random(len(theta)) < np.abs(slope), np.sign(slope) * np.maximum(x, y), x)


spectrum = avobench.task(background, prior={"slope": (-0.9, 0.9)}, features=["energy"], feature_units={"energy": "keV"})
energy, counts = np.loadtxt(Path(__file__).parent / "real" / "gamma_line.csv", delimiter=",", unpack=True)
within = np.random.default_rng(0).uniform(-0.0914, 0.0914, int(counts.sum()))  # where in its channel, nobody knows
measured = np.repeat(energy, counts.astype(int)) + within

print(avobench.infer(spectrum, measured, budget=20_000))
found = avobench.diagnose(spectrum, measured)
print(found)
found.plot().savefig("gamma_line.png", dpi=150)
