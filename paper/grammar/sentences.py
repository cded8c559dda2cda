"""Sentences of the grammar: a primitive, what it goes by, a random function of that, a strength, and who claims it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.experience.recogniser import OUTSIDE
from avobench.effects.contract import Simulate
from avobench.effects.rejection import accepted
from avobench.tasks import Task
from paper.grammar.functions import Function, draw, log_uniform

Array = NDArray[np.float64]
Rng = np.random.Generator
Act = Callable[[Simulate, Array, Rng], NDArray]
"""Measured events: simulate, theta (n, p), rng -> (n, d)."""
LEAST_KEPT = 0.02
"""Share of the events that a selection keeps at least: another sentence is drawn otherwise."""
ODDS = {OUTSIDE: 3.0, "spread": 0.5, "mixture": 0.5}
"""How often a family is drawn beside the others: the last two as `Effect.odds` has it, but for what few would be."""
TRIES = 30
"""Sentences that are drawn for one family, before it is said not to suit the task."""
ALL = 0.2
"""Chance that a primitive acts on all of several features alike."""


class Sentence(NamedTuple):
    """What is wrong with measured events."""

    family: str
    """Its name in the catalogue, or OUTSIDE."""
    primitive: str
    by: str
    """What it goes by: `nothing`, the `value` itself, an `other` feature, `all` features, or the `time`."""
    function: str
    """The class of the random function of that."""
    act: Act


@dataclass(frozen=True)
class Place:
    """A feature of a simulator, with a reference (m, d) that has the same theta."""

    task: Task
    reference: NDArray
    feature: int

    @cached_property
    def values(self) -> Array:
        """Of the feature in the reference, (m,)."""
        return self.reference[:, self.feature].astype(float)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Between which all but 1 % of the values lie; of a count from zero."""
        low, high = np.quantile(self.values, [0.005, 0.995])
        return (0.0, max(high, 1.0)) if self.counts else (float(low), float(max(high, low + 1e-9)))

    @property
    def counts(self) -> bool:
        return "count" in self.task.kinds_of_features

    @property
    def half(self) -> float:
        """Half of the range."""
        return (self.ends[1] - self.ends[0]) / 2

    @cached_property
    def std(self) -> float:
        return float(self.values.std())

    def unit(self, y: Array) -> Array:
        """Where values (n,) lie in the range, in [0, 1]."""
        return np.clip((y - self.ends[0]) / (2 * self.half), 0, 1)

    def at(self, u: Array) -> Array:
        """The values (n,) at places in the range."""
        return self.ends[0] + 2 * self.half * u


class Words(NamedTuple):
    """What a sentence has drawn beside its primitive."""

    f: Function
    strength: float
    sign: int
    r: Array
    """Five uniform numbers, for what else a primitive has to choose."""


class Rule(NamedTuple):
    """Which of these families claims a sentence, by its words: None where there is no clear answer."""

    families: tuple[str, ...]
    of: Callable[[Words], str | None]


Regions = dict[tuple[str, str], str | Rule]
"""By what a primitive goes by and the class of the function: the family that claims it, or a rule."""


def regions(label: str | Rule, by: str, *kinds: str) -> Regions:
    """One claim of several classes of functions."""
    return {(by, kind): label for kind in kinds}


def claimants(label: str | Rule) -> tuple[str, ...]:
    """The families that a claim may be of."""
    return (label,) if isinstance(label, str) else label.families


def nothing(label: str) -> Regions:
    """The region of a primitive that goes by nothing, claimed by one family."""
    return regions(label, "nothing", "constant")


ANYHOW = nothing(OUTSIDE)
"""The region of what no family claims, however it is done."""
Change = Callable[[Place, Array, Array, Words, Rng], Array]
"""What a primitive makes of values: the place, values (n,), places (n,) of what it goes by, its words -> (n,)."""


