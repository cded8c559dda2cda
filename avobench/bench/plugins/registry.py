"""Tasks, methods and effects by name, as `module:Class` or as `file.py:Class`, with their settings checked."""

import dataclasses
import importlib
import inspect
import os
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import joblib
from pydantic import TypeAdapter, ValidationError

from avobench.bench.plugins import user_files
from avobench.bench.plugins.source import is_ours, source_hash
from avobench.effects.catalogue import GROUP, families
from avobench.effects.contract import Effect
from avobench.effects.model_file import EFFECT_NAME, AugmentedTask
from avobench.methods import Method
from avobench.methods.device import require_device
from avobench.tasks import Task
from avobench.tasks.contract import NAME
from avobench.tasks.errors import SimulatorError, UsageError, did_you_mean, first_fault, installed_by, raised, shown

BASES = {"task": Task, "method": Method, "effect": Effect}
GROUPS = {"task": "avobench.tasks", "method": "avobench.methods", "effect": GROUP}
REQUIRED = {
    "task": ("name", "parameter_names", "parameter_units", "source", "prior", "support", "num_features"),
    "method": ("name", "source"),
    "effect": ("name", "parameters", "sentence", "source"),
}
NAMES = {
    "task": (NAME, "letters, digits, dots and dashes"),
    "method": (NAME, "letters, digits, dots and dashes"),
    "effect": (EFFECT_NAME, "letters, digits and underscores"),
}
"""The pattern of a name, which becomes a part of file names and of other names, and the pattern in words."""


class Trusted(str):
    """The path of a model file that may name code beside it; see `trusted`."""

    __slots__ = ()


def trusted(spec: str, trust: bool = True) -> str:
    """Mark `spec`, if `trust` says so, as a file that the user trusts: reading a model runs the code that it names.

    Without the mark a model may name installed tasks and effects only. It stays with the text, to worker processes too.
    """
    return Trusted(spec) if trust else spec


def absolute(spec: str) -> str:
    """`spec` as it is to be understood in a process with another working folder: paths of files are made absolute."""
    place, colon, name = spec.rpartition(":")
    if colon and place.endswith(".py"):
        return f"{os.path.abspath(place)}:{name}"
    return type(spec)(os.path.abspath(spec)) if is_model("task", spec) else spec


def names(kind: str) -> list[str]:
    """Registered names of tasks, methods or effects, sorted."""
    return sorted(families()) if kind == "effect" else sorted({point.name for point in _points(kind)})


def load(kind: str, spec: str) -> Any:
    """Load what `spec` names: a class, or an instance that a user's file has ready-made. Raises UsageError."""
    if is_model(kind, spec):
        return AugmentedTask
    loaded = imported(kind, spec) if ":" in spec else _registered(kind, spec)
    base = BASES[kind]
    if kind == "task" and inspect.isfunction(loaded):
        raise UsageError(
            f"'{spec}' is a function; write NAME = avobench.task({loaded.__name__}, prior=...) beside it and name that"
        )
    if not (isinstance(loaded, base) or (inspect.isclass(loaded) and issubclass(loaded, base))):
        raise UsageError(f"'{spec}' is not a subclass of avobench.{kind}s.{base.__name__}, nor an instance of one")
    missing = [name for name in REQUIRED[kind] if not hasattr(loaded, name)]
    missing += sorted(loaded.__abstractmethods__) if inspect.isclass(loaded) else []
    if missing:
        raise UsageError(f"{kind} '{spec}' does not define {', '.join(missing)}")
    pattern, rule = NAMES[kind]
    if not re.fullmatch(pattern, loaded.name):
        raise UsageError(f"the name of {kind} '{spec}' must be {rule}, got '{loaded.name}'")
    return loaded


def runs_theirs(kind: str, spec: str) -> bool:
    """Tell whether what `spec` names runs code that is not of this project; False too for a name that there is not."""
    if ":" in spec or is_model(kind, spec):
        return True
    return any(point.name == spec and not point.value.startswith("avobench.") for point in _points(kind))


def is_model(kind: str, spec: str) -> bool:
    return kind == "task" and spec.endswith(".json")


def build(kind: str, spec: str, settings: dict[str, Any]) -> Any:
    """An instance of the task or method `spec` with `settings`, values as text or typed. Raises UsageError."""
    loaded = load(kind, spec)
    if is_model(kind, spec):
        if settings:
            raise UsageError(f"{spec} is a model; its settings are in the file")
        return read_model(spec)
    if not inspect.isclass(loaded):
        if settings:
            raise UsageError(f"{kind} '{spec}' is ready-made; its settings are in {spec.rpartition(':')[0]}")
        return loaded
    allowed = [field.name for field in fields_of(loaded)]
    for name in settings:
        if name not in allowed:
            hint = did_you_mean(name, allowed) or f"it has: {', '.join(allowed) or 'none'}"
            raise UsageError(f"{kind} {loaded.name} has no setting '{name}'; {hint}")
    try:
        return blamed(
            lambda: TypeAdapter(loaded).validate_python(settings) if allowed else loaded(), f"{kind} '{spec}'"
        )
    except ValidationError as error:
        where, reason = first_fault(error)
        raise UsageError(f"{f'setting {where}'.strip()} of {kind} {loaded.name}: {reason}") from error


