"""What there is to choose from: tasks, methods, and the effects that a task may lack, as tables."""

import pandas as pd

from avobench.bench.plugins import registry
from avobench.effects.catalogue import catalogue
from avobench.tasks import Task
from avobench.tasks.arguments import checked


def list_tasks() -> pd.DataFrame:
    """A row for each registered task: its name, parameters, number of features and source."""
    tasks = [registry.build("task", name, {}) for name in registry.names("task")]
    rows = [(task.name, ", ".join(task.parameter_names), task.num_features, task.source) for task in tasks]
    return pd.DataFrame(rows, columns=["task", "parameters", "features", "source"]).set_index("task")


def list_methods() -> pd.DataFrame:
    """A row for each registered method: its name, its source, and whether what it needs is installed."""
    methods = [registry.build("method", name, {}) for name in registry.names("method")]
    rows = [(method.name, method.source, registry.missing_package(method) is None) for method in methods]
    return pd.DataFrame(rows, columns=["method", "source", "available"]).set_index("method")


@checked
def list_effects(task: Task | str) -> pd.DataFrame:
    """A row for each effect of the catalogue that applies to a task: what it does, its shapes and its parameters.

    Raises UsageError where there is no such task, or no catalogue for its events.
    """
    task = registry.task_of(task)
    entries, rows = catalogue(task), []
    for name in dict.fromkeys(effect.name for effect in entries):
        variants = [effect for effect in entries if effect.name == name]
        shapes = [shape for effect in variants for shape in effect.shapes()]
        rows.append(
            {
                "effect": name,
                "what": variants[0].sentence,
                "shapes": ", ".join(filter(None, dict.fromkeys(shape.shape for shape in shapes))),
                "parameters": ", ".join(dict.fromkeys(each.name for shape in shapes for each in shape.parameters)),
                "source": variants[0].source,
            }
        )
    return pd.DataFrame(rows).set_index("effect")
