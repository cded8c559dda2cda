from types import SimpleNamespace

import numpy as np
import pytest

from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects import Effect, Parameter
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson


class Thinned(Effect):
    """Each of n counts survives with probability 1 / (1 + tau n): a dead time in rough, with a second solution."""

    name = "dead_time"
    parameters = (Parameter("tau", 0, 1, 0, "of the window, a count"),)
    sentence, source = "High counts are reduced most.", "test"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        x[:, 0] = rng.binomial(x[:, 0], 1 / (1 + phi[:, 0] * x[:, 0]))
        return x


@pytest.fixture(scope="session")
def counter() -> SimpleNamespace:
    """A counter near its highest rate: two pairs of log rate and dead time give nearly the same counts."""
    effect, truth = Thinned(), SimpleNamespace(weak=[0.39, 0.062], strong=[2.38, 0.675])
    rng = np.random.default_rng(1)
    model = Model(Poisson(), (effect,))
    x = model.simulate(np.tile(truth.strong, (8000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)

    def fitted(model, params):
        point = model.to_cube(np.array(params))
        half = np.minimum(model.reach(point), 0.01)
        return refine(model, target, point, half, np.random.default_rng(2), num_events=30_000)

    fits = {name: fitted(model, params) for name, params in vars(truth).items()}
    null = fitted(Model(Poisson()), [0.24])
    return SimpleNamespace(x=x, target=target, effect=effect, truth=truth, null=null, **fits)