def task_of(given: Task | str) -> Task:
    if isinstance(given, str):
        return build("task", given, {})
    if not isinstance(given, Task):
        raise UsageError(f"a task is wanted, or its name, got {shown(given)}; avobench.task makes one from a function")
    return given


def read_model(spec: str) -> AugmentedTask:
    """The task of the file of a model. Raises UsageError for code that it names and the user has not trusted."""
    trust = isinstance(spec, Trusted)

    def task(name: str, settings: dict[str, Any]) -> Task:
        if is_model("task", name):  # it holds such a model itself
            raise UsageError(f"{spec} names task '{name}', which is not installed")
        return build("task", named_in(spec, "task", name, trust), settings)

    return AugmentedTask.read(Path(spec), task, lambda name: effect(named_in(spec, "effect", name, trust)))


def named_in(file: str | Path, kind: str, name: str, trust: bool) -> str:
    """The task or effect that a file names. Raises UsageError for one not installed, unless the file is trusted."""
    if ":" in name and not trust:
        raise UsageError(
            f"{file} names {kind} '{name}', and reading it would run that code: only a file that is trusted "
            "(--trust, in Python avobench.load(file, trust=True)) may name what is not installed"
        )
    if ":" not in name and not is_model(kind, name) and name not in names(kind):
        raise UsageError(f"{file} names {kind} '{name}', which is not installed")
    return trusted(name, trust)


def effect(spec: str) -> Effect:
    """The effect of a user's `module:Class` or `file.py:Class`. Raises UsageError in one line."""
    if ":" not in spec:
        raise UsageError(f"--effect takes module:Class, got '{spec}'; --effects chooses from the catalogue")
    loaded = load("effect", spec)
    return blamed(loaded, f"effect '{spec}'") if inspect.isclass(loaded) else loaded


def effect_families(name: str) -> list[type[Effect]]:
    """The installed effects of a name, which several classes may have, or of an entry point. Raises UsageError."""
    points = families()
    matches = [family for point, family in points.items() if name in (point, point.rpartition(".")[2], family.name)]
    if not matches:
        choices = points if "." in name else {point.rpartition(".")[2] for point in points}
        hint = did_you_mean(name, sorted(choices), n=3, cutoff=0.5)
        raise UsageError(f"there is no effect '{name}'; {hint}{' ' if hint else ''}`avobench list effects` shows all")
    return matches


def spec_of(kind: str, instance: Any) -> str | None:
    """The name by which another process finds a task or effect; None where there is none, as in a notebook.

    It is that of its entry point, or what the module of its class or function calls it or its class.
    """
    if isinstance(instance, AugmentedTask):
        return instance.name  # its file tells all that it is made of
    cls = type(instance)
    for point in _points(kind):
        if point.value == f"{cls.__module__}:{cls.__qualname__}":
            return point.name
    places = (place for place in places_of(kind, instance) if place[0] != "__main__")
    return next((f"{user_files.file_of(module) or module}:{name}" for module, name in places), None)


def places_of(kind: str, instance: Any) -> Iterator[tuple[str, str]]:
    """The modules in which a task or effect has a name, or its class if that alone makes it again, and these names."""
    cls = type(instance)
    functions = [part for part in getattr(instance, "parts", ()) if inspect.isfunction(part)]
    by_class = not functions and _class_tells(kind, instance)
    wanted = [instance, cls] if by_class else [instance]
    for home in dict.fromkeys(thing.__module__ for thing in (cls, *functions)):
        namespace = vars(sys.modules[home]) if home in sys.modules else {}
        yield from ((home, name) for one in wanted for name, value in list(namespace.items()) if value is one)
    if by_class and cls.__module__ == "__main__" and "." not in cls.__qualname__:
        yield "__main__", cls.__qualname__  # it was sent here from the process of the script


def _class_tells(kind: str, instance: Any) -> bool:
    """Whether the class of a task or effect makes it again, with the settings that a file keeps of a dataclass."""
    cls = type(instance)
    arguments = inspect.signature(cls).parameters.values()
    if kind == "task" and (dataclasses.is_dataclass(cls) or not arguments):
        return True
    if any(
        each.default is each.empty and each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD) for each in arguments
    ):
        return False
    try:
        return dataclasses.is_dataclass(cls) or joblib.hash(vars(cls())) == joblib.hash(vars(instance))
    except Exception:  # a user's class may raise anything, and hold what has no hash
        return not arguments


