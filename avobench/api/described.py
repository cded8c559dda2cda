"""What a file says of a task: enough to read and to draw what was found, and no simulator."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Box, Task
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed, Law


class Described(Task):
    """A task as the file of a fit or of a diagnosis has it. It cannot simulate, so that a file runs no code."""

    source = "read from a file"

    def __init__(self, record: dict[str, Any]) -> None:
        """`record` is what `description` gave. Raises KeyError, TypeError or ValueError for what is none."""
        self.name = str(record["name"])
        for name in ("parameter_names", "parameter_units", "feature_names", "feature_units"):
            setattr(self, name, tuple(map(str, record[name])))
        self.parameter_kinds = tuple(map(str, record.get("parameter_kinds", ())))  # older files have none
        self.num_features = int(record["num_features"])
        self.prior, self.support = Box(*record["prior"]), Box(*record["support"])
        laws = [law and Law(law[0], tuple(law[1]), tuple(map(tuple, law[2]))) for law in record.get("laws", ())]
        if laws:
            self.prior = Distributed(self.prior.low, self.prior.high, tuple(laws))
        sizes = {len(self.parameter_names), len(self.parameter_units), self.prior.dim, self.support.dim}
        if len(sizes | {len(self.parameter_kinds) or self.prior.dim}) > 1:
            raise ValueError("parameters and bounds differ in number")

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        raise UsageError(f"{self.name} was read from the file of a result, which holds no simulator; load the task")

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        raise UsageError(f"{self.name} was read from the file of a result, which holds no summary; load the task")


def description(task: Task) -> dict[str, Any]:
    """What a file keeps of a task, of plain numbers and texts."""
    names = ("name", "parameter_names", "parameter_units", "parameter_kinds", "feature_names", "feature_units")
    names += ("num_features",)
    record = {name: getattr(task, name) for name in names} | {
        box: [getattr(task, box).low, getattr(task, box).high] for box in ("prior", "support")
    }
    if isinstance(task.prior, Distributed):
        record["laws"] = [law and [law.name, law.args, law.kwds] for law in task.prior.laws]
    return record


def plain(values: Any) -> Any:
    """An array as JSON holds it, nested lists in which what is not finite is null; None stays None."""
    if values is None:
        return None
    values = np.asarray(values, float)
    return np.where(np.isfinite(values), values.astype(object), None).tolist()


def array(values: Any) -> NDArray[np.float64] | None:
    """The array of what `plain` gave, NaN where it is null."""
    return None if values is None else np.array(values, float)
