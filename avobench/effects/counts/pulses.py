"""Effects by which pulses are counted more than once, or not at all: a dead time, double counts and afterpulses."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole


@dataclass(frozen=True)
class DeadTime(CountEffect):
    """Pulses arrive at random times of the window; after each that is counted the counter is blind for `tau`.

    A pulse that it does not see prolongs this always (`paralysable`), never, or with some probability (`hybrid`). More
    pulses than `overload`, with blind times longer than the window in all, are more than any counter in use receives:
    nothing is counted.
    """

    shape: str = "non_paralysable"

    highest: float = 1.0
    """Largest tau: a counter hardly records more than 1 / tau counts."""

    name = "dead_time"
    position = 3
    SHAPES: ClassVar = {"non_paralysable": (), "paralysable": (), "hybrid": (Parameter("prolonging", 0, 1, None, "1"),)}
    sentence: ClassVar = "After each count the counter is blind for a while, so high counts are reduced most."
    source: ClassVar = (
        "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.VII; "
        "G. E. Albert, L. Nelson, Ann. Math. Stat. 24 (1953) 9"
    )

    def strength(self) -> Parameter:
        return Parameter("tau", 0, self.highest, 0, "of the window")

    @property
    def overload(self) -> float:
        """Ten times the most that a counter blind for `highest` records, and 200 at least."""
        return max(200.0, 10 / self.highest)

    def adapted(self, x):
        return replace(self, highest=1 / max(float(np.median(x[:, self.columns], axis=0).max()), 1.0))

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        prolonging = phi[:, 1] if self.shape == "hybrid" else np.full(len(x), float(self.shape == "paralysable"))
        for j in self.columns:
            x[(x[:, j] > self.overload) & (x[:, j] * phi[:, 0] > 1), j] = 0
            x[:, j] = counted(whole(x[:, j]), phi[:, 0], prolonging, rng)
        return x


def counted(
    n: NDArray[np.intp], tau: NDArray[np.float64], prolonging: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.intp]:
    """How many of n pulses at random times in [0, 1] a counter sees that is blind for `tau` after each that it saw.

    One that it did not see makes it blind for as long again with the probability `prolonging`. All are of shape (N,).
    """
    order = np.argsort(-n)  # events with many pulses come first, so that those that still have one are the first
    n, tau, prolonging = n[order], tau[order].astype(np.float32), prolonging[order]
    active = np.searchsorted(-n, -np.arange(n.max(initial=0)), side="left")  # how many have more than k pulses
    # Times between pulses, in units that differ between events.
    times = rng.standard_exponential(active.sum(), np.float32)
    parts = [times[end - m : end] for m, end in zip(active, np.cumsum(active), strict=True)]
    whole = rng.standard_exponential(len(n), np.float32)
    for part in parts:
        whole[: len(part)] += part
    tau, prolongs = tau * whole, prolonging.any()
    counts, time, blind_until = np.zeros(len(n), np.int32), np.zeros(len(n), np.float32), np.zeros(len(n), np.float32)
    for m, part in zip(active, parts, strict=True):
        now = time[:m]
        now += part
        blinds = now >= blind_until[:m]
        counts[:m] += blinds
        if prolongs:
            blinds |= rng.random(m, np.float32) < prolonging[:m]
        np.maximum(blind_until[:m], (now + tau[:m]) * blinds, out=blind_until[:m])
    back = np.empty_like(counts)
    back[order] = counts
    return back


@dataclass(frozen=True)
class DoubleCounting(CountEffect):
    """Two events are taken for one (`merged`), an event is read twice (`repeated`), or single counts are (`pairs`)."""

    shape: str = "merged"

    name = "double_counting"
    position = 6
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {"merged": (), "repeated": (), "pairs": ()}
    sentence: ClassVar = "Some counts are counted twice, or two events are recorded as one."
    source: ClassVar = (
        "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.VII; "
        "pairs: C. D. Kemp, A. W. Kemp, Biometrika 52 (1965) 381"
    )

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.shape == "pairs":
            x[:, self.columns] += rng.binomial(whole(x[:, self.columns]), phi[:, :1])
            return x
        twice = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(twice):
            again = x[twice] if self.shape == "repeated" else simulate(theta[twice], rng)
            x[self.cells(twice)] += again[:, self.columns]
        return x


@dataclass(frozen=True)
class AfterPulses(CountEffect):
    """Each count triggers further ones, `triggered` of them in the mean of one generation.

    In the shape `chain` it is followed by one with that chance, which may be followed by another: a geometric number.
    In the shape `one_generation` it triggers a Poisson number of them, which trigger none. One at most is
    the shape `pairs`, from which they are hardly told: so all are one family.
    """

    shape: str = "chain"

    name = "double_counting"
    position = 32
    STRENGTH = Parameter("triggered", 0, 0.7, 0, "1")
    SHAPES: ClassVar = {"chain": (), "one_generation": ()}
    sentence: ClassVar = "Counts trigger false ones, as the afterpulses and the crosstalk of a photomultiplier do."
    source: ClassVar = "S. Vinogradov, Nucl. Instrum. Methods A 695 (2012) 247"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        n = whole(x[:, self.columns])
        if self.shape == "one_generation":
            x[:, self.columns] += rng.poisson(n * phi[:, :1])
        else:  # of no count there is no chain, and NumPy draws of none
            x[:, self.columns] += np.where(n > 0, rng.negative_binomial(np.maximum(n, 1), 1 - phi[:, :1]), 0)
        return x
