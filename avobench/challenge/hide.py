"""One data set with hidden effects, and the answer."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shape import Injection, Place, Shape
from avobench.challenge.visibility import Visibility, visibility
from avobench.effects.catalogue import catalogue
from avobench.effects.contract import Effect, Simulate
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

LEAST_POWER = 0.3
"""Strength and shape are drawn anew, MAX_DRAWS times at most, until the best test has this power."""
MOST_DISTANCE = 50.0
"""Strength and shape are also drawn anew until chi2/ndf - 1 is at most this: a stronger effect is too easy to see."""
MAX_DRAWS = 6
"""The last draw stays as it is, so that effects that theta absorbs are among those that are hidden."""
OWN_RANGE = (0.003, 1.0)
"""Strengths of the catalogue's own shapes are log-uniform between these shares of the way from null to the bound."""
NUM_REFERENCE = 20_000
"""Events without an effect, which give the scale on which strengths are meant."""
SETS = ("own", "foreign")
"""The sources of hidden shapes: the catalogue (own), or shapes that it does not have (foreign)."""


@dataclass(frozen=True)
class OwnShape:
    """An effect of the catalogue with its parameters fixed; what an `Injection` is for foreign shapes."""

    effect: Effect
    phi: NDArray[np.float64]
    """(q,)"""

    @classmethod
    def draw(cls, family: Sequence[Effect], rng: np.random.Generator) -> "OwnShape":
        """Draw one of a family's shapes. OWN_RANGE scales its strength, whose sign is random if both are allowed."""
        choices = [shape for each in family for shape in each.shapes()]
        chosen = choices[rng.integers(len(choices))]
        phi = []
        for k, parameter in enumerate(chosen.parameters):
            low, high = parameter.low, parameter.high
            if k == 0:
                bound = rng.choice([end for end in (low, high) if end != parameter.null])
                share = np.exp(rng.uniform(*np.log(OWN_RANGE)))
                phi.append(parameter.null + share * (bound - parameter.null))
            elif parameter.logarithmic:
                phi.append(np.exp(rng.uniform(np.log(low), np.log(high))))
            else:
                phi.append(rng.uniform(low, high))
        return cls(chosen, np.array(phi))

    def stronger(self, factor: float) -> "OwnShape":
        """The same effect with its strength multiplied by a factor, within the bounds."""
        p = self.effect.parameters[0]
        strength = np.clip(p.null + factor * (self.phi[0] - p.null), p.low, p.high)
        return replace(self, phi=np.r_[strength, self.phi[1:]])

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def stage(self) -> int:
        return self.effect.stage

    @property
    def settings(self) -> dict[str, float]:
        return {parameter.name: float(v) for parameter, v in zip(self.effect.parameters, self.phi, strict=True)}

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.effect.apply(simulate, theta, np.tile(self.phi, (len(theta), 1)), rng)


@dataclass(frozen=True)
class Hidden:
    """An injection and what is known of it."""

    injection: Injection | OwnShape
    feature: str | None
    visibility: Visibility
    """How visible it is alone."""
    beside: float | None = None
    """The power with which it is seen beside the other hidden effect, of which all but the strength were known."""

    @property
    def answer(self) -> dict[str, Any]:
        """The effect as answers.json describes it."""
        has_own_shape = isinstance(self.injection, OwnShape)
        return {
            "name": self.injection.name,
            "feature": self.feature,
            "shape": self.injection.effect.shape if has_own_shape else self.injection.shape.name,
            "settings": dict(self.injection.settings),
            "distance": self.visibility.distance,
            "power": self.visibility.power,
            "beside": self.beside,
        }


