"""The plan of a sweep: the cells that a user asks for, in the order in which they are carried out."""

import json
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from avobench.bench.cells.cell import Cell
from avobench.bench.plugins import registry
from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.contract import NUM_TARGETS
from avobench.tasks.errors import SimulatorError, UsageError

MOST_CELLS = 100_000
"""The most cells of a run: as many records as the commands that read a store were measured with."""


def plan(
    tasks: list[str],
    methods: list[str],
    targets: str,
    repetitions: int,
    budget: int,
    observations: int,
    seed: int,
    settings: Sequence[str],
    device: str = "cpu",
    *,
    tried: bool = True,
) -> list[Cell]:
    """All cells, ordered so that an interrupted sweep is a complete comparison over fewer targets.

    The order is repetition, target, method as given, task as given. `targets` is text such as `0-2,7`, `settings`
    are texts NAME.SETTING=VALUE; `device` is for the methods that can use one. Simulators of the user's are `tried`
    with their generators. Raises UsageError for anything that cannot be met, before a cell begins.
    """
    for name, value in (("budget", budget), ("observations", observations), ("repetitions", repetitions)):
        if value < 1:
            raise UsageError(f"--{name} must be at least 1, got {value}")
        if value >= 2**63:
            raise UsageError(f"--{name} must be below 2^63, got {value}")
    if not 0 <= seed < 2**63:
        raise UsageError(f"--seed must lie between 0 and 2^63 - 1, got {seed}")
    indices = parse_targets(targets)
    asked = repetitions * len(indices) * len(set(methods)) * len(set(tasks))
    if asked > MOST_CELLS:
        raise UsageError(f"--repetitions {repetitions} makes {asked} cells, and a run is {MOST_CELLS} at most")
    if device != "cpu":
        settings = [*settings, *on_device(methods, device)]
    built = {kind: {} for kind in ("task", "method")}
    chosen = parse_settings(settings, {"task": tasks, "method": methods})
    for kind, specs in (("task", tasks), ("method", methods)):
        for spec in specs:
            built[kind][spec] = registry.build(kind, spec, chosen[spec])
            registry.require_packages(kind, built[kind][spec])
    for spec, method in built["method"].items():
        for task in built["task"].values():
            least = registry.blamed(partial(method.min_simulations, len(task.parameter_names)), f"method '{spec}'")
            if not isinstance(least, int):
                raise UsageError(f"min_simulations of method '{spec}' must return a whole number, got {least!r}")
            if budget < least:
                raise UsageError(f"--budget {budget} is too small for {method.name} on {task.name}: at least {least}")
    cells = [
        Cell(task, chosen[task], method, chosen[method], target, repetition, budget, observations, seed)
        for repetition in range(repetitions)
        for target in indices
        for method in dict.fromkeys(methods)
        for task in dict.fromkeys(tasks)
    ]
    # After that, as a ready-made object may change what it holds, and with it its identity, while it simulates.
    for spec, task in built["task"].items():
        if tried and ":" in spec:
            require_generator(task)
    return cells


def on_device(methods: list[str], device: str) -> list[str]:
    """The settings that put those of the methods on a device that can use one. Raises UsageError when none can."""
    classes = [registry.load("method", spec) for spec in methods]
    able = [c.name for c in classes if any(field.name == "device" for field in registry.fields_of(c))]
    if not able:
        raise UsageError(f"--device {device}: none of {', '.join(methods)} can use one")
    return [f"{name}.device={device}" for name in able]


def require_generator(task: Task) -> None:
    """Raise UsageError when a user's simulator does not draw from its generator alone; one that fails is left."""
    theta = registry.blamed(partial(task.prior.sample, 200, np.random.default_rng(0)), f"task {task.name}")
    try:
        first, again, other = (checked_events(task, theta, np.random.default_rng(seed)) for seed in (1, 1, 2))
    except SimulatorError:
        return
    if not np.array_equal(first, again, equal_nan=True) or np.array_equal(first, other, equal_nan=True):
        raise UsageError(
            f"the simulator of {task.name} ignores its generator: all of its randomness must come from `rng` "
            "(`avobench check task` tells more)"
        )


def parse_targets(text: str) -> list[int]:
    """Target indices from text such as `0-2,7`. Raises UsageError."""
    chosen: dict[int, None] = {}
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise UsageError(f"--targets takes indices and ranges such as 0-14 or 0,3,7-9, got '{text}'")
        low, high = int(first), int(last or first)
        if high >= NUM_TARGETS or low > high:
            raise UsageError(f"--targets must lie within 0-{NUM_TARGETS - 1}, low end first, got '{text}'")
        chosen |= dict.fromkeys(range(low, high + 1))
    return list(chosen)


def parse_settings(texts: Sequence[str], specs: dict[str, list[str]]) -> dict[str, dict[str, Any]]:
    """Settings by task or method, from NAME.SETTING=VALUE; VALUE is JSON, or text where it is not.

    NAME is a registered name or the `name` of a `module:Class`; it must be part of the run. Raises UsageError.
    """
    chosen: dict[str, dict[str, Any]] = {spec: {} for kind in specs for spec in specs[kind]}
    by_name = {registry.load(kind, spec).name: spec for kind in specs for spec in specs[kind]}
    for text in texts:
        key, equals, value = text.partition("=")
        name, dot, setting = key.rpartition(".")
        if not (equals and dot and name and setting):
            raise UsageError(f"--set takes METHOD.PARAM=VALUE, got '{text}'")
        spec = by_name.get(name, name)
        if spec not in chosen:
            raise UsageError(f"--set {text}: '{name}' is not part of this run; {', '.join(by_name) or 'nothing'} is")
        try:
            chosen[spec][setting] = json.loads(value)
        except json.JSONDecodeError:
            chosen[spec][setting] = value
    return chosen
