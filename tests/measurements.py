"""Measured events, effects of the catalogue and what they make of events, and an effort small enough for tests."""

import numpy as np

from avobench.diagnosis.effort import Effort
from avobench.effects import Effect, Parameter
from avobench.effects.catalogue import catalogue
from avobench.tasks.function import task

LIGHT = Effort(sharpen=6, covariance=30_000)


def weeks(theta, rng):
    return rng.poisson(np.exp(theta[:, [0]]) * [1, 2, 4])


def beside(theta, rng):
    return np.column_stack([rng.normal(theta[:, 0]), rng.poisson(np.exp(theta[:, 0]))])


WEEKS = task(weeks, prior={"log_rate": (0, 3)})
"""Three counts an event."""
BESIDE = task(beside, prior={"log_rate": (0, 3)}, kinds={"x2": "count"})
"""A count beside a real number."""


def measured(task, theta, n, seed):
    """Events of a task, or of a model, at theta (p,): (n, d); and the generator that made them, for what follows."""
    rng = np.random.default_rng(seed)
    return task.simulate(np.tile(theta, (n, 1)), rng), rng


def entry(task, name, feature=..., x=None):
    """The first effect of the catalogue of this name, and on this feature if one is said."""
    return next(e for e in catalogue(task, x) if e.name == name and feature in (..., e.feature))


def shape_of(effect, shape=None):
    """The effect in the shape of this name, or in its first."""
    return next(one for one in effect.shapes() if shape in (None, one.shape))


def applied(effect, x, phi, seed=0):
    """Events (n, d) with an effect whose parameters are phi (k,), or (n, k) if each has its own."""
    phi = np.array(np.broadcast_to(phi, (len(x), np.shape(phi)[-1])))
    return effect.apply(lambda theta, rng: x[: len(theta)].copy(), phi, phi, np.random.default_rng(seed))


def with_effect(task, name, theta, phi, n, seed=0):
    """Events (n, d) with an effect of the catalogue, in its plainest shape."""
    rng = np.random.default_rng(seed)
    return entry(task, name).apply(task.simulate, np.tile(theta, (n, 1)), np.tile(phi, (n, 1)), rng)


class Own(Effect):
    """A user's effect that does what it is told."""

    name = "own"
    parameters = (Parameter("strength", 0, 1, 0, "1"),)

    def __init__(self, events):
        self.events = events

    def apply(self, simulate, theta, phi, rng):
        return self.events(simulate(theta, rng))
