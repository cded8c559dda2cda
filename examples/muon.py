import numpy as np

import avobench


def decay(theta, rng):  # a simulator: one decay time for each row of parameters
    return rng.exponential(theta[:, 0])


muon = avobench.task(decay, prior={"lifetime": (1, 4)}, units={"lifetime": "us"}, features=["time"])
rng = np.random.default_rng(7)
times = rng.exponential(2.197, 20_000)  # what nature does, and below what a detector with a weak spot keeps of it
measured = times[(times < 3) | (times > 3.5) | (rng.random(20_000) < 0.4)]

print(avobench.infer(muon, measured, budget=20_000))
found = avobench.diagnose(muon, measured)
print(found)
found.plot().savefig("muon.png", dpi=150)
