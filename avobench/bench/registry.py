"""Tasks and methods by name (entry points) or as `module:Class`, with their settings checked."""

import dataclasses
import difflib
import hashlib
import importlib
import inspect
import re
import sys
from collections.abc import Callable
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from avobench.effects.contract import Effect
from avobench.methods import Method
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

BASES = {"task": Task, "method": Method}  # of what has a name in an entry point
GROUPS = {"task": "avobench.tasks", "method": "avobench.methods"}
REQUIRED = {
    "task": ("name", "parameter_names", "parameter_units", "source", "prior", "support", "num_features"),
    "method": ("name", "source"),
}


def names(kind: str) -> list[str]:
    """Registered names of tasks or methods, sorted."""
    return sorted({point.name for point in _points(kind)})


def load(kind: str, spec: str) -> type:
    """The class that `spec` names: a registered name or `module:Class`. Raises UsageError in one line."""
    if is_model(kind, spec):
        from avobench.effects.model_file import AugmentedTask  # here, because a diagnosis builds on this module

        return AugmentedTask
    if ":" in spec:
        cls = _import(kind, spec)
    else:
        points = [point for point in _points(kind) if point.name == spec]
        if not points:
            known = names(kind)
            nearest = difflib.get_close_matches(spec, known, n=1, cutoff=0.4)
            hint = f"did you mean {nearest[0]}?" if nearest else f"known: {', '.join(known)}, or module:Class"
            raise UsageError(f"there is no {kind} named '{spec}'; {hint}")
        cls = blamed(points[0].load, f"{kind} '{spec}'")
    if not (inspect.isclass(cls) and issubclass(cls, BASES[kind])):
        raise UsageError(f"'{spec}' is not a subclass of avobench.{kind}s.{BASES[kind].__name__}")
    missing = [name for name in REQUIRED[kind] if not hasattr(cls, name)] + sorted(cls.__abstractmethods__)
    if missing:
        raise UsageError(f"{kind} '{spec}' does not define {', '.join(missing)}")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]*", cls.name):
        raise UsageError(f"the name of {kind} '{spec}' must be letters, digits, dots and dashes, got '{cls.name}'")
    return cls


def is_model(kind: str, spec: str) -> bool:
    """Whether `spec` is the file of a task with effects added, as `avobench diagnose` writes it."""
    return kind == "task" and spec.endswith(".json")


def build(kind: str, spec: str, settings: dict[str, Any]) -> Any:
    """An instance of the task or method `spec` with `settings`, values as text or typed. Raises UsageError."""
    cls = load(kind, spec)
    if is_model(kind, spec):
        if settings:
            raise UsageError(f"{spec} is a model; its settings are in the file")
        return cls.read(Path(spec))
    known = [f.name for f in dataclasses.fields(cls) if f.init] if dataclasses.is_dataclass(cls) else []
    for name in settings:
        if name not in known:
            nearest = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {nearest[0]}?" if nearest else f"it has: {', '.join(known) or 'none'}"
            raise UsageError(f"{kind} {cls.name} has no setting '{name}'; {hint}")
    try:
        return blamed(lambda: TypeAdapter(cls).validate_python(settings) if known else cls(), f"{kind} '{spec}'")
    except ValidationError as error:
        first = error.errors()[0]
        where = f" {'.'.join(map(str, first['loc']))}" if first["loc"] else ""
        reason = first["msg"].removeprefix("Value error, ")
        raise UsageError(f"setting{where} of {kind} {cls.name}: {reason}") from error


def effect(spec: str) -> Effect:
    """The effect of a user's `module:Class`. Raises UsageError in one line."""
    if ":" not in spec:
        raise UsageError(f"--effect takes module:Class, got '{spec}'; --effects chooses from the catalogue")
    cls = _import("effect", spec)
    if not (inspect.isclass(cls) and issubclass(cls, Effect)):
        raise UsageError(f"'{spec}' is not a subclass of avobench.effects.Effect")
    missing = [name for name in ("name", "parameters", "sentence", "source") if not hasattr(cls, name)]
    missing += sorted(cls.__abstractmethods__)
    if missing:
        raise UsageError(f"effect '{spec}' does not define {', '.join(missing)}")
    return blamed(cls, f"effect '{spec}'")


def identity(kind: str, spec: str, instance: Any) -> dict[str, Any]:
    """What determines the behaviour of a task or method: name, version, settings, and the source if it is not ours.

    The source is that of the modules of the class and its bases; what else they import is not followed. A setting with
    the metadata `{"identifies": "unless default"}` is left out at its default, so one added later keeps old results.
    """
    fields = [f for f in dataclasses.fields(instance) if f.init] if dataclasses.is_dataclass(instance) else []
    parts = {
        kind: instance.name,
        f"{kind}_version": instance.version,
        f"{kind}_settings": {
            f.name: getattr(instance, f.name)
            for f in fields
            if not (f.metadata.get("identifies") == "unless default" and getattr(instance, f.name) == f.default)
        },
    }
    modules = dict.fromkeys(base.__module__ for base in type(instance).__mro__ if base is not object)
    theirs = [name for name in modules if not name.startswith("avobench.") and name not in sys.stdlib_module_names]
    if theirs:
        sources = [blamed(partial(inspect.getsource, sys.modules[name]), f"{kind} '{spec}'") for name in theirs]
        source = "\0".join([type(instance).__qualname__, *sources])
        parts[f"{kind}_source_sha256"] = hashlib.sha256(source.encode()).hexdigest()
    return parts


def require_packages(kind: str, instance: Any) -> None:
    """Raise UsageError when a package that the task or method needs is not installed."""
    for package in instance.packages:
        if find_spec(package) is None:
            raise UsageError(
                f"{kind} {instance.name} needs {package}, which is not installed"
                + (f": pip install 'avobench[{instance.extra}]'" if instance.extra else "")
            )


def blamed(make: Callable[[], Any], what: str) -> Any:
    """The value of `make()`; what a user's class raises on the way is a UsageError that names it."""
    try:
        return make()
    except (UsageError, ValidationError):
        raise
    except (Exception, SystemExit) as error:
        raise UsageError(f"{what} cannot be used, it raised {type(error).__name__}: {error}") from error


@cache
def _points(kind: str) -> tuple[EntryPoint, ...]:
    """Asked for once a process: it looks into every installed distribution, which takes longer than a small cell."""
    return tuple(entry_points(group=GROUPS[kind]))


def _import(kind: str, spec: str) -> Any:
    module_name, _, class_name = spec.partition(":")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)  # `my_module:MyTask` is looked for beside the user first
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name != module_name:
            raise UsageError(f"{kind} '{spec}' needs {error.name}, which is not installed") from error
        raise UsageError(f"there is no module '{module_name}' here or installed, for {kind} '{spec}'") from error
    except (Exception, SystemExit) as error:
        raise UsageError(f"{module_name} of {kind} '{spec}' raised {type(error).__name__}: {error}") from error
    if not hasattr(module, class_name):
        nearest = difflib.get_close_matches(class_name, dir(module), n=1)
        raise UsageError(f"{module_name} has no '{class_name}'" + (f"; did you mean {nearest[0]}?" if nearest else ""))
    return getattr(module, class_name)
