"""What the source, other events and other origins do to counts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Replacement, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class DecayingSource(Counting, Change):
    """The source is short-lived and decays while the events are taken one after the other. The last of them have a
    lower rate than the first, and nobody has corrected for it.
    """

    name = "overdispersion"
    source = "short-lived isotopes, such as fluorine-18 in positron emission tomography"
    stage = 1
    strength: float = strength(0.15, 1.0)
    """Spread of the rate, relative to the statistical spread of a count."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        lifetimes = self.strength * np.sqrt(12 / self.mean)
        return rng.binomial(x.astype(np.int64), np.exp(-lifetimes * rng.random(x.shape))).astype(float)


@dataclass(frozen=True)
class WanderingStream(Counting, Change):
    """The cells do not all pass through the middle of the laser beam, as the stream that carries them wanders. Further
    out the light is weaker, and such a cell shines less.
    """

    name = "overdispersion"
    source = "flow cytometry, Gaussian beam profiles"
    stage = 1
    strength: float = strength(0.15, 1.0)
    """Spread of the light, relative to the statistical spread of a count."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        fall = self.strength / np.sqrt(2 * self.mean)
        light = np.exp(-fall * rng.standard_normal(x.shape) ** 2)
        return rng.binomial(x.astype(np.int64), light).astype(float)


@dataclass(frozen=True)
class ComptonContinuum(Counting, Replacement):
    """Some events are gamma rays that scatter once in the scintillator and escape. They leave any energy between
    nothing and the Compton edge, all about equally likely, and as many photons are counted.
    """

    name = "flat_background"
    source = "gamma spectroscopy with scintillators"
    strength: float = strength(0.002, 0.15)
    edge: float = drawn(1.4, 2.5)
    """Counts at the Compton edge, relative to the mean."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.poisson(rng.uniform(0, self.edge * self.mean, (n, 1))).astype(float)


@dataclass(frozen=True)
class DischargeTrain(Counting, Replacement):
    """Some events are no particles but trains of small discharges at a dirty wire. Each discharge has the same chance
    to be the last, so that trains are of all lengths, up to many times an ordinary event.
    """

    name = "flat_background"
    source = "micro-discharges in proportional counters"
    strength: float = strength(0.002, 0.15)
    length: float = drawn(1.2, 2.5)
    """Mean length of a train, relative to the mean count."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.geometric(1 / (self.length * self.mean), (n, 1)).astype(float)


@dataclass(frozen=True)
class AfterpulseChain(Counting, Change):
    """An avalanche leaves trapped charge that may set off a second avalanche, and that one a third. Each is counted as
    if it were a photon.
    """

    name = "double_counting"
    source = "afterpulses of avalanche photodiodes"
    strength: float = strength(0.01, 0.35)
    """Probability that an avalanche sets off another."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        further = rng.negative_binomial(np.maximum(x, 1), 1 - self.strength)
        return x + np.where(x > 0, further, 0)


@dataclass(frozen=True)
class CableReflection(Counting, Change):
    """The terminator of a cable has a loose contact, and while it is open pulses are reflected and come back a second
    time. In these events most or all counts that are large enough are counted twice.
    """

    name = "double_counting"
    source = "reflections in badly terminated signal cables"
    strength: float = strength(0.004, 0.3)
    """Share of the events with an open contact."""
    again: float = drawn(0.4, 1.0)
    """Share of the pulses that are large enough to be counted a second time."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        loose = rng.random(x.shape) < self.strength
        return x + np.where(loose, rng.binomial(x.astype(np.int64), self.again), 0)


@dataclass(frozen=True)
class OverlaidCollisions(Counting, Change):
    """Further collisions happen while an event is read out, sometimes none and sometimes several. Each lets a small
    part of its own counts fall into the event.
    """

    name = "pile_up"
    source = "out-of-time pile-up at hadron colliders"
    stage = 4
    strength: float = strength(0.06, 2.5)
    """Mean number of further collisions an event."""
    part: float = drawn(0.35, 0.9, "std")
    """Counts that one of them adds on average."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        collisions = rng.poisson(self.strength, x.shape)
        part = min(self.part * self.place.std[0] / self.mean, 1.0)
        total = x.copy()
        for k in range(1, collisions.max(initial=0) + 1):
            other = np.roll(x, k, axis=0).astype(np.int64)
            total += np.where(collisions >= k, rng.binomial(other, part), 0)
        return total


@dataclass(frozen=True)
class CountsOfAfterglow(Counting, Change):
    """The light of the event before has not quite died away when the next one begins, and its last photons are counted
    with those of the next. The shorter the time between the two happens to be, the more of them there are.
    """

    name = "pile_up"
    source = "slow scintillators, such as caesium iodide in X-ray scanners"
    stage = 4
    strength: float = strength(0.003, 0.2)
    """Decay time of the light, relative to the mean time between events, which come at random."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        left = np.exp(-rng.standard_exponential(x.shape) / self.strength)
        return x + rng.binomial(np.roll(x, 1, axis=0).astype(np.int64), left)


FAMILIES: tuple[type[Injection], ...] = (
    DecayingSource,
    WanderingStream,
    ComptonContinuum,
    DischargeTrain,
    AfterpulseChain,
    CableReflection,
    OverlaidCollisions,
    CountsOfAfterglow,
)
