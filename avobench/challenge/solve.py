"""Diagnoses of data sets with hidden effects, from what is public of them: the answers are never opened."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import joblib

from avobench.bench import registry
from avobench.bench.atomic import write_atomically
from avobench.bench.events import check_events, read_events
from avobench.challenge.make import MANIFEST
from avobench.diagnosis import diagnose
from avobench.effects.catalogue import catalogue
from avobench.tasks.errors import AvobenchError, UsageError

RESULTS = "results"
"""The folder of a challenge that holds a file for each case that was tried."""


def solve(
    folder: Path,
    *,
    jobs: int = 1,
    options: dict[str, Any] | None = None,
    progress: Callable[[str], None] = lambda line: None,
) -> None:
    """Diagnose each case of `folder` that has no result yet, with `options` of `diagnose`; a file a case in `results/`.

    Each case has a seed of its own, its number. A case that fails leaves its error as the result, and is tried again
    the next time. Raises UsageError if the folder is no challenge, or holds results of other options.
    """
    manifest = read_manifest(folder)
    task = registry.build("task", manifest["task"], {})
    registry.require_packages("task", task)
    options = options or {}
    (folder / RESULTS).mkdir(exist_ok=True)
    pending = []
    for number, case in enumerate(manifest["cases"]):
        path = folder / RESULTS / f"{case['case']}.json"
        if path.exists():
            result = read_json(path)
            if result["options"] != options:
                raise UsageError(f"{path} was made with {result['options']}, not {options}; solve a copy of the folder")
            if "error" not in result:
                continue
        pending.append((number, case, path))
    work = (
        joblib.delayed(_solve_case)(manifest["task"], folder / "data", number, case, path, options)
        for number, case, path in pending
    )
    for done, line in enumerate(joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")(work), start=1):
        progress(f"[{done}/{len(pending)}] {line}")


def _solve_case(spec: str, data: Path, number: int, case: dict, path: Path, options: dict[str, Any]) -> str:
    start, cpu = time.perf_counter(), time.process_time()
    common: dict[str, Any] = {"case": case["case"], "options": options}
    try:
        task = registry.build("task", spec, {})
        x, warnings = check_events(task, read_events(str(data / f"{case['case']}.npz")))
        allowed = case["effects"]
        effects = None if allowed is None else [effect for effect in catalogue(task) if effect.name in allowed]
        diagnosis = diagnose(task, x, seed=number, effects=effects, **options).diagnosis
        result = {**common, "warnings": warnings, "diagnosis": diagnosis.model_dump(mode="json")}
        line = str(diagnosis.verdict)
        json.dumps(result, allow_nan=False)  # a number that is none is a fault too
    except UsageError:
        raise
    except Exception as error:  # a failed case is a row of the score, never an absence
        line = f"{type(error).__name__}: {error}"
        result = {**common, "error": line}
    result["seconds"] = time.perf_counter() - start
    result["cpu_seconds"] = time.process_time() - cpu
    write_atomically(path, (json.dumps(result) + "\n").encode())
    return f"{case['case']}: {line}, {result['cpu_seconds']:.1f} s"


def read_manifest(folder: Path) -> dict[str, Any]:
    """What is public of a challenge. Raises UsageError if `folder` holds none."""
    path = folder / "manifest.json"
    if not path.is_file():
        raise UsageError(f"{folder} holds no challenge; `avobench challenge make --out {folder}` makes one")
    manifest = read_json(path)
    found = {name: manifest.get(name) for name in MANIFEST}
    if found != MANIFEST:
        raise UsageError(f"{path} has the schema {found}, this version of avobench reads {MANIFEST}")
    return manifest


def read_json(path: Path) -> dict[str, Any]:
    """Raises AvobenchError for what is not a JSON object."""
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise AvobenchError(f"{path} cannot be read: {error}") from error
    if not isinstance(content, dict):
        raise AvobenchError(f"{path} does not hold a JSON object")
    return content
