"""The records of a challenge: its solved cases with their answers, which are opened here and only here."""

import json
from pathlib import Path
from typing import Any

from avobench.challenge.solve import RESULTS, read_json, read_manifest
from avobench.tasks.errors import UsageError

RECORDS = {"schema": "avobench-challenge-records", "version": 1}
"""What says that a file holds records, and of which version."""
KEPT = (
    *("verdict", "alpha", "p_value_before", "p_value_after", "gates", "gap_before", "gap_after"),
    *("theta_before", "theta_after", "identified_before", "identified_after"),
    *("effects", "probabilities", "outside", "models", "num_simulations", "seed", "versions"),
)
"""Fields of a diagnosis in records. Long fields that are not scored, such as the candidates, are left out."""


def records(folder: Path) -> list[dict[str, Any]]:
    """All that scoring needs, a dictionary a line: the challenge, then its solved cases. Raises UsageError."""
    manifest, path = read_manifest(folder), folder / "answers.json"
    if not path.is_file():
        raise UsageError(f"there are no answers in {folder}: {path} is missing")
    results = [read_json(file) for file in sorted((folder / RESULTS).glob("*.json"))]
    if not results:
        raise UsageError(f"nothing is solved in {folder}; `avobench challenge solve {folder}` does it")
    answers = read_json(path)
    of_case = {answer["case"]: answer for answer in answers["cases"]}
    head = {**RECORDS, **{name: answers[name] for name in ("task", "num_events", "seed", "kinds")}}
    head |= {"cases": len(manifest["cases"]), "options": results[0]["options"]}
    rows = []
    for result in results:
        row = {**of_case[result["case"]], "error": result.get("error")}
        row |= {name: result[name] for name in ("seconds", "cpu_seconds")}
        if row["error"] is None:
            row["diagnosis"] = {name: result["diagnosis"].get(name) for name in KEPT}
        rows.append(row)
    return [head, *rows]


def read_records(path: Path) -> list[dict[str, Any]]:
    try:
        lines = [json.loads(line) for line in path.read_text().splitlines()]
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"{path} cannot be read as records of a challenge: {error}") from error
    if not lines or not all(isinstance(line, dict) for line in lines):
        raise UsageError(f"{path} does not hold records of a challenge")
    if {name: lines[0].get(name) for name in RECORDS} != RECORDS:
        raise UsageError(f"{path} does not hold records of a challenge")
    return lines
