"""Two samples: masses of two muons that CMS measured, and those that Pythia makes where no detector is simulated."""

import awkward as ak
import numpy as np
from real.dimuons import HIGH, LOW, measured  # 458 masses in GeV

import avobench
from avobench.tasks.alignment import start_pythia

SETTINGS = (
    *("Print:quiet = on", "Random:seed = 1"),
    *("Beams:eCM = 7000", "WeakSingleBoson:ffbar2gmZ = on", "PhaseSpace:mHatMin = 50"),
    *("23:onMode = off", "23:onIfAny = 13", "PartonLevel:MPI = off", "HadronLevel:all = off"),
)
"""Protons on protons that make Z bosons or photons, which decay to muons; muons radiate photons."""


def simulated(num_events: int) -> np.ndarray:
    """The masses of the two muons in so many events, in GeV."""
    particles = start_pythia(SETTINGS).nextBatch(num_events, 2.0)["prt"]
    muons = particles[(abs(particles["id"]) == 13) & (particles["status"] > 0)]
    energy, x, y, z = (ak.to_numpy(ak.sum(muons["p"][axis], axis=1)) for axis in ("e", "px", "py", "pz"))
    return np.sqrt(energy**2 - x**2 - y**2 - z**2)


if __name__ == "__main__":
    mass = simulated(20_000)
    sample = avobench.bank(mass[(mass > LOW) & (mass < HIGH)], features=["mass"])
    print(avobench.diagnose(sample, measured))
