"""ALEPH's fifteen tables at the Z beside Pythia 8: which disagree, and three parameters fitted to them from one bank.

`python examples/lep_events.py` simulates the bank, `python examples/aleph.py reduce` keeps of it what the tables need, in
`results/aleph.npz`, and `python examples/aleph.py` prints the answer from that file. See `examples/data/README.md` for
the tables.
"""

import sys
from pathlib import Path

import joblib
import numpy as np
from event_shapes import reduced
from lep_events import DEFAULT, PARAMETERS, kept_file, thetas
from numpy.typing import NDArray

import avobench
from avobench.tables.comparison import Reduced

DATA = Path(__file__).parent / "data" / "aleph_1998.csv"
RECORD = Path("results/aleph.npz")
ENERGY = 91.2
"""[GeV], of both beams together."""
AT_ONCE = 10_000
"""Events that are binned at once."""


class Events:
    """Events with their observables: one number an event, or one a particle."""

    def __init__(self, count: NDArray, momentum: NDArray, mass: NDArray) -> None:
        self.count = count
        self.observables = reduced(count, momentum, mass, ENERGY / 2)
        self.observables["charged_multiplicity"] = count.astype(float)
        self.observables["mean_charged_multiplicity"] = np.full(len(mass), ENERGY)  # an entry a particle

    def __len__(self) -> int:
        return len(self.count)

    def of(self, quantity: str) -> NDArray | list[NDArray]:
        """What a table bins: (n,), or n arrays with one number a particle."""
        values = self.observables[quantity]
        return values if len(values) == len(self) else np.split(values, np.cumsum(self.count)[:-1])


def aleph_tables() -> avobench.Tables:
    """The tables as they are published: shapes of events add up to one, spectra to the mean multiplicity."""
    spectra = {"9": "scaled_momentum", "10": "rapidity_thrust", "11": "pt_in", "12": "pt_out", "17": "log_scaled_momentum"}
    shapes = {"1": "sphericity", "2": "aplanarity", "3": "one_minus_thrust", "4": "thrust_minor", "5": "two_jet_resolution"}
    shapes |= {"6": "heavy_jet_mass", "7": "c_parameter", "8": "oblateness", "18": "charged_multiplicity"}
    quantities = {**shapes, **spectra, "19": "mean_charged_multiplicity"}
    return avobench.Tables(
        avobench.read_table(
            DATA,
            number,
            of=lambda events, quantity=quantity: events.of(quantity),
            density=number != "18",  # probabilities of a multiplicity, not divided by the width of 2
            normalised=number in shapes,
            name=f"{number} {quantity}",
        )
        for number, quantity in sorted(quantities.items(), key=lambda item: int(item[0]))
    )


def reduced_theta(index: int) -> Reduced:
    """The events of one theta of the bank, reduced to the tables; without the rare ones of fewer than two particles.

    They are kept beside the events, since this takes minutes.
    """
    kept = kept_file(index).with_suffix(".reduced.npy")
    if not kept.exists():
        with np.load(kept_file(index)) as file:
            count, momentum, mass = file["count"].astype(int), file["momentum"], file["mass"]
        tables, starts, parts = aleph_tables(), np.concatenate([[0], np.cumsum(count)]), []
        for first in range(0, len(count), AT_ONCE):
            c = count[first : first + AT_ONCE]
            here = slice(starts[first], starts[first + len(c)])
            seen = np.repeat(c > 1, c)
            events = Events(c[c > 1], momentum[here][seen], mass[here][seen])
            parts.append(Reduced.of(tables, events))
        r = Reduced.together(parts)
        np.save(kept, np.vstack([r.covariance, r.mean, np.full(len(r.mean), r.num_events)]))
    *covariance, mean, num_events = np.load(kept)
    return Reduced(mean, np.array(covariance), int(num_events[0]))


def write_record() -> None:
    """Reduce the bank to what a repository can hold.

    Of each theta the mean and the standard deviation of the entries in each bin; their correlation from all thetas
    together, of the default its own.
    """
    default, *bank = joblib.Parallel(2)(joblib.delayed(reduced_theta)(i) for i in range(len(thetas())))
    std = np.sqrt([np.diag(r.covariance) for r in bank])
    pooled = np.mean([r.covariance for r in bank], axis=0)
    np.savez_compressed(
        RECORD,
        theta=thetas(),
        num_events=[r.num_events for r in (default, *bank)],
        mean=np.array([r.mean for r in (default, *bank)]),
        std=np.vstack([np.sqrt(np.diag(default.covariance)), std]).astype(np.float32),
        correlation=np.array([_correlation(default.covariance), _correlation(pooled)]).astype(np.float32),
    )


def _correlation(covariance: NDArray) -> NDArray:
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))  # no event in a bin: no correlation
    return covariance / np.outer(scale, scale)


def read_record() -> tuple[NDArray, list[Reduced]]:
    """Thetas (61, 3), the default first, and what their events give."""
    with np.load(RECORD) as file:
        theta, num_events, mean, std = (file[name] for name in ("theta", "num_events", "mean", "std"))
        own, pooled = file["correlation"].astype(float)
    correlations = [own, *[pooled] * (len(theta) - 1)]
    bank = zip(mean, correlations, std.astype(float), num_events.tolist(), strict=True)
    return theta, [Reduced(m, c * np.outer(s, s), n) for m, c, s, n in bank]


def main() -> None:
    if sys.argv[1:] == ["reduce"]:
        return write_record()
    tables, (theta, bank) = aleph_tables(), read_record()
    print(f"Pythia 8 with its default tune: {bank[0].num_events} events\n")
    print(avobench.compare_tables(tables, bank[0]))
    print(f"\nFitted from {len(bank) - 1} thetas, {sum(r.num_events for r in bank[1:])} events\n")
    box = list(PARAMETERS.values())
    print(avobench.fit_tables(tables, theta[1:], bank[1:], names=list(PARAMETERS), box=box, default=DEFAULT))


if __name__ == "__main__":
    main()
