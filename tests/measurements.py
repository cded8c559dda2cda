"""Measured events for tests of a diagnosis, and an effort that is small enough for them."""

import numpy as np

from avobench.diagnosis.effort import Effort
from avobench.effects import Effect, Parameter
from avobench.effects.catalogue import catalogue

LIGHT = Effort(sharpen=6, covariance=30_000)


def measured(task, theta, n, seed):
    """Events of a task, or of a model, at theta (p,): (n, d); and the generator that made them, for what follows."""
    rng = np.random.default_rng(seed)
    return task.simulate(np.tile(theta, (n, 1)), rng), rng


def with_effect(task, name, theta, phi, n, seed=0):
    """Events (n, d) with an effect of the catalogue, in its plainest shape."""
    effect = next(e for e in catalogue(task) if e.name == name)
    rng = np.random.default_rng(seed)
    return effect.apply(task.simulate, np.tile(theta, (n, 1)), np.tile(phi, (n, 1)), rng)


class Own(Effect):
    """A user's effect that does what it is told."""

    name = "own"
    parameters = (Parameter("strength", 0, 1, 0, "1"),)

    def __init__(self, events):
        self.events = events

    def apply(self, simulate, theta, phi, rng):
        return self.events(simulate(theta, rng))