@dataclass(frozen=True)
class Primitive:
    """One of the things that may be done to events."""

    name: str
    regions: Regions
    strength: tuple[float, float]
    """Log-uniform; of a share at most 1 counts."""
    acts: Callable[[list[Place], str, Words, Rng], Act | None]
    """From the places, what it goes by and the words to what it does; None where it does not suit."""

    def of(self, family: str, d: int) -> list[tuple[str, str]]:
        """The regions in which this family may claim what is done to one of d features."""
        possible = [region for region in self.regions if d > 1 or region[0] not in ("other", "all")]
        return [region for region in possible if family in claimants(self.regions[region])]

    def sentence(self, region: tuple[str, str], task: Task, reference: NDArray, rng: Rng) -> Sentence | None:
        """A random sentence of a region; None where it does not suit, or where it is not clear who claims it."""
        (by, kind), label, d = region, self.regions[region], task.num_features
        words = Words(draw(kind, rng), log_uniform(*self.strength, rng), int(rng.choice([-1, 1])), rng.random(5))
        family = label if isinstance(label, str) else label.of(words)
        together = by == "all" or (d > 1 and by != "other" and rng.random() < ALL)
        features = range(d) if together else [int(rng.integers(d))]
        act = family and self.acts([Place(task, reference, j) for j in features], by, words, rng)
        return Sentence(family, self.name, by, kind, act) if act else None


class Grammar:
    """The primitives for one kind of events. Three of its methods are decorators that declare one."""

    def __init__(self) -> None:
        self.primitives: list[Primitive] = []
        self._claims: dict[int, dict] = {}

    def change(self, regions: Regions, strength: tuple[float, float], suits: Callable[[Place], bool] | None = None):
        """Values are changed, by a `Change`."""

        def declare(change: Change) -> Change:
            def acts(places: list[Place], by: str, words: Words, rng: Rng) -> Act | None:
                if suits and not all(map(suits, places)):
                    return None
                driver = driven(places[0], by, rng)

                def act(simulate: Simulate, theta: Array, rng: Rng) -> NDArray:
                    x = simulate(theta, rng)
                    changed = x.copy()
                    for at in places:
                        y = x[:, at.feature].astype(float)
                        new = change(at, y, driver(x) if by in ("other", "time") else at.unit(y), words, rng)
                        changed[:, at.feature] = np.maximum(np.rint(new), 0) if at.counts else new
                    return changed

                return act

            self.primitives.append(Primitive(change.__name__, regions, strength, acts))
            return change

        return declare

    def keep(self, regions: Regions, strength: tuple[float, float]):
        """Events are lost with the chance that a function of places (n,) and words tells, and others drawn for them."""

        def declare(lost: Callable[[Array, Words], Array]) -> Callable:
            def acts(places: list[Place], by: str, words: Words, rng: Rng) -> Act | None:
                at = places[0]

                def kept(x: NDArray, rows: NDArray) -> Array:
                    return 1 - lost(at.unit(x[:, at.feature]), words)

                if kept(at.reference, np.arange(0)).mean() < LEAST_KEPT:
                    return None
                return lambda simulate, theta, rng: accepted(simulate, theta, kept, rng)

            self.primitives.append(Primitive(lost.__name__, regions, strength, acts))
            return lost

        return declare

    def event(self, regions: Regions, strength: tuple[float, float], suits: Callable[[Task], bool] | None = None):
        """Events as a whole: act(simulate, theta, places, words, rng), for all that is neither of the others."""

        def declare(whole: Callable) -> Callable:
            def acts(places: list[Place], by: str, words: Words, rng: Rng) -> Act | None:
                if suits and not suits(places[0].task):
                    return None
                return lambda simulate, theta, rng: whole(simulate, theta, places, words, rng)

            self.primitives.append(Primitive(whole.__name__, regions, strength, acts))
            return whole

        return declare

    def claims(self, d: int) -> dict[str, list[tuple[Primitive, list[tuple[str, str]]]]]:
        """What families may claim of sentences about d features: by name, the primitives with their regions."""
        if d not in self._claims:
            labels = [label for each in self.primitives for label in each.regions.values()]
            claims = {
                name: [(each, of) for each in self.primitives if (of := each.of(name, d))]
                for name in sorted({name for label in labels for name in claimants(label)})
            }
            self._claims[d] = {name: primitives for name, primitives in claims.items() if primitives}
        return self._claims[d]

    def sentence(self, task: Task, reference: NDArray, rng: Rng) -> Sentence:
        """A random sentence about a task: the family by its ODDS, then the primitive, then its region."""
        claims = self.claims(min(task.num_features, 2))
        odds = np.array([ODDS.get(name, 1.0) for name in claims])
        while True:
            family = str(rng.choice(list(claims), p=odds / odds.sum()))
            for _ in range(TRIES):
                primitive, regions = claims[family][rng.integers(len(claims[family]))]
                drawn = primitive.sentence(regions[rng.integers(len(regions))], task, reference, rng)
                if drawn is not None and drawn.family == family:
                    return drawn