def identity(kind: str, spec: str, instance: Any) -> dict[str, Any]:
    """All that determines the behaviour of a task or method: name, version, settings, and the source if it is not ours.

    A setting with the metadata `{"identifies": "unless default"}` is left out at its default, so one added later keeps
    old results.
    """
    parts = {kind: instance.name, f"{kind}_version": instance.version, f"{kind}_settings": settings_of(instance)}
    if source := blamed(partial(source_hash, made_of(instance)), f"{kind} '{spec}'"):
        parts[f"{kind}_source_sha256"] = source
    return parts


def settings_of(instance: Any) -> dict[str, Any]:
    """The settings of a task or method by name, as they identify it."""
    return {
        f.name: getattr(instance, f.name)
        for f in fields_of(instance)
        if not (f.metadata.get("identifies") == "unless default" and getattr(instance, f.name) == f.default)
    }


def fields_of(thing: Any) -> list[dataclasses.Field]:
    """The settings that a class of tasks or methods, or one of them, may be given."""
    return [field for field in dataclasses.fields(thing) if field.init] if dataclasses.is_dataclass(thing) else []


def made_of(instance: Any) -> list[Any]:
    """The objects that `source_hash` reads of a task, method or effect, and of the parts of a task, at any depth.

    Settings and parts, and what a model file says of an effect, identify it elsewhere: then its class is enough.
    """
    parts = [one for part in instance.parts for one in made_of(part)] if isinstance(instance, Task) else []
    kinds = isinstance(instance, Task | Method | Effect)
    by_class = isinstance(instance, Effect) or dataclasses.is_dataclass(instance) or is_ours(type(instance))
    return [type(instance) if kinds and by_class else instance, *parts]


def missing_package(instance: Any) -> str | None:
    """The first package that a task or method needs and that is not installed; None where nothing is missing."""
    return next((package for package in instance.packages if find_spec(package) is None), None)


def require_packages(kind: str, instance: Any) -> None:
    """Raise UsageError when a package that the task or method needs is not installed, or its device is not there."""
    if package := missing_package(instance):
        how = f": {installed_by(instance.extra)}" if instance.extra else ""
        raise UsageError(f"{kind} {instance.name} needs {package}, which is not installed{how}")
    if kind == "method" and getattr(instance, "device", "cpu") == "cuda" and find_spec("torch") is not None:
        try:
            require_device("cuda")
        except ValueError as error:
            raise UsageError(f"method {instance.name} with device=cuda: {error}") from error


def blamed(make: Callable[[], Any], what: str) -> Any:
    """The value of `make()`; what a user's class raises becomes a UsageError that names it."""
    try:
        return make()
    except (UsageError, SimulatorError, ValidationError):
        raise
    except (Exception, SystemExit) as error:
        raise UsageError(f"{what} cannot be used, it raised {raised(error)}") from error


@cache
def _points(kind: str) -> tuple[EntryPoint, ...]:
    """The entry points, looked for once a process: in every installed distribution, which outlasts a small cell."""
    return tuple(entry_points(group=GROUPS[kind]))


def _registered(kind: str, name: str) -> Any:
    choices = names(kind)
    if name not in choices:
        hint = did_you_mean(name, choices, cutoff=0.4) or f"known: {', '.join(choices)}, module:Class or file.py:Class"
        raise UsageError(f"there is no {kind} named '{name}'; {hint}")
    if kind == "effect":
        return families()[name]
    return blamed(next(point for point in _points(kind) if point.name == name).load, f"{kind} '{name}'")


def imported(kind: str, spec: str) -> Any:
    """The object of a module or file that `spec` names; a module beside the user comes first. Raises UsageError."""
    place, _, name = spec.rpartition(":")
    module_name = place
    if place.endswith(".py"):
        if not Path(place).is_file():
            raise UsageError(f"there is no file '{place}', for {kind} '{spec}'")
        module_name = user_files.module_name(place)
    elif (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name != module_name:
            raise UsageError(f"{kind} '{spec}' needs {error.name}, which is not installed") from error
        raise UsageError(f"there is no module '{place}' here or installed, for {kind} '{spec}'") from error
    except (Exception, SystemExit) as error:
        raise UsageError(f"{place} of {kind} '{spec}' raised {raised(error)}") from error
    if not hasattr(module, name):
        raise UsageError(
            "; ".join(filter(None, (f"{place} has no '{name}'", did_you_mean(name, _of_kind(kind, module)))))
        )
    return getattr(module, name)


def _of_kind(kind: str, module: ModuleType) -> list[str]:
    """The names of a module that may be meant by one of a task, method or effect."""
    base, home = BASES[kind], module.__name__
    meant = {name: value for name, value in vars(module).items() if isinstance(value, base) or callable(value)}
    return [name for name, value in meant.items() if isinstance(value, base) or value.__module__ == home]
