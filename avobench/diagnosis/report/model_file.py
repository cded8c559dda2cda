"""The model that a diagnosis leaves, as the content of `model.json`."""

from collections.abc import Mapping
from dataclasses import is_dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from avobench.bench.plugins import registry
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.settings import REPORT
from avobench.effects import Effect
from avobench.effects.model_file import AddedEffect, AugmentedTask, ModelFile, Parameter, settings_of
from avobench.tasks import Task
from avobench.tasks.prior import Distributed


def describe(
    fit: Fit, std: NDArray[np.float64], task_spec: str, user_effects: Mapping[str, tuple[str | None, Effect]]
) -> ModelFile:
    """What `model.json` says of a fitted model.

    `std` (P,) are its standard errors. `user_effects` holds the user's effects by name: how each is found again, or
    None, and the effect before it has seen data.
    """
    model = fit.model
    theta = model.num_theta
    base = model.task
    inner = isinstance(base, AugmentedTask)
    names = list(base.parameter_names)
    for effect in model.effects:
        feature = named(effect.key, base.labels).feature
        prefix = effect.name if feature is None else f"{effect.name}_{feature}"
        again = sum(name.startswith(f"{prefix}_") for name in base.parameter_names)  # by a model that was found before
        names += [f"{prefix}{'_again' if again else ''}_{p.name}" for p in effect.parameters]
    margin = np.maximum(REPORT.prior_sigmas * std, REPORT.least_prior * (model.high - model.low))
    low = np.maximum(model.low, fit.params - margin)
    high = np.minimum(model.high, fit.params + margin)
    low[:theta] = np.minimum(low[:theta], base.prior.low)
    high[:theta] = np.maximum(high[:theta], base.prior.high)
    laws = [*base.prior.laws] if isinstance(base.prior, Distributed) else []
    for j, law in enumerate(laws):
        low[j], high[j] = (low[j], high[j]) if law is None else law.ends
    return ModelFile(
        name="-".join([base.name, *(e.name.replace("_", "-") for e in model.effects)]),
        task=base.content if inner else registry.absolute(task_spec),
        task_settings={} if inner else registry.settings_of(base),
        effects=[kept(effect, base, *user_effects.get(effect.name, (None, None))) for effect in model.effects],
        parameters=[
            Parameter(
                name=names[i],
                unit=model.units[i],
                value=float(fit.params[i]),
                std=float(std[i]),
                prior=(float(low[i]), float(high[i])),
                support=(float(model.low[i]), float(model.high[i])),
                law=laws[i] if i < len(laws) else None,
            )
            for i in range(model.dim)
        ],
    )


def kept(effect: Effect, base: Task, source: str | None = None, original: Effect | None = None) -> AddedEffect:
    """What a file keeps of an effect on a task.

    For one of the user's effects, `original` is the effect before it has seen data. `source` says how it is found
    again: module:Class or file.py:Class, or its name where there is neither.
    """
    names, settings = set(settings_of(effect)) - {"shape"} if is_dataclass(effect) else set(), {}
    if original is not None:
        source = registry.absolute(source or effect.name)
        names = {name for name in names if not np.all(getattr(effect, name) == getattr(original, name))}
    if names:
        settings = TypeAdapter(type(effect)).dump_python(effect, mode="json", include=names)
    return AddedEffect(name=effect.name, feature=effect.feature, shape=effect.shape, source=source, settings=settings)
