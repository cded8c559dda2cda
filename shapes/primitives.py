"""The few things that can be done to events, from which every hidden shape is declared.

A `Library` holds the shapes of one kind of events. Each of its methods is a decorator: it takes the family of the
catalogue that a shape belongs to and the ranges of its settings, and turns a function into a shape. The function's name
is that of the shape, its docstring tells a person what happens, and its arguments are

- x: the events as `Place.read` gives them: counts (n, 1), real features (n, k) in [-1, 1], images (n, rows, columns),
- at: the `Place`, with the mean, standard deviation and quantiles of events without the effect,
- by: the settings that were drawn, `by.strength` first,
- rng: the random generator.

`on` says where real features are changed: `one` of them, `any` (one, or all alike), `all` together, or the event as a
`whole` (theta).
"""

from collections.abc import Callable
from functools import partial, wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shape import Measure, Place, Range, Shape

MAX_ROUNDS = 1000
"""Events that were lost are simulated again so many times at most, before a selection is said to keep nothing."""


def log(low: float, high: float) -> Range:
    """A setting that is drawn log-uniformly."""
    return Range(low, high, log=True)


def either(low: float, high: float, *, log: bool = False) -> Range:
    """A setting of either sign."""
    return Range(low, high, log=log, either_sign=True)


def run_time(n: int) -> NDArray[np.float64]:
    """When each of n events was taken, as a share of the run: (n, 1)."""
    return ((np.arange(n) + 0.5) / max(n, 1))[:, None]


def primitive(stage: int, there: Callable[[Place], bool] = lambda place: True) -> Callable:
    """Turn what is done to events, by a shape's function f, into a method of `Library` that declares such shapes.

    They act at this stage, unless they say another one, and only at places that are `there`.
    """

    def made(measure: Callable) -> Callable:
        @wraps(measure)
        def method(self: "Library", family: str, **options: Any) -> Callable:
            return self._declare(family, stage, measure, there, options)

        return method

    return made


