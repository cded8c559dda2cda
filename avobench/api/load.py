"""What was saved, read again: fits, diagnoses, models."""

import json
from pathlib import Path

from avobench.api.diagnosis import Diagnosed
from avobench.api.inference import KIND, Inference
from avobench.bench.plugins import registry
from avobench.tasks import Task
from avobench.tasks.arguments import checked
from avobench.tasks.errors import UsageError


@checked
def load(path: str | Path, trust: bool = False) -> Inference | Diagnosed | Task:
    """Read what `Inference.save`, `avobench infer --out`, `Diagnosed.save` or `avobench diagnose --out` wrote.

    Of the file of a fit that is the Inference, of the folder of a diagnosis the Diagnosed, and of a model.json the task
    with the effects that were found. No code is run, unless `trust` says so: then that of the task and the effects
    which a model.json names, where they are not installed. The task of a fit and of a diagnosis is what the file says
    of it, without the simulator.

    Raises
    ------
    UsageError
        If there is nothing of that kind, or if the file of a model names code and `trust` is not given.
    """
    path = Path(path)
    folder = path.parent if path.name == "diagnosis.json" else path
    try:
        if folder.is_dir():
            return Diagnosed.read(folder, trust)
        content = json.loads(path.read_bytes())
        if content["kind"] == KIND:
            return Inference.of(content)
    except OSError as error:
        raise UsageError(f"{error.filename or path} cannot be read: {error.strerror or error}") from error
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise UsageError(f"{path} is no fit, diagnosis or model that avobench saved: {error!r:.200}") from error
    return registry.build("task", registry.trusted(str(path), trust), {})
