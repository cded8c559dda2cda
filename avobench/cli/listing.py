"""`avobench list`, what there is to choose from, and the tables that other commands print."""

import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import click
import pandas as pd

from avobench.bench.plugins import registry
from avobench.bench.store.frame import labels, mean_errors, to_frame
from avobench.bench.store.status import Status
from avobench.cli.isolated import Isolated
from avobench.cli.options import TRUST
from avobench.cli.terminal import say
from avobench.effects import Effect, Parameter
from avobench.effects.catalogue import catalogue
from avobench.reports.numbers import in_unit
from avobench.tasks.errors import UsageError

WIDTH = 110
"""Columns that a line takes at most, as in the help of the commands."""
NO_BREAK = "\u00a0"
"""A blank within the name of a shape, at which no line ends."""
EXAMPLES = {
    "events that are one count each": ("poisson",),
    "events of real numbers": ("carl", "weinberg", "avobench.tasks.decays:DECAYS"),
    "events that are images": ("alignment",),
}
"""Tasks for which the effects on each kind of events are listed where no task is given: they show all shapes."""


@click.command("list", cls=Isolated)
@click.argument("kind", type=click.Choice(["tasks", "methods", "effects"]), required=False)
@click.option(
    "--task",
    "spec",
    metavar="NAME",
    help="List the effects that apply to this task, with the bounds of their parameters.",
)
@TRUST
def list_(kind: str | None, spec: str | None, trust: bool) -> None:
    """List the tasks, the methods and the effects, or one kind of them."""
    if spec is not None:
        if kind not in (None, "effects"):
            raise UsageError(f"--task is for `avobench list effects`, not for {kind}")
        say(effects_of(registry.trusted(spec, trust)))
        return
    tables = {"tasks": tasks, "methods": methods, "effects": effects}
    say("\n\n".join(table() for name, table in tables.items() if kind in (None, name)))


def tasks() -> str:
    """Every registered task, with its parameters and settings."""
    lines = ["tasks"]
    for name in registry.names("task"):
        task = registry.build("task", name, {})
        lines.append(f"  {name}: {task.num_features} feature{'s' * (task.num_features > 1)} per event")
        for parameter, unit, low, high in zip(
            task.parameter_names, task.parameter_units, task.prior.low, task.prior.high, strict=True
        ):
            lines.append(f"    {parameter} ~ U({low:g}, {high:g}){in_unit(unit)}")
        lines += _settings(task)
    return "\n".join(lines)


def methods() -> str:
    """Every registered method, with where it comes from and its settings."""
    lines = ["methods"]
    for name in registry.names("method"):
        method = registry.build("method", name, {})
        package = registry.missing_package(method)
        lines += _wrapped(
            f"  {name}: {method.source}" + (f" (not available: it needs {package})" if package else ""), 4
        )
        lines += _settings(method)
    return "\n".join([*lines, "--set NAME.SETTING=VALUE changes a setting"])


def effects() -> str:
    """Every installed effect by the kind of events that it is for: what it does, its shapes and their parameters."""
    lines = ["effects that a simulator may lack, their shapes, and the parameters of each shape, the strength first"]
    for events, names in EXAMPLES.items():
        lines.append(f"  on {events}")
        entries = [effect for name in names for effect in catalogue(registry.build("task", name, {}))]
        for name in dict.fromkeys(effect.name for effect in entries):
            shapes = [shape for effect in entries if effect.name == name for shape in effect.shapes()]
            lines += _effect(shapes, lambda parameter: parameter.name)
    return "\n".join([*lines, "`avobench list effects --task NAME` shows the bounds of the parameters for a task"])


def effects_of(spec: str) -> str:
    """The effects that apply to a task: what each acts on, its shapes, and the bounds of their parameters."""
    task = registry.build("task", spec, {})
    entries = registry.blamed(lambda: catalogue(task), f"task '{spec}'")
    lines = [f"effects on {spec}"]
    features = [task.labels[e.feature] for e in entries if isinstance(e.feature, int) and e.name == entries[0].name]
    if len(features) > 1:
        where = f"each acts on one of {', '.join(features)}, or on all alike; bounds are those for {features[0]}"
        lines += _wrapped(f"  {where}", 4)
    for name in dict.fromkeys(effect.name for effect in entries):
        variants = [effect for effect in entries if effect.name == name]
        lines += _effect([shape for e in variants if e.key == variants[0].key for shape in e.shapes()], _bounds)
        if len(variants) > 1 and isinstance(variants[0].feature, str):
            lines += _wrapped(f"        each acts on one of {', '.join(effect.feature for effect in variants)}", 12)
    return "\n".join(lines)


def _effect(shapes: Sequence[Effect], describe: Callable[[Parameter], str]) -> list[str]:
    """The sentence of an effect, its source, and a line for all shapes with the same parameters."""
    first = shapes[0]
    lines = [*_wrapped(f"    {first.name}: {first.sentence}", 8)]
    alike: dict[str, list[str]] = {}
    for shape in shapes:
        parameters = ", ".join(describe(parameter) for parameter in shape.parameters)
        named = alike.setdefault(parameters, [])
        if shape.shape not in named:
            named.append(shape.shape)
    for parameters, names in alike.items():
        words = ", ".join(name.replace(" ", NO_BREAK) for name in names)
        lines += _wrapped(f"        {words + ': ' if words else ''}{parameters}", 12)
    return lines


def _bounds(parameter: Parameter) -> str:
    absent = "" if parameter.null is None or parameter.null == parameter.low else f", absent at {parameter.null:g}"
    return f"{parameter.name} from {parameter.low:.3g} to {parameter.high:.3g}{in_unit(parameter.unit)}{absent}"


def _wrapped(line: str, indent: int) -> list[str]:
    options = {"break_long_words": False, "break_on_hyphens": False}
    lines = textwrap.wrap(line, WIDTH, subsequent_indent=" " * indent, **options)
    return [each.replace(NO_BREAK, " ") for each in lines]


def status_table(records: list[dict[str, Any]]) -> str:
    """One line per task and method: cells, failures, median squared error, its ratio to the floor, seconds per cell.

    For a method with a posterior, one more column has the ratio of the posterior mean. The simulations of an amortised
    method are those of all targets together.
    """
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    frame["ok"] = frame["status"] == Status.OK
    frame["ratio"] = frame["squared_error"] / frame["floor"]
    frame["mean's ratio"] = mean_errors(records) / frame["floor"]
    frame["seconds"] = frame["simulator_seconds"] + frame["method_seconds"]
    groups = frame.groupby(["task", "method"], sort=True)
    table = pd.DataFrame(
        {
            "targets": groups["target"].nunique(),
            "cells": groups.size(),
            "ok": groups["ok"].sum(),
            "median squared error": groups["squared_error"].median(),
            "median error / floor": groups["ratio"].median(),
            "of the posterior mean": groups["mean's ratio"].median(),
            "simulations": groups["simulations_used"].max(),
            "seconds per cell": groups["seconds"].mean().round(1),
        }
    ).reset_index()
    return table.to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")


def _settings(instance: object) -> list[str]:
    settings = [f"{f.name}={getattr(instance, f.name)}" for f in registry.fields_of(instance)]
    return _wrapped(f"    settings: {', '.join(settings)}", 6) if settings else []
