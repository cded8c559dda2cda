"""The file of a model, `model.json`: a task with effects added, which is accepted wherever a task is."""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.rejection import must_record
from avobench.tasks import Box, Task
from avobench.tasks.contract import NAME
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed, Law

EFFECT_NAME = r"[A-Za-z0-9_]+"
"""The names that an effect may have."""

FindTask = Callable[[str, dict[str, Any]], Task]
"""The task of a name, or of a module and class, with settings. Raises UsageError for one that may not be used."""
FindEffect = Callable[[str], Effect]
"""The effect of a module and class. Raises UsageError for one that may not be used."""


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class AddedEffect(Strict):
    name: str = Field(pattern=f"^{EFFECT_NAME}$")
    feature: int | str | None
    """A column, "all", or the name of a parameter of the task."""
    shape: str
    source: str | None
    """module:Class or file.py:Class of an effect of the user's own."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """What the data decided of it, such as which cells are dead."""


class Parameter(Strict):
    name: str
    unit: str
    value: float
    std: float
    prior: tuple[float, float]
    support: tuple[float, float]
    law: Law | None = None
    """Its distribution between the ends of the prior, where that is not uniform."""


class ModelFile(Strict):
    """The content of `model.json`."""

    kind: Literal["avobench-model"] = "avobench-model"
    schema_version: Literal[1] = 1
    name: str = Field(pattern=f"^{NAME}$")
    task: Union[str, "ModelFile"]
    """A name, module:Class or file.py:Class; or the model that the effects were added to, if it is one."""
    task_settings: dict[str, Any]
    effects: list[AddedEffect]
    parameters: list[Parameter]
    """The parameters of the task, then those of each effect in turn."""


@dataclass(unsafe_hash=True)
class AugmentedTask(Task):
    """A task with effects: its parameters are those of the task and of the effects. Made by `read`."""

    sha256: str
    """Checksum of the file or of its content, so that a record tells which model it is of."""

    name = "model"
    source = "a task of avobench with the effects that a diagnosis added"

    @classmethod
    def read(cls, path: Path, find_task: FindTask, find_effect: FindEffect) -> "AugmentedTask":
        """The task that a `model.json` describes. Raises UsageError.

        A file may come from anywhere: `find_task` and `find_effect` decide what may be imported.
        """
        try:
            text = path.read_bytes()
            content = ModelFile.model_validate_json(text)
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror or error}") from error
        except ValidationError as error:
            raise UsageError(f"{path} is not a model: {_fault(error)}") from error
        levels, sha256 = [content], hashlib.sha256(text).hexdigest()
        while isinstance(levels[-1].task, ModelFile):
            levels.append(levels[-1].task)
        task = find_task(levels[-1].task, levels[-1].task_settings)
        for level in reversed(levels):
            task = cls.of(level, task, find_effect, sha256, str(path))
        return task

    @classmethod
    def of(
        cls,
        content: ModelFile,
        base: Task,
        find_effect: FindEffect,
        sha256: str = "",
        path: str = "the model",
        entries: list[Effect] | None = None,
    ) -> "AugmentedTask":
        """The task `base` with the effects of a file's content. Raises UsageError if it has none such, naming `path`.

        `entries` are those of the catalogue for `base` where they are known, so that nothing is simulated for them.
        """
        effects = tuple(_effect(added, base, path, find_effect, entries) for added in content.effects)
        model = Model(base, effects)
        task = cls(sha256 or hashlib.sha256(content.model_dump_json().encode()).hexdigest())
        if len(content.parameters) != model.dim:
            raise UsageError(f"{path} gives {len(content.parameters)} parameters to a model of {model.dim}")
        task.copy_events_of(base)
        task.content, task.model, task.name, task.tasks = content, model, content.name, (base,)
        task.parameter_names = tuple(p.name for p in content.parameters)
        task.parameter_units = tuple(p.unit for p in content.parameters)
        if kinds := base.parameter_kinds:
            task.parameter_kinds = (*kinds, *("continuous",) * (model.dim - len(kinds)))
        task.per_theta = getattr(base, "per_theta", False)
        try:
            task.prior, task.support = (
                Box(*zip(*(getattr(p, box) for p in content.parameters), strict=True)) for box in ("prior", "support")
            )
            if any(laws := tuple(p.law for p in content.parameters)):
                task.prior = Distributed(task.prior.low, task.prior.high, laws)
        except ValueError as error:
            raise UsageError(f"{path} is not a model: {error}") from error
        return task

    @property
    def parts(self) -> tuple[object, ...]:
        return (self.model.task, *self.model.effects)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row: theta (n, P) -> (n, d). Raises ValueError outside the support.

        Raises SimulatorError where its detector records none of them.
        """
        self.require_support(theta)
        with must_record():
            return self.model.simulate(theta, rng)

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """The summary of the task without effects."""
        return self.model.task.summary(x)


def _effect(added: AddedEffect, base: Task, path: str, find_effect: FindEffect, entries: list[Effect] | None) -> Effect:
    """The effect that a file keeps, with what the data decided of it. Raises UsageError if there is none."""
    if added.source is not None:
        family = [find_effect(added.source)]
    else:
        family = [effect for effect in entries or catalogue(base) if effect.key == (added.name, added.feature)]
    for plain in family:
        with suppress(AttributeError, TypeError, ValidationError):  # the settings are of another class of the family
            if added.settings:
                loose = replace(plain, **added.settings)  # of lists and dicts; refuses what is no setting
                plain = TypeAdapter(type(loose)).validate_python(settings_of(loose))
            for shape in plain.shapes():
                if shape.shape == added.shape:
                    return shape
    raise UsageError(f"{path} asks for {added.name} ({added.shape}), which does not apply to {base.name}")


def settings_of(effect: Effect) -> dict[str, Any]:
    """What the data may decide of an effect that is a dataclass."""
    return {field.name: getattr(effect, field.name) for field in fields(effect) if field.init}


def _fault(error: ValidationError) -> str:
    """What is wrong with the content of a file, and where: of a model within a model what lies deepest."""
    first = max(error.errors(), key=lambda each: len(each["loc"]))
    where = ".".join(str(each) for each in first["loc"])
    return f"{first['msg']}{f' at {where}' if where else ''}"
