"""One cell of the sweep: the inference that it stands for, and all that identifies its result."""

import json
from dataclasses import dataclass, field
from typing import Any

from avobench.bench.plugins import registry
from avobench.bench.store.record import identity_hash, require_keepable
from avobench.methods import Method
from avobench.tasks import Task
from avobench.tasks.errors import UsageError


@dataclass(frozen=True)
class Cell:
    """One inference: a task's target, a method, a repetition, under one budget and seed.

    `task` and `method` are names, `module:Class` or `file.py:Class`. `identity` holds everything that determines the
    result. Making one runs code of the task and the method; what is made can be sent to a process that runs none.
    """

    task: str
    task_settings: dict[str, Any]
    method: str
    method_settings: dict[str, Any]
    target: int
    repetition: int
    budget: int
    num_observations: int
    seed: int
    identity: dict[str, Any] = field(init=False)
    # What a sweep and a record need to know of the task and the method, so that neither must make them.
    parameter_names: tuple[str, ...] = field(init=False)
    packages: tuple[str, ...] = field(init=False)
    """Modules beyond those of avobench that the method and the task use."""
    amortised: bool = field(init=False)
    together: bool = field(init=False)
    """True if the method gains from several cells at once."""

    def __post_init__(self) -> None:
        for kind in ("task", "method"):  # a worker may have another working folder
            object.__setattr__(self, kind, registry.absolute(getattr(self, kind)))
        task, method = self.build_task(), self.build_method()
        identity = {
            **registry.identity("task", self.task, task),
            **registry.identity("method", self.method, method),
            "theta_true": registry.blamed(lambda: task.targets()[self.target].tolist(), f"task '{self.task}'"),
            **{name: getattr(self, name) for name in ("target", "repetition", "budget", "num_observations", "seed")},
        }
        try:
            object.__setattr__(self, "identity", json.loads(json.dumps(identity, allow_nan=False)))
            require_keepable(self.identity)
        except (TypeError, ValueError, RecursionError) as error:
            given = {**identity["task_settings"], **identity["method_settings"]}
            raise UsageError(f"settings must be finite numbers, texts or lists of them, got {given!r:.400}") from error
        names, theta = list(task.parameter_names), identity["theta_true"]
        if not len(names) == len(set(names)) == len(theta):
            raise UsageError(f"task '{self.task}' has targets of {len(theta)} parameters and the names {names}")
        attributes = {"parameter_names": tuple(map(str, names)), "packages": (*method.packages, *task.packages)}
        vars(self).update(attributes, amortised=bool(method.amortised), together=bool(method.together))

    def build_task(self) -> Task:
        return registry.build("task", self.task, self.task_settings)

    def build_method(self) -> Method:
        return registry.build("method", self.method, self.method_settings)

    @property
    def id(self) -> str:
        return identity_hash(self.identity)

    @property
    def label(self) -> str:
        return f"{self.identity['task']} {self.identity['method']} target {self.target} repetition {self.repetition}"
