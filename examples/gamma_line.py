import numpy as np
from real.gamma_line import measured  # the energies in keV of 43 449 gamma rays

import avobench


def background(theta, rng):  # a simulator: an energy for each row of parameters, whose density is a straight line
    slope, (x, y) = theta[:, 0], rng.uniform(-1, 1, (2, len(theta)))
    return 867.46 + 17.47 * np.where(rng.random(len(theta)) < np.abs(slope), np.sign(slope) * np.maximum(x, y), x)


spectrum = avobench.task(background, prior={"slope": (-0.9, 0.9)}, features=["energy"], feature_units={"energy": "keV"})
print(avobench.infer(spectrum, measured, budget=20_000))
found = avobench.diagnose(spectrum, measured)
print(found)
found.plot().savefig("gamma_line.png", dpi=150)
