"""Charged particles of hadronic Z decays by Pythia 8, at the parameters of its tune that are asked for.

`python examples/lep_events.py` simulates the bank of `aleph.py` in two processes, one file a theta. What was simulated
is kept, and is not simulated again.
"""

from pathlib import Path

import joblib
import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from avobench.tasks.alignment import start_pythia

PARAMETERS = {"StringPT:sigma": (0.2, 0.45), "StringZ:aLund": (0.3, 1.2), "TimeShower:alphaSvalue": (0.12, 0.15)}
"""Names in Pythia, with the box of the bank."""
DEFAULT = (0.335, 0.68, 0.1365)
"""Pythia's default, the Monash 2013 tune (Skands, Carrazza and Rojo, Eur. Phys. J. C 74, 2014)."""
NUM_THETAS, NUM_EVENTS = 60, 10_000
NUM_CHECKED = 100_000
"""Events at the default, and at the fitted theta."""
FOLDER = Path("results/local/aleph")
SETTINGS = (
    "Print:quiet = on",
    "Beams:idA = 11",
    "Beams:idB = -11",
    "Beams:eCM = 91.2",
    "PDF:lepton = off",  # the tables are corrected for radiation by the beams
    "WeakSingleBoson:ffbar2gmZ = on",
    "23:onMode = off",
    "23:onIfAny = 1 2 3 4 5",
)
BATCH = 1000


def thetas() -> NDArray[np.float64]:
    """The default, then a Latin hypercube over the box: (1 + NUM_THETAS, 3)."""
    low, high = np.transpose(list(PARAMETERS.values()))
    design = qmc.scale(qmc.LatinHypercube(len(low), rng=0).random(NUM_THETAS), low, high)
    return np.vstack([DEFAULT, design])


def simulate(theta: NDArray[np.float64], num_events: int, seed: int) -> dict[str, NDArray]:
    """Charged particles of so many events at theta (3,).

    `count` (num_events,) has how many each event has, `momentum` (m, 3) and `mass` (m,) in GeV are of all of them,
    event after event. Particles that live longer than 1 m / c on average do not decay, as K0S and Lambda do.
    """
    values = [f"{name} = {value!r}" for name, value in zip(PARAMETERS, theta.tolist(), strict=True)]
    pythia = start_pythia((*SETTINGS, *values, f"Random:seed = {seed}"))
    counts, momenta, masses, left = [], [], [], num_events
    while left > 0:
        # Pythia skips the rare event that it cannot finish; the 2 makes it raise RuntimeError if half of them fail.
        records = pythia.nextBatch(min(BATCH, left), 2.0)["prt"].layout.to_ListOffsetArray64(True)
        starts, left = records.offsets.data, left - len(records)
        particles = records.content[: starts[-1]]
        codes, which = np.unique(particles["id"].data, return_inverse=True)
        charged = np.array([pythia.particleData.chargeType(int(code)) != 0 for code in codes])[which]
        kept = np.flatnonzero(charged & (particles["status"].data > 0))
        counts.append(np.diff(np.searchsorted(kept, starts)))
        momenta.append(np.stack([particles["p"][k].data[kept] for k in ("px", "py", "pz")], axis=1))
        masses.append(particles["m"].data[kept])
    return {
        "count": np.concatenate(counts).astype(np.int16),
        "momentum": np.concatenate(momenta).astype(np.float32),
        "mass": np.concatenate(masses).astype(np.float32),
    }


def kept_file(name: str) -> Path:
    """Where the events of this name are kept."""
    return FOLDER / f"{name}.npz"


def fill(name: str, theta: NDArray[np.float64], num_events: int, seed: int) -> None:
    """Simulate the events of one theta, unless they are there, also where rounding moved theta a little."""
    file = kept_file(name)
    if file.exists() and np.allclose(np.load(file)["theta"], theta, rtol=1e-3):
        return
    part = file.with_suffix(".part")
    with part.open("wb") as stream:
        np.savez(stream, theta=theta, **simulate(theta, num_events, seed))
    part.rename(file)


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    wanted = [(f"{i:02d}", theta, NUM_EVENTS if i else NUM_CHECKED, 1 + i) for i, theta in enumerate(thetas())]
    joblib.Parallel(2)(joblib.delayed(fill)(*each) for each in wanted)


if __name__ == "__main__":
    main()
