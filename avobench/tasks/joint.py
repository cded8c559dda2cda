"""Several simulators with one theta as one: an event has the features of one event of each."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Box, Task
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed, Law


class JointTask(Task):
    """The tasks of several data sets side by side; parameters of one name are one parameter.

    A parameter that is not shared, though others have its name, is named `set: parameter`, as all features are.
    """

    name: ClassVar = "joint"
    source: ClassVar = "several data sets"
    by_default: ClassVar = False

    def __init__(self, tasks: Mapping[str, Task], shared: Sequence[str] | None = None) -> None:
        """Share the parameters of these names, or all that several tasks have.

        Raises UsageError for a single task, images, names not in two tasks, and parameters of one name that differ.
        """
        if len(tasks) < 2:
            raise UsageError(f"joint takes two data sets at least, got {len(tasks)}")
        self.names, self.tasks = tuple(tasks), tuple(tasks.values())
        for name, task in tasks.items():
            if task.event_shape:
                raise UsageError(f"{name}: joint does not take images")
        times = Counter(one for task in self.tasks for one in task.parameter_names)
        several = [one for one, count in times.items() if count > 1]
        for one in shared or ():
            if one not in several:
                message = f"no two data sets have a parameter '{one}' to share"
                raise UsageError(f"{message}; they have: {', '.join(several)}")
        self.shared = tuple(several if shared is None else shared)
        first: dict[str, tuple[Task, int]] = {}
        self._theta: list[list[int]] = []
        """Which of all parameters those of each task are."""
        for name, task in tasks.items():
            names = [one if one in self.shared or times[one] == 1 else f"{name}: {one}" for one in task.parameter_names]
            for k, one in enumerate(names):
                _require_alike(one, first.setdefault(one, (task, k)), (task, k))
            self._theta.append([list(first).index(one) for one in names])
        self.parameter_names = tuple(first)
        self.parameter_units = tuple(task.parameter_units[k] for task, k in first.values())
        kinds = [(task.parameter_kinds or ("continuous",) * len(task.parameter_names))[k] for task, k in first.values()]
        self.parameter_kinds = tuple(kinds) if "integer" in kinds else ()
        self.prior, self.support = (self._common(which) for which in ("prior", "support"))
        self.num_features = sum(task.num_features for task in self.tasks)
        ends = np.cumsum([0, *(task.num_features for task in self.tasks)]).tolist()
        self.columns = tuple(slice(a, b) for a, b in pairwise(ends))
        """Where the features of each set are."""
        self.feature_names = tuple(f"{name}: {label}" for name, task in tasks.items() for label in task.labels)
        self.feature_kinds = tuple(kind for task in self.tasks for kind in task.kinds_of_features)
        units = [task.feature_units or ("1",) * task.num_features for task in self.tasks]
        self.feature_units = tuple(unit for each in units for unit in each)
        each = zip(self.columns, self.tasks, strict=True)
        self.missing = tuple(at.start + j for at, task in each for j in task.missing)
        self.dtype = np.result_type(*(np.dtype(task.dtype) for task in self.tasks))

    @property
    def parts(self) -> tuple[object, ...]:
        return (*self.tasks, repr(self.names), repr(self.shared))

    def _common(self, which: str) -> Box:
        low, high = np.full(len(self.parameter_names), -np.inf), np.full(len(self.parameter_names), np.inf)
        for task, at in zip(self.tasks, self._theta, strict=True):
            box = getattr(task, which)
            low[at], high[at] = np.maximum(low[at], box.low), np.minimum(high[at], box.high)
        for name, a, b in zip(self.parameter_names, low, high, strict=True):
            if a >= b:
                raise UsageError(f"the {which}s of {name} do not overlap: the data sets cannot share it")
        box = Box(tuple(low.tolist()), tuple(high.tolist()))
        laws = self._laws(box) if which == "prior" else ()
        return Distributed(box.low, box.high, laws) if any(laws) else box

    def _laws(self, box: Box) -> tuple[Law | None, ...]:
        """The law of each parameter, None where all its priors are uniform. Raises UsageError where they differ."""
        laws: list[Law | None] = [None] * box.dim
        for task, at in zip(self.tasks, self._theta, strict=True):
            for k, law in zip(at, task.prior.laws if isinstance(task.prior, Distributed) else (), strict=False):
                if law and ((laws[k] or law) != law or law.ends != (box.low[k], box.high[k])):
                    raise UsageError(f"the priors of {self.parameter_names[k]} differ: give all data sets the same one")
                laws[k] = law or laws[k]
        return tuple(laws)

    def theta_of(self, k: int, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The parameters of the k-th task: (n, p) -> (n, p_k)."""
        return np.ascontiguousarray(theta[:, self._theta[k]])

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event of each set per row: theta (n, p) -> (n, d). Raises ValueError outside the support."""
        self.require_support(theta)
        return np.hstack([task.simulate(self.theta_of(k, theta), rng) for k, task in enumerate(self.tasks)])

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """The summaries of the sets, one after the other: (n, d) -> (k,)."""
        each = zip(self.tasks, self.columns, strict=True)
        return np.concatenate([task.summary(x[:, at].astype(task.dtype)) for task, at in each])


def _require_alike(name: str, one: tuple[Task, int], other: tuple[Task, int]) -> None:
    units = [task.parameter_units[k] for task, k in (one, other)]
    if units[0] != units[1]:
        raise UsageError(f"{name} is in {units[0]} in one data set and in {units[1]} in another: convert it")
    if len({bool(task.is_integer[k]) for task, k in (one, other)}) > 1:
        raise UsageError(f"{name} is a whole number in one data set and not in another")
