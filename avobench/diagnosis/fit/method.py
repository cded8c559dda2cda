"""Theta as a registered method finds it: where the fit of a diagnosis may begin."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.plugins import registry
from avobench.diagnosis.fit.fit import Fit
from avobench.effects.model import Model
from avobench.methods import Estimate
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

METHOD_EVENTS = 160_000
"""The budget of a method that looks for theta, as in the benchmark."""


@dataclass(frozen=True)
class Inferred:
    """What a registered method found for theta."""

    method: str
    task: Task
    estimate: Estimate
    num_simulations: int

    @classmethod
    def by(cls, name: str, task: Task, x: NDArray, num_events: int | None, rng: np.random.Generator) -> "Inferred":
        """From events x (N, d), with at most so many simulated ones, and METHOD_EVENTS.

        Raises UsageError for an unknown method and for too few events.
        """
        num_events = METHOD_EVENTS if num_events is None else min(num_events, METHOD_EVENTS)
        method = registry.build("method", name, {})
        registry.require_packages("method", method)
        least = method.min_simulations(len(task.parameter_names))
        if num_events < least:
            raise UsageError(f"--fit {name} needs at least {least} simulated events, got {num_events}")
        simulate = MeteredSimulator(task, num_events, rng.spawn(1)[0])
        estimate = method.infer(pose(task, x, simulate), rng.spawn(1)[0])
        return cls(name, task, estimate, simulate.used)

    def centre(self, model: Model) -> NDArray[np.float64]:
        """The estimate in the unit cube of the task's own model (p,)."""
        return model.to_cube(np.clip(self.estimate.theta, model.low, model.high))

    def note(self, fit: Fit) -> str:
        """It beside a fit: a proposal much wider than the error warns that the model is wrong."""
        estimate = self.estimate
        each = zip(self.task.parameter_names, estimate.theta, estimate.std, fit.std, strict=False)
        parts = [
            f"{p} = {theta:.4g} with a {estimate.spread_of} of width {width:.2g}, {width / error:.1f} errors of the fit"
            for p, theta, width, error in each
        ]
        return f"{self.method} found {'; '.join(parts)}"
