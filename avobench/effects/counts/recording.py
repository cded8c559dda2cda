"""How a counter records: dead channels, dead time, thresholds, doubles, noise and rounding."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Family, Parameter, accepted

ONE_VALUE = 0.95
"""Share of the counts that a rounding may make the same, at most."""
KNOLL = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), "


@dataclass(frozen=True)
class ZeroInflation(Family):
    """A share of the events reads nothing, or, in the shape `weak`, a fraction of its counts."""

    shape: str = "dead"

    name = "zero_inflation"
    STRENGTH = Parameter("fraction", 0, 0.98, 0, "1")
    SHAPES: ClassVar = {"dead": (), "weak": (Parameter("left", 0.001, 0.3, None, "1"),)}
    sentence: ClassVar = "Some events read zero whatever happened, as from a channel that is sometimes off."
    source: ClassVar = "D. Lambert, Technometrics 34 (1992) 1"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        off = rng.random(len(x)) < phi[:, 0]
        x[off, 0] = rng.binomial(x[off, 0], phi[off, 1]) if self.shape == "weak" else 0
        return x


@dataclass(frozen=True)
class DeadTime(Family):
    """Pulses arrive at random times of the window; after each that is counted the counter is blind for `tau`.

    A pulse that it does not see prolongs this always (`paralysable`), never, or with some probability (`hybrid`). More
    pulses than `overload`, with blind times longer than the window in all, are more than any counter in use receives:
    nothing is counted.
    """

    shape: str = "non_paralysable"

    highest: float = 1.0
    """Of tau; a counter hardly records more than 1 / tau counts."""

    name = "dead_time"
    SHAPES: ClassVar = {
        "non_paralysable": (),
        "paralysable": (),
        "hybrid": (Parameter("prolonging", 0, 1, None, "1"),),
    }
    sentence: ClassVar = "After each count the counter is blind for a while, so high counts are reduced most."
    source: ClassVar = KNOLL + "Section 4.VII; G. E. Albert, L. Nelson, Ann. Math. Stat. 24 (1953) 9"

    @property
    def parameters(self):
        return (Parameter("tau", 0, self.highest, 0, "of the window"), *self.SHAPES[self.shape])

    @property
    def overload(self) -> float:
        """Ten times the most that a counter blind for `highest` records, and 200 at least.

        What a counter does is followed pulse by pulse, and simulators may be asked for any number of these.
        """
        return max(200.0, 10 / self.highest)

    def adapted(self, x):
        return replace(self, highest=1 / max(float(np.median(x)), 1.0))

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        x[(x[:, 0] > self.overload) & (x[:, 0] * phi[:, 0] > 1), 0] = 0
        prolonging = phi[:, 1] if self.shape == "hybrid" else np.full(len(x), float(self.shape == "paralysable"))
        x[:, 0] = counted(x[:, 0].astype(int), phi[:, 0], prolonging, rng)
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
    seen, time, blind_until = np.zeros(len(n), np.int32), np.zeros(len(n), np.float32), np.zeros(len(n), np.float32)
    for m, part in zip(active, parts, strict=True):
        now = time[:m]
        now += part
        blinds = now >= blind_until[:m]
        seen[:m] += blinds
        if prolongs:
            blinds |= rng.random(m, np.float32) < prolonging[:m]
        np.maximum(blind_until[:m], (now + tau[:m]) * blinds, out=blind_until[:m])
    back = np.empty_like(seen)
    back[order] = seen
    return back


@dataclass(frozen=True)
class ThresholdLoss(Family):
    """Events of few counts are not recorded: below a threshold, or the fewer the less."""

    shape: str = "step"
    highest: float = 100.0
    """Of the threshold; beyond nearly all counts it would lose events whatever they hold."""

    stage = 3
    name = "threshold_loss"
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    SHAPES: ClassVar = {"step": (), "exponential": (), "turn_on": (), "free_turn_on": ()}
    sentence: ClassVar = "Events with few counts fall below a threshold and are lost."
    source: ClassVar = KNOLL + "Section 17.IV"

    @property
    def parameters(self):
        threshold = Parameter("threshold", 0.3, self.highest, None, "counts")
        width = Parameter("width", 0.3, max(1.0, 0.3 * self.highest), None, "counts")
        return (self.STRENGTH, threshold, *((width,) if self.shape == "free_turn_on" else ()))

    def adapted(self, x):
        return replace(self, highest=max(1.0, float(np.quantile(x, 0.99))))

    def lost(self, x, phi):
        """The chance that counts x (n,) are lost: phi (n, q) -> (n,)."""
        strength, t = phi[:, 0], phi[:, 1]
        if self.shape == "exponential":
            return strength * np.exp(-x / t)
        if self.shape == "step":  # between two whole numbers it is a share of the lower one
            return strength * np.clip(t - x, 0, 1)
        # Counts at the threshold scatter by its root, a logistic by 1.8 widths.
        width = 0.3 * np.sqrt(t) if self.shape == "turn_on" else phi[:, 2]
        return strength / (1 + np.exp(np.clip((x - t) / width, -50, 50)))

    def apply(self, simulate, theta, phi, rng):
        return accepted(simulate, theta, lambda x, rows: 1 - self.lost(x[:, 0], phi[rows]), rng)


@dataclass(frozen=True)
class DoubleCounting(Family):
    """Two events are taken for one (`merged`), an event is read twice (`repeated`), or single counts are (`pairs`)."""

    shape: str = "merged"

    name = "double_counting"
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {"merged": (), "repeated": (), "pairs": ()}
    sentence: ClassVar = "Some counts are counted twice, or two events are recorded as one."
    source: ClassVar = KNOLL + "Section 4.VII; pairs: C. D. Kemp, A. W. Kemp, Biometrika 52 (1965) 381"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.shape == "pairs":
            x[:, 0] += rng.binomial(x[:, 0], phi[:, 0])
            return x
        twice = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(twice):
            x[twice] += x[twice] if self.shape == "repeated" else simulate(theta[twice], rng)
        return x


@dataclass(frozen=True)
class FlatBackground(Family):
    """A share of the events has nothing to do with the source: counts are uniform, or exponential, up to `reach`."""

    shape: str = "uniform"

    stage = 4
    name = "flat_background"
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {
        "uniform": (Parameter("reach", 2, 400, None, "counts"),),
        "exponential": (Parameter("reach", 1, 200, None, "counts"),),
    }
    sentence: ClassVar = "Some events are background whose counts spread over the whole range."
    source: ClassVar = KNOLL + "Section 20.II"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        reach, u = phi[rows, 1], rng.random(len(rows))
        x[rows, 0] = np.floor(u * (reach + 1)) if self.shape == "uniform" else np.floor(-reach * np.log1p(-u))
        return x


@dataclass(frozen=True)
class ReadoutNoise(Family):
    """Noise of standard deviation `sigma` is added to each count, rounded, and cut at zero."""

    shape: str = "gaussian"

    stage = 4
    name = "readout_noise"
    STRENGTH = Parameter("sigma", 0, 30, 0, "counts", soft=True)
    SHAPES: ClassVar = {"gaussian": (), "laplace": (), "folded": ()}
    sentence: ClassVar = "The electronics adds noise of its own to every reading."
    source: ClassVar = KNOLL + "Section 17.III"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        n = len(x)
        noise = rng.laplace(0, np.sqrt(0.5), n) if self.shape == "laplace" else rng.standard_normal(n)
        y = np.rint(x[:, 0] + phi[:, 0] * noise)
        x[:, 0] = np.abs(y) if self.shape == "folded" else np.maximum(y, 0)
        return x


@dataclass(frozen=True)
class Quantisation(Family):
    """A share of the readings is known only in steps of `shape` counts, rounded as it says; or one bit sticks."""

    shape: str = "2 down"

    stage = 4
    name = "quantisation"
    choices = 1
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {
        f"{step} {to}": ()
        for step in (2, 3, 4, 5, 6, 7, 8, 10, 12, 16)
        for to in ("down", "up", "nearest", "middle")
        if step > 2 or to in ("down", "up")
    } | {f"bit {bit} {at}": () for bit in range(4) for at in ("low", "high") if (bit, at) != (0, "low")}
    sentence: ClassVar = "Readings are rounded to a coarser step than one count."
    source: ClassVar = KNOLL + "Section 17.V"

    def guess(self, x):
        """Nothing where the step is so wide that nearly all counts become the same: that is no rounding."""
        _, counts = np.unique(self._rounded(x[:, 0]), return_counts=True)
        return np.empty((0, 1)) if counts.max() > ONE_VALUE * len(x) else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = rng.random(len(x)) < phi[:, 0]
        x[rows] = self._rounded(x[rows])
        return x

    def _rounded(self, x):
        if self.shape.startswith("bit"):
            _, bit, at = self.shape.split()
            return x | 1 << int(bit) if at == "high" else x & ~(1 << int(bit))
        step, to = self.shape.split()
        step = int(step)
        before, after = {"down": (0, 0), "up": (step - 1, 0), "nearest": (step // 2, 0), "middle": (0, step // 2)}[to]
        return (x + before) // step * step + after
