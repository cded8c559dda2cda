"""What was measured, and by what it is simulated, as options and files say it."""

import re
import tomllib
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from avobench.api.joint import Joint, joint
from avobench.bench.events import read_events, read_timed
from avobench.bench.plugins import registry
from avobench.cli.options import TRUST, names
from avobench.cli.terminal import say
from avobench.tables.read import read_table
from avobench.tables.table import Table
from avobench.tasks import Task
from avobench.tasks.errors import UsageError, did_you_mean
from avobench.tasks.missing import missing_in_both
from avobench.tasks.sample import bank
from avobench.tasks.weights import unweighted

KEYS = {
    **{"task": str, "data": str, "table": (str, list), "columns": list},
    **{"density": bool, "normalised": bool, "weights": str},
}
"""What a file says of each data set."""
OPTIONS = (
    click.option("--task", "spec", metavar="NAME", help="Task, file.py:Class, or a model.json."),
    click.option("--simulated", metavar="FILE", help="Simulated events, in place of a task."),
    names("--theta-columns", "Columns of --simulated that are parameters."),
    click.option("--weights", metavar="COLUMN", help="Column of --simulated with weights."),
    click.option("--data", metavar="FILE", help="File of measured events. For ROOT, file.root:tree."),
    click.option("--data-weights", metavar="COLUMN", help="Column of --data with weights."),
    click.option(
        "--table",
        "tables",
        multiple=True,
        metavar="FILE[:NAME]",
        help="Published table or histogram, in place of --data. Repeatable; --columns names the feature of each.",
    ),
    click.option("--density", is_flag=True, help="The values of --table are divided by the widths of their bins."),
    click.option(
        "--normalised", is_flag=True, help="Compare the shape of each --table alone. Counts are always compared so."
    ),
    click.option(
        "--joint",
        "sets",
        metavar="FILE.toml",
        help="Several data sets with one theta, a section each, in place of a task and data.",
    ),
    names("--columns", "Columns or branches to read, in this order."),
    TRUST,
)
"""The options of commands that fit or test a simulator."""


