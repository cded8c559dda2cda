"""The new model: a task with effects added, kept as `model.json`, and accepted wherever a task is."""

import hashlib
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError

from avobench.bench import registry
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Strict
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks import Box, Task
from avobench.tasks.errors import UsageError

PRIOR_SIGMAS = 5.0
"""The prior of an effect's parameter reaches so many standard errors to either side of the fit."""
LEAST_PRIOR = 0.01
"""The same at least, as a share of the parameter's range."""


class AddedEffect(Strict):
    name: str
    feature: int | Literal["all"] | None
    shape: str
    source: str | None
    """module:Class of an effect of the user's own."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """What the data decided of it, such as which cells are dead."""


class Parameter(Strict):
    name: str
    unit: str
    value: float
    std: float
    prior: tuple[float, float]
    support: tuple[float, float]


class ModelFile(Strict):
    """The content of `model.json`."""

    kind: Literal["avobench-model"] = "avobench-model"
    schema_version: Literal[1] = 1
    name: str
    task: Union[str, "ModelFile"]
    """A name or module:Class; or the model that the effects were added to, if it is one."""
    task_settings: dict[str, Any]
    effects: list[AddedEffect]
    parameters: list[Parameter]
    """Those of the task, then those of each effect in turn."""


def describe(fit: Fit, std: NDArray[np.float64], task_spec: str, own_effects: dict[str, str]) -> ModelFile:
    """What `model.json` says of a fitted model.

    `std` (P,) are its standard errors. `own_effects` gives module:Class of the user's effects by name.
    """
    model = fit.model
    theta = model.num_theta
    base = model.task
    inner = isinstance(base, AugmentedTask)
    names = list(base.parameter_names)
    units = list(base.parameter_units)
    for effect in model.effects:
        prefix = effect.name if effect.feature is None else f"{effect.name}_{_feature(base, effect)}"
        again = sum(name.startswith(f"{prefix}_") for name in base.parameter_names)  # by a model that was found before
        names += [f"{prefix}{'_again' if again else ''}_{p.name}" for p in effect.parameters]
        units += [p.unit for p in effect.parameters]
    margin = np.maximum(PRIOR_SIGMAS * std, LEAST_PRIOR * (model.high - model.low))
    low = np.maximum(model.low, fit.params - margin)
    high = np.minimum(model.high, fit.params + margin)
    low[:theta] = np.minimum(low[:theta], base.prior.low)
    high[:theta] = np.maximum(high[:theta], base.prior.high)
    return ModelFile(
        name="-".join([base.name, *(e.name.replace("_", "-") for e in model.effects)]),
        task=base.content if inner else task_spec,
        task_settings={} if inner else registry.identity("task", task_spec, base)["task_settings"],
        effects=[kept(effect, base, own_effects.get(effect.name)) for effect in model.effects],
        parameters=[
            Parameter(
                name=names[i],
                unit=units[i],
                value=float(fit.params[i]),
                std=float(std[i]),
                prior=(float(low[i]), float(high[i])),
                support=(float(model.low[i]), float(model.high[i])),
            )
            for i in range(model.dim)
        ],
    )


def _feature(task: Task, effect: Effect) -> str:
    return "all" if effect.feature == "all" else task.labels[effect.feature]


@dataclass(frozen=True)
class AugmentedTask(Task):
    """A task with effects: its parameters are those of the task and of the effects. Made by `read`."""

    sha256: str
    """Of the file, so that a record tells which model it is of."""

    name = "model"
    source = "a task of avobench with the effects that a diagnosis added"

    @classmethod
    def read(cls, path: Path) -> "AugmentedTask":
        """The task that a `model.json` describes. Raises UsageError if it describes none."""
        try:
            text = path.read_bytes()
            content = ModelFile.model_validate_json(text)
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror or error}") from error
        except ValidationError as error:
            raise UsageError(f"{path} is not a model: {error.errors()[0]['msg']}") from error
        return cls._of(content, hashlib.sha256(text).hexdigest(), path)

    @classmethod
    def _of(cls, content: ModelFile, sha256: str, path: Path) -> "AugmentedTask":
        if isinstance(content.task, ModelFile):
            base = cls._of(content.task, sha256, path)
        else:
            base = registry.build("task", content.task, content.task_settings)
        effects = tuple(_effect(added, base, path) for added in content.effects)
        task = cls(sha256)
        own = {
            "content": content,
            "model": Model(base, effects),
            "name": content.name,
            "parameter_names": tuple(p.name for p in content.parameters),
            "parameter_units": tuple(p.unit for p in content.parameters),
            "prior": Box(*zip(*(p.prior for p in content.parameters), strict=True)),
            "support": Box(*zip(*(p.support for p in content.parameters), strict=True)),
        }
        same = ("num_features", "feature_names", "event_shape", "cyclic_axes", "dtype", "discriminator")
        own |= {name: getattr(base, name) for name in (*same, "packages", "extra")}
        for name, value in own.items():
            object.__setattr__(task, name, value)
        return task

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row: theta (n, P) -> (n, d). Raises ValueError outside the support."""
        self.require_support(theta)
        return self.model.simulate(theta, rng)

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """That of the task without effects."""
        return self.model.task.summary(x)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """Not known: NaN."""
        return np.nan


def _plain(base: Task, name: str, feature: int | str | None, source: str | None) -> Effect | None:
    """An effect as it is before it sees data; None if it does not apply to the task."""
    if source is not None:
        return registry.effect(source)
    return next((effect for effect in catalogue(base) if effect.key == (name, feature)), None)


def kept(effect: Effect, base: Task, source: str | None) -> AddedEffect:
    """What a file keeps of an effect on a task; `source` is module:Class of one of the user's own."""
    plain, settings = _plain(base, effect.name, effect.feature, source), {}
    if is_dataclass(effect):
        changed = {n for n, value in _fields(effect).items() if n != "shape" and not np.all(value == getattr(plain, n))}
        settings = TypeAdapter(type(effect)).dump_python(effect, mode="json", include=changed) if changed else {}
    return AddedEffect(name=effect.name, feature=effect.feature, shape=effect.shape, source=source, settings=settings)


def _effect(added: AddedEffect, base: Task, path: Path) -> Effect:
    """The inverse of `kept`. Raises UsageError if there is no such effect."""
    plain = _plain(base, added.name, added.feature, added.source)
    try:
        if added.settings:
            loose = replace(plain, **added.settings)  # of lists and dicts; refuses what is no setting
            plain = TypeAdapter(type(loose)).validate_python(_fields(loose))
        return next(shape for shape in plain.shapes() if shape.shape == added.shape)
    except (AttributeError, TypeError, ValidationError, StopIteration) as error:
        raise UsageError(
            f"{path} asks for {added.name} ({added.shape}), which does not apply to {base.name}"
        ) from error


def _fields(effect: Effect) -> dict[str, Any]:
    return {field.name: getattr(effect, field.name) for field in fields(effect) if field.init}
