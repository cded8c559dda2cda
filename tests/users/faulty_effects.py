"""An effect on counts that keeps the contract, and others that each break it in one way."""

import numpy as np

from avobench.effects import Effect, Parameter


class Sound(Effect):
    """Noise is added."""

    name = "noise"
    parameters = (Parameter("rate", 0, 2, 0, "counts"),)
    sentence = "Counts of another origin are added."
    source = "test"

    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + rng.poisson(phi)


def noisy(make):
    """A fault of what is added."""
    return {"apply": lambda self, simulate, theta, phi, rng: simulate(theta, rng) + make(phi, rng)}


FAULTS = {
    "Silent": {"sentence": ""},
    "NoStage": {"stage": 7},
    "NoNull": {"parameters": (Parameter("rate", 0, 2, None, "counts"),)},
    "NeverAbsent": noisy(lambda phi, rng: rng.poisson(phi + 2)),
    "OfTheSecondRow": noisy(lambda phi, rng: rng.poisson(phi[1, 0], phi.shape)),
    "OtherType": {"apply": lambda self, simulate, theta, phi, rng: simulate(theta, rng).astype(np.float32)},
    "OwnGenerator": noisy(lambda phi, rng: np.random.default_rng().poisson(phi)),
    "Unsendable": {"__init__": lambda self: setattr(self, "noise", lambda phi, rng: rng.poisson(phi))},
}
for name, changes in FAULTS.items():
    globals()[name] = type(name, (Sound,), {"__module__": __name__, **changes})