def hide(
    task: Task, kind: str, num_events: int, rng: np.random.Generator, shapes: Sequence[Shape] = ()
) -> tuple[NDArray, dict[str, Any]]:
    """One data set of `kind` at a random theta of the prior, and the answer: (num_events, d), what was hidden.

    Two effects, or one that is withheld, have shapes of the catalogue or, where `shapes` are given, foreign ones, with
    even chances. The answer's `allowed` is the list of effects that solving may use, None for all of the catalogue.
    Raises UsageError where there is no effect to hide.
    """
    theta = task.prior.sample(1, rng)[0]
    at = np.tile(theta, (num_events, 1))
    answer = {"kind": kind, "set": None, "theta": theta.tolist(), "effects": [], "allowed": None}
    if kind == "none":
        return task.simulate(at, rng), answer
    source = kind if kind in SETS else str(rng.choice(SETS)) if shapes else "own"
    reference = task.simulate(at[:NUM_REFERENCE], rng)
    hidden: list[Hidden] = []
    while len(hidden) < (2 if kind == "two" else 1):
        new = _draw(task, source, theta, num_events, reference, [each.injection.name for each in hidden], rng, shapes)
        foreign = [each.injection for each in (*hidden, new) if isinstance(each.injection, Injection)]
        if sum(injection.stage == 0 for injection in foreign) > 1:
            continue  # each makes events of its own from what is generated, without the other
        hidden.append(new)
    hidden.sort(key=lambda each: each.injection.stage)
    simulate = _chain(task, hidden)
    if kind == "two":
        streams = rng.spawn(2)
        hidden = [
            replace(one, beside=_beside(task, hidden, other, theta, num_events, stream))
            for one, other, stream in zip(hidden, hidden[::-1], streams, strict=True)
        ]
    answer |= {"set": source, "effects": [each.answer for each in hidden]}
    if kind == "withheld":
        names = dict.fromkeys(effect.name for effect in catalogue(task))
        answer["allowed"] = [name for name in names if name != hidden[0].injection.name]
    return simulate(at, rng), answer


def _draw(
    task: Task,
    source: str,
    theta: NDArray[np.float64],
    num_events: int,
    reference: NDArray,
    without: list[str],
    rng: np.random.Generator,
    shapes: Sequence[Shape],
) -> Hidden:
    """A random effect of a family that is not in `without`, on events at theta (p,), visible but no toy if possible.

    A family is drawn first, then its feature, then its shape, so that none is favoured for having many of them.
    """
    catalogued: dict[tuple[str, Any], list[Effect]] = {}
    for effect in catalogue(task, reference):
        catalogued.setdefault(effect.key, []).append(effect)
    foreign: dict[tuple[str, Any], list[Shape]] = {}
    for feature in dict.fromkeys(feature for _, feature in catalogued):
        place = Place(task, feature, reference)
        for shape in shapes:
            if shape.suits(place):
                foreign.setdefault((shape.family, feature), []).append(shape)
    keys = [key for key in (catalogued if source == "own" else foreign) if key in catalogued and key[0] not in without]
    if not keys:
        raise UsageError(f"there is no effect of {source} shape to hide in events of {task.name}")
    at = np.tile(theta, (_tried(task, num_events), 1))
    family = str(rng.choice(list(dict.fromkeys(name for name, _ in keys))))
    features = [feature for name, feature in keys if name == family]
    feature = features[rng.integers(len(features))]
    for _ in range(MAX_DRAWS):
        if source == "own":
            injection = OwnShape.draw(catalogued[family, feature], rng)
        else:
            choices = foreign[family, feature]
            injection = choices[rng.integers(len(choices))].draw(Place(task, feature, reference), rng)
        strength = visibility(task, injection.measure(task.simulate, at, rng), theta, num_events, rng)
        if strength.power >= LEAST_POWER and strength.distance <= MOST_DISTANCE:
            break
    return Hidden(injection, task.labels[feature] if isinstance(feature, int) else feature, strength)


def _tried(task: Task, num_events: int) -> int:
    """The number of events from which the visibility of an effect in `num_events` events is computed."""
    return num_events if task.event_shape or task.num_features > 1 else 2 * num_events


def _beside(
    task: Task,
    hidden: list[Hidden],
    other: Hidden,
    theta: NDArray[np.float64],
    num_events: int,
    rng: np.random.Generator,
) -> float:
    """The power with which events with both hidden effects exclude `other` alone, whatever its strength."""
    x = _chain(task, hidden)(np.tile(theta, (_tried(task, num_events), 1)), rng)

    def alone(factor: float) -> Simulate:
        return partial(other.injection.stronger(factor).measure, task.simulate)

    return visibility(task, x, theta, num_events, rng, alone).power


def _chain(task: Task, hidden: list[Hidden]) -> Simulate:
    simulate: Simulate = task.simulate
    for each in hidden:
        simulate = partial(each.injection.measure, simulate)
    return simulate