class Library:
    """The shapes of one kind of events, in the order of their declaration."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.shapes: list[Shape] = []

    @primitive(2)
    def map(f, simulate, theta, at, by, rng):
        """Every value is mapped to f(x, at, by, rng)."""
        x = simulate(theta, rng)
        return at.write(x, f(at.read(x), at, by, rng))

    @primitive(2)
    def flip(f, simulate, theta, at, by, rng):
        """A share `strength` of the events is changed to f(x, at, by, rng), and the others are left as they are."""
        x = simulate(theta, rng)
        changed = rng.random(len(x)) < np.abs(by.strength)
        y = at.read(x)
        y[changed] = f(y[changed], at, by, rng)
        return at.write(x, y)

    @primitive(2)
    def blur(f, simulate, theta, at, by, rng):
        """Gaussian noise is added, of standard deviation f(x, at, by, rng)."""
        x = simulate(theta, rng)
        y = at.read(x)
        return at.write(x, y + f(y, at, by, rng) * rng.standard_normal(y.shape))

    @primitive(3)
    def keep(f, simulate, theta, at, by, rng):
        """An event is kept with probability f(x, at, by, rng), and another one replaces what is lost.

        It is (n,), or (n, k) of k features, which lose events independently: their product counts.
        """
        x = simulate(theta, rng)
        lost = np.arange(len(x))
        for _ in range(MAX_ROUNDS):
            kept = np.asarray(f(at.read(x[lost]), at, by, rng))
            kept = kept.prod(axis=1) if kept.ndim == 2 else np.reshape(kept, -1)
            lost = lost[rng.random(len(lost)) >= kept]
            if not len(lost):
                return x
            x[lost] = simulate(theta[lost], rng)
        raise ValueError(f"{f.__name__} keeps next to no event")

    @primitive(4)
    def replace(f, simulate, theta, at, by, rng):
        """A share `strength` of the events is replaced by foreign ones, f(n, at, by, rng) -> (n, k)."""
        x = simulate(theta, rng)
        replaced = rng.random(len(x)) < by.strength
        y = at.read(x)
        y[replaced] = np.reshape(f(int(replaced.sum()), at, by, rng), y[replaced].shape)
        return at.write(x, y)

    @primitive(4)
    def add(f, simulate, theta, at, by, rng):
        """Counts or hits f(x, at, by, rng) are added to those of the event."""
        x = simulate(theta, rng)
        y = at.read(x)
        more = f(y, at, by, rng)
        return at.write(x, y | more if at.kind == "images" else y + more)

    @primitive(2)
    def thin(f, simulate, theta, at, by, rng):
        """Each count or hit is kept with probability f(x, at, by, rng), broadcast to the shape of x."""
        x = simulate(theta, rng)
        y = at.read(x)
        chance = np.clip(f(y, at, by, rng), 0, 1)
        if at.kind == "images":
            return at.write(x, y & (rng.random(y.shape, dtype=np.float32) < chance))
        return at.write(x, rng.binomial(y.astype(np.int64), np.broadcast_to(chance, y.shape)))

    @primitive(2)
    def branch(f, simulate, theta, at, by, rng):
        """Each count makes another one with probability f(x, at, by, rng), which makes none itself."""
        x = simulate(theta, rng)
        y = at.read(x)
        chance = np.broadcast_to(np.clip(f(y, at, by, rng), 0, 1), y.shape)
        return at.write(x, y + rng.binomial(y.astype(np.int64), chance))

    @primitive(2)
    def mask(f, simulate, theta, at, by, rng):
        """Each cell sees its hits with probability f(at, by), (rows, columns), the same for all events."""
        x = simulate(theta, rng)
        hits = at.read(x)
        return at.write(x, hits & (rng.random(hits.shape, dtype=np.float32) < f(at, by)))

    @primitive(1)
    def spread(f, simulate, theta, at, by, rng):
        """The events are made at f(theta, at, by, rng), (n, p), kept within the simulator's support."""
        box = at.task.support
        return simulate(np.clip(f(theta, at, by, rng), box.low, box.high), rng)

    @primitive(1)
    def rate(f, simulate, theta, at, by, rng):
        """The rate of counts is multiplied by f(n, at, by, rng), (n,) or (n, 1).

        An event is thinned, or events from the same theta are added to it, of which the last is thinned.
        """
        factor = np.reshape(np.maximum(f(len(theta), at, by, rng), 0), (-1, 1))
        x = simulate(theta, rng)
        total = rng.binomial(x.astype(np.int64), np.minimum(factor, 1))
        for whole in range(1, int(np.ceil(factor.max(initial=0)))):
            rows = np.flatnonzero(factor > whole)
            more = simulate(theta[rows], rng).astype(np.int64)
            total[rows] += rng.binomial(more, np.minimum(factor[rows] - whole, 1))
        return total.astype(x.dtype)

    @primitive(2)
    def overlay(f, simulate, theta, at, by, rng):
        """A second event from the same theta acts on the first: f(x, other, at, by, rng)."""
        x, other = simulate(theta, rng), simulate(theta, rng)
        return at.write(x, f(at.read(x), at.read(other), at, by, rng))

    @primitive(4)
    def pile(f, simulate, theta, at, by, rng):
        """Hits of further events are added, f(theta, at, by, rng) -> (event, place, share).

        Each of m further events is made at its place (m, p), kept within the simulator's support. A share of its hits,
        (m,) or the same for all, is seen in the event of the index (m,).
        """
        x, box = simulate(theta, rng), at.task.support
        event, place, share = f(theta, at, by, rng)
        if not len(event):
            return x
        further = at.read(simulate(np.clip(place, box.low, box.high), rng))
        share = np.broadcast_to(share, len(event))[:, None, None]
        which, row, column = np.nonzero(further & (rng.random(further.shape, dtype=np.float32) < share))
        hits = at.read(x)
        hits[event[which], row, column] = True
        return at.write(x, hits)

    @primitive(2, lambda place: place.task.num_features > 1)
    def respond(f, simulate, theta, at, by, rng):
        """Features respond to the others of the event: f(x, every, at, by, rng).

        `every` (n, d) are all features of the event, in standard deviations from their means.
        """
        x = simulate(theta, rng)
        every = (x - at.reference.mean(axis=0)) / at.reference.std(axis=0)
        return at.write(x, f(at.read(x), every, at, by, rng))

    @primitive(0, lambda place: place.task.generates == "particles")
    def particles(f, simulate, theta, at, by, rng):
        """Particles are changed before they reach the detector: f(particles, theta, time, by, rng) -> particles.

        `theta` (n, 1) and the `time` of the run (n,) are those of the events that the particles belong to.
        """
        time = run_time(len(theta))[:, 0]
        if not len(theta):
            return simulate(theta, rng)
        return at.task.simulate(theta, rng, lambda each, rows: f(each, theta[rows], time[rows], by, rng))

    def _declare(
        self, family: str, stage: int, measure: Callable, suited: Callable[[Place], bool], options: dict[str, Any]
    ) -> Callable:
        """A decorator that turns a function into a shape of this library."""
        on, suits = options.pop("on", "one"), options.pop("suits", None)
        stage = options.pop("stage", stage)
        low, high, *_ = options["strength"] if isinstance(options["strength"], tuple) else (None, None)
        ranges = {name: each if isinstance(each, Range) else Range(*each) for name, each in options.items()}
        if low is not None:
            ranges["strength"] = log(low, high)

        def there(place: Place) -> bool:
            return place.kind == self.kind and fits(place, on) and suited(place) and (suits is None or suits(place))

        def declare(f: Callable) -> Shape:
            act: Measure = partial(measure, f)
            sentence = " ".join(f.__doc__.split("\n\n")[0].split())
            shape = Shape(f.__name__, family, sentence, stage, ranges, there, act)
            self.shapes.append(shape)
            return shape

        return declare


def fits(place: Place, on: str) -> bool:
    """Whether a place is one of those that `on` asks for. Counts and images have only one."""
    if place.kind == "counts":
        return True
    if place.kind == "images":
        return place.feature is None
    one, several = isinstance(place.feature, int), place.task.num_features > 1
    together = place.feature == "all" and several
    return {"one": one, "any": one or together, "all": together, "whole": several and not one}[on]
