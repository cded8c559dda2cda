"""What was measured, as files say it: published tables, and several data sets with their simulators."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from avobench.api.joint import Joint, joint
from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.tables.read import read_table
from avobench.tables.table import Table
from avobench.tasks.errors import UsageError, did_you_mean

KEYS = {"task": str, "data": str, "table": (str, list), "columns": list, "density": bool, "normalised": bool}
"""What a file says of each data set."""


def tables_of(names: Sequence[str], features: Sequence[str] | None, **settings: bool) -> list[Table]:
    """The tables of files, each by its feature. Raises UsageError."""
    if features is not None and len(features) != len(names):
        raise UsageError(f"--columns names the feature of each table: {len(features)} for {len(names)} tables")
    found = []
    for k, name in enumerate(names):
        file, _, chosen = name.rpartition(":") if re.search(r"\.(csv|yaml|yml):[^:]+$", name) else (name, "", None)
        found.append(read_table(file, chosen, feature=features[k] if features else 0, **settings))
    return found


def read_joint(path: str, trust: bool = False) -> Joint:
    """The data sets of a TOML file, a section each, of which `shared` names the parameters they have in common.

    A section has a `task`, and `data` or one or several `table`s with the options that the command line has for them.
    Files are looked for beside this one. Raises UsageError.
    """
    try:
        said = tomllib.loads(Path(path).read_text())
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read: {error}") from error
    shared = said.pop("shared", None)
    if not isinstance(shared, list | None):
        raise UsageError(f"{path}: shared must be a list of names of parameters")
    return joint({name: _set(f"{path}: {name}", each, Path(path).parent, trust) for name, each in said.items()}, shared)


def _set(where: str, said: Any, folder: Path, trust: bool) -> tuple[Any, Any]:
    """The task and the events or tables of one section. Raises UsageError."""
    if not isinstance(said, dict):
        raise UsageError(f"{where} must be a section [name] with a task, and data or a table")
    for key, value in said.items():
        if key not in KEYS:
            hint = did_you_mean(key, KEYS) or f"it may have {', '.join(KEYS)}"
            raise UsageError(f"{where} cannot have '{key}'; {hint}")
        if not isinstance(value, KEYS[key]) or (isinstance(value, list) and not all(isinstance(v, str) for v in value)):
            raise UsageError(f"{where}: {key} cannot be {value!r}")
    tables = said.get("table", [])
    tables = [tables] if isinstance(tables, str) else tables
    if "task" not in said or ("data" in said) == bool(tables):
        raise UsageError(f"{where} needs a task, and data or a table: one of the two")
    of_tables = {key: said[key] for key in ("density", "normalised") if key in said}
    if of_tables and not tables:
        raise UsageError(f"{where}: {', '.join(of_tables)} is of a table, which is not given")
    columns, spec = said.get("columns"), said["task"]
    beside = re.search(r"\.py:[^:]+$|\.json$", spec)
    task = registry.build("task", registry.trusted(str(folder / spec) if beside else spec, trust), {})
    if tables:
        return task, tables_of([str(folder / table) for table in tables], columns, **of_tables)
    return task, read_events(str(folder / said["data"]), columns)
