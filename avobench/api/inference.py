"""One inference on a user's own events, from Python as from the command line."""

import html
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.estimates import require_recordable
from avobench.bench.cells.streams import stream
from avobench.bench.events.checks import SHARE, check_events
from avobench.bench.plugins import registry
from avobench.bench.processes.apart import apart_within
from avobench.bench.store.versions import versions
from avobench.effects.pool import Counted
from avobench.methods import Estimate, Method
from avobench.reports.numbers import with_error
from avobench.tasks import Task
from avobench.tasks.errors import UsageError, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DEFAULTS = ("avo", "smm")
"""The first of these methods whose packages are installed is the default; `smm` needs none."""


@dataclass(frozen=True, repr=False)
class Inference:
    """What a method found for the parameters of a task behind a set of events; shows itself in a notebook."""

    task: Task
    method: Method
    estimate: Estimate
    num_events: int
    """Observed."""
    num_simulations: int
    """Simulated events that it took."""
    seconds: float
    seed: int
    warnings: tuple[str, ...] = ()
    """What may be wrong with the events, a sentence each."""

    @property
    def theta(self) -> dict[str, float]:
        """The best fit by name of the parameter, in raw units."""
        return dict(zip(self.task.parameter_names, self.estimate.theta.tolist(), strict=True))

    @property
    def std(self) -> dict[str, float]:
        """The standard errors by name of the parameter where the method knows them, else the spread of `spread_of`."""
        return dict(zip(self.task.parameter_names, self._spread.tolist(), strict=True))

    @property
    def std_of(self) -> str:
        """What `std` is: "standard error", "posterior" or "proposal"."""
        return "standard error" if self.estimate.error is not None else self.estimate.spread_of

    @property
    def _spread(self) -> NDArray[np.float64]:
        return self.estimate.std if self.estimate.error is None else self.estimate.error

    def to_frame(self) -> pd.DataFrame:
        """A row a parameter: value, std, unit, and the ends of its prior."""
        prior = self.task.prior
        return pd.DataFrame(
            {
                "value": self.estimate.theta,
                "std": self._spread,
                "unit": self.task.parameter_units,
                "prior_low": prior.low,
                "prior_high": prior.high,
            },
            index=pd.Index(self.task.parameter_names, name="parameter"),
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trace, of plain numbers and texts."""
        return {
            "task": self.task.name,
            "method": self.method.name,
            "theta": self.theta,
            "std": {name: value if np.isfinite(value) else None for name, value in self.std.items()},
            "std_of": self.std_of,
            "units": dict(zip(self.task.parameter_names, self.task.parameter_units, strict=True)),
            "how": self.estimate.how,
            "message": self.estimate.message,
            "doubt": self.estimate.doubt,
            "warnings": list(self.warnings),
            "num_events": self.num_events,
            "num_simulations": self.num_simulations,
            "seconds": self.seconds,
            "seed": self.seed,
            "versions": versions(),
        }

    def plot(self) -> "Figure":
        """The estimate of each parameter against the number of simulated events, with its spread as a band."""
        from avobench.reports.trace import draw

        return draw(self.task, self.estimate)

    def __str__(self) -> str:
        """A line for each parameter, a doubt of the method where it has one, and what the fit took."""
        found = zip(self.theta.items(), self._spread, self.task.parameter_units, strict=True)
        lines = [
            f"{name} = {with_error(value, std)}{'' if unit == '1' else ' ' + unit}"
            for (name, value), std, unit in found
        ]
        doubt = [f"doubtful: {self.estimate.doubt}"] if self.estimate.doubt else []
        notes = [f"note: {note}" for note in (*self.warnings, self.estimate.message) if note]
        return "\n".join([*lines, *doubt, self.how, *notes])

    @property
    def how(self) -> str:
        """A line that says how the numbers came about."""
        return (
            f"{self.method.name} on {self.num_events} events: {self.estimate.how} ± {self.std_of}; "
            f"{self.num_simulations} simulated events, {self.seconds:.1f} s"
        )

    def __repr__(self) -> str:
        return str(self)  # what a prompt shows; of all fields it would be pages

    def _repr_html_(self) -> str:
        table = self.to_frame().to_html(float_format=lambda value: f"{value:.5g}", border=0)
        doubt = f"<p><strong>doubtful</strong>: {html.escape(self.estimate.doubt)}</p>" if self.estimate.doubt else ""
        return f"<p>{html.escape(f'{self.task.name}, {self.how}')}</p>{doubt}{table}"


def infer(
    task: Task | str,
    x: ArrayLike,
    method: Method | str | None = None,
    *,
    budget: int = 160_000,
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    drop_invalid: bool = False,
    seconds: float | None = None,
) -> Inference:
    """Infer the parameters of a task behind observed events, in this process unless `seconds` is given.

    Parameters
    ----------
    task
        A task, or its name, `module:Class` or `path/to/file.py:Class`.
    x
        Observed events (N, d), or (N,) where an event is one number.
    method
        A method, or its name, such as "avo", "abc-smc" or "bolfi". By default it is `avo` where PyTorch is
        installed, and otherwise `smm`, which needs no more than the base install.
    budget
        Simulated events, at most. A twentieth of them at most goes into a check of events and simulator.
    seed
        Of all that is random. The same seed gives the same estimate.
    settings
        Of the method, where it is given by name.
    drop_invalid
        Leave out rows that hold NaN or infinite values.
    seconds
        Works in a process of its own, with one thread, and ends it after so long; the task is sent there.

    Raises
    ------
    UsageError
        If there is no such task or method, if the events are not those of the task, or the budget is too small.
    SimulatorError
        If the simulator fails; SupportError, BudgetExhausted or InvalidEstimate if the method does.
    ProcessEnded
        If the process took longer than `seconds`, or was ended by what it ran.
    """
    if seconds is not None:
        options = {"budget": budget, "seed": seed, "settings": settings, "drop_invalid": drop_invalid}
        return apart_within(seconds, infer, task, x, method, **options)
    if isinstance(task, str):
        task = registry.build("task", task, {})
    budget, seed = whole("budget", budget, 1), whole("seed", seed, 0)
    if method is None:
        method = next(name for name in DEFAULTS if registry.missing_package(registry.load("method", name)) is None)
    if isinstance(method, str):
        method = registry.build("method", method, dict(settings or {}))
    elif settings:
        raise UsageError("settings are for a method given by name; give them to the class otherwise")
    for kind, subject in (("task", task), ("method", method)):
        registry.require_packages(kind, subject)
    least = method.min_simulations(task.prior.dim)
    if budget < least:
        raise UsageError(f"a budget of {budget} is too small for {method.name} on {task.name}: at least {least}")
    checks = Counted(task)
    room = min(budget, SHARE * (budget - least))
    x_observed, warnings = check_events(
        task, x, drop_invalid=drop_invalid, diagnosis=False, simulate=checks, limit=room
    )
    start = time.perf_counter()
    simulate = MeteredSimulator(task, budget - checks.used, stream(seed, "simulator", task.name, method.name))
    problem = pose(task, x_observed, simulate)
    estimate = method.infer(problem, stream(seed, "method", task.name, method.name))
    require_recordable(estimate, problem, simulate.used)
    seconds = time.perf_counter() - start
    return Inference(
        task, method, estimate, len(x_observed), checks.used + simulate.used, seconds, seed, tuple(warnings)
    )