def driven(at: Place, by: str, rng: Rng) -> Callable[[NDArray], Array]:
    """What a function goes by beside the value itself: from events (n, d) to places (n,) in [0, 1]."""
    if by == "other":
        k = int(rng.choice([j for j in range(at.task.num_features) if j != at.feature]))
        other = Place(at.task, at.reference, k)
        return lambda x: other.unit(x[:, k])
    return lambda x: np.linspace(0, 1, len(x))


def one_of(r: float, options: tuple):
    """The option that a uniform number chooses."""
    return options[int(r * len(options))]


def between(r: float, low: float, high: float) -> float:
    """The number, log-uniform, that a uniform one chooses."""
    return float(low * (high / low) ** r)


def noise(n: int, r: float, rng: Rng) -> Array:
    """Errors (n,) of standard deviation 1: Gaussian, with wide tails, skewed to either side, or even."""
    side = 1 if r * 6 % 1 < 0.5 else -1
    laws = (
        lambda: rng.standard_normal(n),
        lambda: rng.standard_normal(n),
        lambda: rng.laplace(0, np.sqrt(0.5), n),
        lambda: rng.standard_t(5, n) / np.sqrt(5 / 3),
        lambda: side * (rng.gamma(1.5, size=n) - 1.5) / np.sqrt(1.5),
        lambda: rng.uniform(-np.sqrt(3), np.sqrt(3), n),
    )
    return one_of(r, laws)()


def rounded(y: Array, step: float, r: float) -> Array:
    """Values (n,) in steps: the nearest, the one below or above, or the middle between."""
    return step * one_of(r, (np.rint, np.floor, np.ceil, lambda v: np.floor(v) + 0.5))(y / step)


def chosen(u: Array, words: Words, rng: Rng) -> NDArray[np.bool_]:
    """Events (n,) that are hit: with a chance of the strength times the function."""
    return rng.random(len(u)) < min(words.strength, 1) * words.f(u)


# What acts alike on real numbers and counts, or on parameters.


def vary(simulate: Simulate, theta: Array, places: list[Place], words: Words, rng: Rng) -> NDArray:
    """A parameter is not the same in every event: it has a random distribution, or drifts with the time."""
    k, support = int(words.r[0] * theta.shape[1]), places[0].task.support
    moved = words.f(np.linspace(0, 1, len(theta))) - words.f.values.mean() if words.f.kind != "constant" else None
    width = words.strength * places[0].task.prior.width[k]
    theta = theta.copy()
    theta[:, k] += width * (noise(len(theta), words.r[1], rng) if moved is None else 3 * moved)
    return simulate(np.clip(theta, support.low, support.high), rng)


def mix(simulate: Simulate, theta: Array, places: list[Place], words: Words, rng: Rng) -> NDArray:
    """A share of the events has other parameters."""
    support, p = places[0].task.support, theta.shape[1]
    other = np.array(support.low) + words.r[:p] * support.width
    return simulate(np.where(rng.random((len(theta), 1)) < min(words.strength, 0.5), other, theta), rng)


def best(simulate: Simulate, theta: Array, places: list[Place], words: Words, rng: Rng) -> NDArray:
    """Of two or three events that with the largest, or the least, value is recorded, in a share of the cases."""
    x, j = simulate(theta, rng), places[0].feature
    for _ in range(1 + int(2 * words.r[0])):
        again = simulate(theta, rng)
        better = (words.sign * again[:, j] > words.sign * x[:, j]) & (rng.random(len(x)) < min(words.strength, 1))
        x = np.where(better[:, None], again, x)
    return x


def average(simulate: Simulate, theta: Array, places: list[Place], words: Words, rng: Rng) -> NDArray:
    """In a share of the cases the mean of an event and another one is recorded."""
    x, both = simulate(theta, rng), rng.random((len(theta), 1)) < min(words.strength, 1)
    mean = (x + simulate(theta, rng)) / 2
    return np.where(both, np.floor(mean) if places[0].counts else mean, x).astype(x.dtype)


def transposed(y: Array) -> Array:
    """Values (n,) whose first two digits have changed places."""
    size = np.abs(y) + (y == 0)
    power = 10.0 ** (np.floor(np.log10(size) + 1e-9) - 1)
    first, second = np.divmod(np.floor(size / power + 1e-9), 10)
    return np.where(y == 0, 0, np.sign(y) * (size + 9 * (second - first) * power))