def of_measurement(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command with these options, which it hands to `Asked`."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class Asked:
    """What was measured, and by what it is simulated, as options say it."""

    spec: str | None
    simulated: str | None
    theta_columns: list[str] | None
    weights: str | None
    data: str | None
    data_weights: str | None
    tables: tuple[str, ...]
    density: bool
    normalised: bool
    sets: str | None
    columns: list[str] | None
    trust: bool

    @classmethod
    def of(cls, options: dict[str, Any], time: str | None = None) -> "Asked":
        """These, taken out of all options of a command but `time`. Raises UsageError where they do not go together."""
        asked = cls(**{name: options.pop(name) for name in cls.__dataclass_fields__})
        asked._require_sound(time)
        return asked

    def _require_sound(self, time: str | None) -> None:
        if self.sets is not None:
            given = {"task": self.spec, "simulated": self.simulated, "data": self.data, "table": self.tables}
            given |= {"columns": self.columns, "density": self.density, "normalised": self.normalised, "time": time}
            given |= {"data-weights": self.data_weights}
            if others := [f"--{name}" for name, value in given.items() if value]:
                raise UsageError(f"the file of --joint says this of each data set: leave {', '.join(others)} out")
        elif (self.spec is None) == (self.simulated is None):
            raise UsageError("give a simulator by --task, or events that it made by --simulated: one of the two")
        elif (self.data is None) == (not self.tables):
            raise UsageError("give measured events by --data, or published tables by --table: one of the two")
        if (self.theta_columns or self.weights) and self.simulated is None:
            raise UsageError("--theta-columns and --weights are columns of --simulated, which is not given")
        if (self.density or self.normalised) and not self.tables:
            raise UsageError("--density and --normalised are of --table, which is not given")
        if (time or self.data_weights) and self.data is None:
            raise UsageError("--time and --data-weights are columns of --data, which is not given")
        if time and self.data_weights:
            raise UsageError("events with weights are thinned at random: leave --time or --data-weights out")

    @property
    def title(self) -> str:
        """A title of what comes of it."""
        if self.sets is not None:
            return Path(self.sets).name
        measured = ", ".join(Path(name).name for name in ([self.data] if self.data else self.tables))
        return f"{measured} against {self.spec or Path(self.simulated or '').name}"

    def read(self, settings: Mapping[str, Any] | None = None, time: str | None = None) -> tuple[Any, Any, Any]:
        """The task with `settings`, what was measured, and the column `time` of it; or several data sets alone."""
        if self.sets is not None:
            return read_joint(self.sets, self.trust), None, None
        task: Task | str = "" if self.spec is None else registry.trusted(self.spec, self.trust)
        if self.spec is not None:  # what is wrong with the task is said before anything is read
            registry.load("task", task)
            task = registry.build("task", task, settings) if settings else task
        x, when = None, None
        if self.data is not None:
            x, when = _events(self.data, self.columns, self.data_weights, time)
        else:
            x = tables_of(self.tables, self.columns, density=self.density, normalised=self.normalised)
        if self.simulated is not None:
            columns = None if self.tables else self.columns
            task = _sample(self.simulated, columns, self.theta_columns, self.weights, x)
        return task, x, when


def _events(file: str, columns: list[str] | None, weights: str | None, time: str | None = None) -> tuple[Any, Any]:
    """Measured events of a file, without the column of `weights` by which they are thinned, and the column `time`."""
    x, when = read_timed(file, [*columns, *([weights] if weights else [])] if columns else None, time)
    if weights:
        with warnings.catch_warnings(record=True, action="always") as caught:
            x = unweighted(x, weights)
        say(f"note: {caught[0].message}", err=True)
    return x, when


def _sample(file: str, columns: list[str] | None, theta: list[str] | None, weights: str | None, x: Any) -> Task:
    """A task of the events in a file; what holds NaN there and in events x may be missing. Raises UsageError."""
    beside = [*(theta or []), *([weights] if weights else [])]
    events = read_events(file, [*columns, *beside] if columns else None)
    if beside and not hasattr(events, "columns"):
        raise UsageError(f"{file} has no columns with names, by which theta or weights could be chosen")
    missing = [] if isinstance(x, list) else missing_in_both(events, x)
    return bank(events, theta=theta, weights=weights, missing=missing)


def tables_of(names: Sequence[str], features: Sequence[str] | None, **settings: bool) -> list[Table]:
    """The tables of files, each by its feature. Raises UsageError."""
    if features is not None and len(features) != len(names):
        raise UsageError(f"--columns names the feature of each table: {len(features)} for {len(names)} tables")
    tables = []
    for k, name in enumerate(names):
        file, _, chosen = name.rpartition(":") if re.search(r"\.(csv|yaml|yml):[^:]+$", name) else (name, "", None)
        tables.append(read_table(file, chosen, feature=features[k] if features else 0, **settings))
    return tables


def read_joint(path: str, trust: bool = False) -> Joint:
    """The data sets of a TOML file, a section each, of which `shared` names the parameters they have in common.

    A section has a `task`, and `data` or one or several `table`s with the options that the command line has for them.
    Files are looked for beside this one. Raises UsageError.
    """
    try:
        sections = tomllib.loads(Path(path).read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"{path} cannot be read: {error}") from error
    shared = sections.pop("shared", None)
    if not isinstance(shared, list | None):
        raise UsageError(f"{path}: shared must be a list of names of parameters")
    return joint(
        {name: _set(f"{path}: {name}", each, Path(path).parent, trust) for name, each in sections.items()}, shared
    )


def _set(where: str, section: Any, folder: Path, trust: bool) -> tuple[Any, Any]:
    """The task and the events or tables of one section. Raises UsageError."""
    if not isinstance(section, dict):
        raise UsageError(f"{where} must be a section [name] with a task, and data or a table")
    for key, value in section.items():
        if key not in KEYS:
            hint = did_you_mean(key, KEYS) or f"it may have {', '.join(KEYS)}"
            raise UsageError(f"{where} cannot have '{key}'; {hint}")
        if not isinstance(value, KEYS[key]) or (isinstance(value, list) and not all(isinstance(v, str) for v in value)):
            raise UsageError(f"{where}: {key} cannot be {value!r}")
    tables = section.get("table", [])
    tables = [tables] if isinstance(tables, str) else tables
    if "task" not in section or ("data" in section) == bool(tables):
        raise UsageError(f"{where} needs a task, and data or a table: one of the two")
    of_tables = {key: section[key] for key in ("density", "normalised") if key in section}
    if of_tables and not tables:
        raise UsageError(f"{where}: {', '.join(of_tables)} is of a table, which is not given")
    if "weights" in section and tables:
        raise UsageError(f"{where}: weights are of data, which is not given")
    columns, spec = section.get("columns"), section["task"]
    beside = re.search(r"\.py:[^:]+$|\.json$", spec)
    task = registry.build("task", registry.trusted(str(folder / spec) if beside else spec, trust), {})
    if tables:
        return task, tables_of([str(folder / table) for table in tables], columns, **of_tables)
    return task, _events(str(folder / section["data"]), columns, section.get("weights"))[0]
