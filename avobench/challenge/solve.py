"""Diagnoses of data sets with hidden effects, from what is public of them: the answers are never opened."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.bench.processes.calls import Call, outcomes
from avobench.bench.processes.workers import Workers
from avobench.bench.store.files import require_folder, write_file
from avobench.challenge.make import MANIFEST
from avobench.diagnosis import diagnose
from avobench.diagnosis.checks import Checks
from avobench.tasks.contract import NAME
from avobench.tasks.errors import AvobenchError, ProcessEnded, UsageError, first_fault, raised

RESULTS = "results"
"""The folder of a challenge that holds a file for each case that was tried."""


def solve(
    folder: Path,
    *,
    workers: Workers | None = None,
    options: dict[str, Any] | None = None,
    trust: bool = False,
    progress: Callable[[str], None] = lambda line: None,
) -> None:
    """Diagnose each case of `folder` that has no result yet, with `options` of `diagnose`: one file in `results/` each.

    Each case has its number as seed, and one process. One that fails, or exceeds a limit, leaves its error as the
    result, and is tried again the next time. The option `bank` is the path of a folder of simulated events that all
    cases share, so that they are not independent of each other. Raises UsageError if the folder is no challenge, holds
    results of other options, or names code without being trusted, and for a bank and several processes; StoreError
    where the disk does not take a result.
    """
    manifest = read_manifest(folder)
    spec = registry.named_in(folder / "manifest.json", "task", manifest["task"], trust)
    workers, options = workers or Workers(jobs=1), options or {}
    if "bank" in options and (workers.processes or 1) > 1:
        raise UsageError("the folder of a bank has room for one process: leave --jobs or --bank out")
    require_folder(folder / RESULTS)
    pending = []
    for number, case in enumerate(manifest["cases"]):
        path = folder / RESULTS / f"{case['case']}.json"
        if path.exists():
            result = read_json(path)
            if result.get("options") != options:
                raise UsageError(
                    f"{path} was made with {result.get('options')}, not {options}; solve a copy of the folder"
                )
            if "error" not in result:
                continue
        pending.append((number, case, path))
    calls = [
        Call(_solved, (spec, folder / "data", number, case, options), workers.limits) for number, case, _ in pending
    ]
    for done, (place, outcome) in enumerate(outcomes(workers.processes, calls), start=1):
        if isinstance(outcome, ProcessEnded):  # a failed case is a row of the score, never an absence
            outcome = {"case": pending[place][1]["case"], "options": options, "error": f"{outcome.how}: {outcome}"}
            outcome |= {"seconds": None, "cpu_seconds": None}
        write_file(pending[place][2], (json.dumps(outcome) + "\n").encode())
        progress(f"[{done}/{len(pending)}] {_line(outcome)}")


def _solved(spec: str, data: Path, number: int, case: dict, options: dict[str, Any]) -> dict[str, Any]:
    start, cpu = time.perf_counter(), time.process_time()
    result: dict[str, Any] = {"case": case["case"], "options": options}
    try:
        task = registry.build("task", spec, {})
        registry.require_packages("task", task)
        x, allowed = read_events(str(data / f"{case['case']}.npz")), case["effects"]
        asked = {key: value for key, value in options.items() if key != "bank"}
        folder = Path(options["bank"]) if "bank" in options else None
        checks = Checks(task, len(x), options.get("num_simulations"), seed=number, folder=folder)
        x, warnings = checks.events(x)
        effects = [effect for effect in checks.entries() if allowed is None or effect.name in allowed]
        diagnosis = diagnose(task, x, seed=number, effects=effects, bank=checks.bank, **asked).diagnosis
        answer = {"warnings": warnings, "diagnosis": diagnosis.model_dump(mode="json")}
        json.dumps(answer, allow_nan=False)  # a number that is none is a fault too
        result |= answer
    except UsageError:
        raise
    except Exception as error:
        result["error"] = raised(error)
    result["seconds"] = time.perf_counter() - start
    result["cpu_seconds"] = time.process_time() - cpu
    return result


def _line(result: dict[str, Any]) -> str:
    seconds = "" if result["cpu_seconds"] is None else f", {result['cpu_seconds']:.1f} s"
    return f"{result['case']}: {result.get('error') or result['diagnosis']['verdict']}{seconds}"


class PublicCase(BaseModel):
    """A data set and the effects that may be tried on it, all where None."""

    model_config = ConfigDict(strict=True, extra="forbid")
    case: str = Field(pattern=f"^{NAME}$")
    """Part of the names of files, so nothing in it may lead to another folder."""
    effects: list[str] | None


class Manifest(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    kind: str = Field(alias="schema")
    version: int
    task: str
    num_events: int = Field(ge=1)
    cases: list[PublicCase] = Field(min_length=1)


def read_manifest(folder: Path) -> dict[str, Any]:
    """What is public of a challenge. Raises UsageError if `folder` holds none, or one that makes no sense."""
    path = folder / "manifest.json"
    if not path.is_file():
        raise UsageError(f"{folder} holds no challenge; `avobench challenge make --out {folder}` makes one")
    manifest = read_json(path)
    schema = {name: manifest.get(name) for name in MANIFEST}
    if schema != MANIFEST:
        raise UsageError(f"{path} has the schema {schema}, this version of avobench reads {MANIFEST}")
    try:
        cases = [case.case for case in Manifest.model_validate(manifest).cases]
    except ValidationError as error:
        where, fault = first_fault(error)
        raise UsageError(f"{path} makes no sense: {fault} at {where}") from error
    if len(set(cases)) < len(cases):
        raise UsageError(f"{path} makes no sense: two cases have the same name")
    return manifest


def read_json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise AvobenchError(f"{path} cannot be read: {error}") from error
    if not isinstance(content, dict):
        raise AvobenchError(f"{path} does not hold a JSON object")
    return content
