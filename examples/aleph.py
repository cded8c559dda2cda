"""ALEPH's fifteen tables at the Z beside Pythia 8: which disagree, and three parameters fitted to them from one bank.

`python examples/lep_events.py` simulates the bank, `python examples/aleph.py reduce` keeps of it what the tables need,
in `results/aleph.npz`, and `python examples/aleph.py` prints the answer from that file. `examples/data/README.md` tells
where the tables are from.
"""

import sys
from pathlib import Path

import joblib
import numpy as np
import pandas as pd
from event_shapes import reduced
from lep_events import DEFAULT, NUM_CHECKED, NUM_THETAS, PARAMETERS, fill, kept_file, thetas
from numpy.typing import NDArray

import avobench
from avobench.tables.comparison import Reduced, distance
from avobench.tables.fit import TableFit

DATA = Path(__file__).parent / "data" / "aleph_1998.csv"
RECORD = Path("results/aleph.npz")
ENERGY = 91.2
"""[GeV], of both beams together."""
AT_ONCE = 10_000
"""Events that are binned at once."""


class Events:
    """Events with their observables: one number per event, or one per particle."""

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
    frame = pd.read_csv(DATA)
    quantities = dict(zip(frame["table"].astype(str), frame["quantity"], strict=True))
    shapes = {"1", "2", "3", "4", "5", "6", "7", "8", "18"}
    return avobench.Tables(
        avobench.read_table(
            DATA,
            number,
            of=lambda events, quantity=quantity: events.of(quantity),
            density=number != "18",  # probabilities of a multiplicity, not divided by the width of 2
            normalised=number in shapes,
            name=f"{number} {quantity}",
        )
        for number, quantity in quantities.items()
    )


def reduced_parts(name: str) -> list[Reduced]:
    """Events that are kept under a name, reduced to the tables in parts; without those of fewer than two particles.

    They are kept beside the events, since this takes minutes.
    """
    kept = kept_file(name).with_suffix(".reduced.npz")
    if not kept.exists() or kept.stat().st_mtime < kept_file(name).stat().st_mtime:
        with np.load(kept_file(name)) as file:
            count, momentum, mass = file["count"].astype(int), file["momentum"], file["mass"]
        tables, starts, parts = aleph_tables(), np.concatenate([[0], np.cumsum(count)]), []
        for first in range(0, len(count), AT_ONCE):
            c = count[first : first + AT_ONCE]
            here = slice(starts[first], starts[first + len(c)])
            seen = np.repeat(c > 1, c)
            parts.append(Reduced.of(tables, Events(c[c > 1], momentum[here][seen], mass[here][seen])))
        np.savez(kept, **{name: [getattr(part, name) for part in parts] for name in vars(parts[0])})
    with np.load(kept) as file:
        return [
            Reduced(*each) for each in zip(file["mean"], file["covariance"], file["num_events"].tolist(), strict=True)
        ]


def write_record() -> None:
    """Reduce the bank to what a repository can hold, and simulate at the theta that it gives, to see whether it is so.

    Of each set of events there are the mean and the standard deviation of the entries in each bin, and their
    correlation from all thetas of the bank together.
    """
    default, *bank = joblib.Parallel(2)(joblib.delayed(reduced_parts)(f"{i:02d}") for i in range(len(thetas())))
    bank = [Reduced.together(parts) for parts in bank]
    checked = {"few": default[0], "default": Reduced.together(default)}
    save(checked, bank)
    fill("fitted", fitted().theta, NUM_CHECKED, seed=NUM_THETAS + 2)
    save({**checked, "fitted": Reduced.together(reduced_parts("fitted"))}, bank)


def save(checked: dict[str, Reduced], bank: list[Reduced]) -> None:
    """Write the record: named sets of events, and the bank."""
    pooled = np.mean([r.covariance for r in bank], axis=0)
    scale = np.sqrt(np.maximum(np.diag(pooled), np.finfo(float).tiny))  # no event in a bin: no correlation
    every = [*checked.values(), *bank]
    np.savez_compressed(
        RECORD,
        name=[*checked, *[""] * len(bank)],
        mean=np.array([r.mean for r in every]),
        std=np.sqrt([np.diag(r.covariance) for r in every]).astype(np.float32),
        num_events=[r.num_events for r in every],
        correlation=(pooled / np.outer(scale, scale)).astype(np.float32),
    )


def read_record() -> tuple[dict[str, Reduced], list[Reduced]]:
    """The named sets of events, and the bank."""
    with np.load(RECORD) as file:
        names, mean, std, num_events, correlation = (file[name] for name in file.files)
    each = zip(mean, std.astype(float), num_events.tolist(), strict=True)
    every = [Reduced(m, correlation * np.outer(s, s), n) for m, s, n in each]
    checked = {str(name): r for name, r in zip(names, every, strict=True) if name}
    return checked, every[len(checked) :]


def fitted() -> TableFit:
    """Theta fitted from the bank."""
    names, box = list(PARAMETERS), list(PARAMETERS.values())
    bank = read_record()[1]
    return avobench.fit_tables(aleph_tables(), thetas()[1:], bank, names=names, box=box, default=DEFAULT)


def main() -> None:
    if sys.argv[1:] == ["reduce"]:
        return write_record()
    tables, checked = aleph_tables(), read_record()[0]
    compared = {name: avobench.compare_tables(tables, r) for name, r in checked.items()}
    few, default, after = (compared[name] for name in ("few", "default", "fitted"))
    print(f"Default tune, {default.num_simulations} events:\n\n{default}\n")
    for each in (few, default):
        wrong = [row.table.name.split()[0] for row in each.rows if row.p_value < 0.001]
        print(f"{each.num_simulations} events tell (p < 0.001) that these do not fit: {', '.join(wrong)}")
    fit = fitted()
    print(f"\nFitted from {fit.after.num_simulations} events at {NUM_THETAS} thetas:\n\n{fit}\n")
    print(f"Chi-squared by {after.num_simulations} fresh events each:\n\n{'table':27}  default  fitted  dof")
    for one, other in zip(default.rows, after.rows, strict=True):
        print(f"{one.table.name:27}  {one.chi_squared:7.1f} {other.chi_squared:7.1f}  {one.dof:3d}")
    print(f"{'all tables':27}  {default.chi_squared:7.1f} {after.chi_squared:7.1f}  {default.dof:3d}")
    (promised, noise), (fresh, scatter) = fit.polynomial.at(fit.theta), checked["fitted"].predicted(tables)
    q, dof = distance(fresh - promised, noise + scatter)
    print(f"\nFresh events at the fit and what the bank said of it differ by a chi-squared of {q:.0f}, dof {dof}.")


if __name__ == "__main__":
    main()
