"""The diagnosis on real data: simple simulators of what was measured, of which it is known what they lack.

Each example is a file in `examples/real` that makes a `task` and reads what was `measured` from the table beside it.
`expected.json` has the answers, taken from the literature and committed before any diagnosis was made.
"""

import hashlib
import importlib
import time
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from avobench.bench.events import check_events
from avobench.bench.plugins import registry, user_files
from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, encode
from avobench.bench.store.versions import versions
from avobench.diagnosis.run import diagnose
from avobench.tasks.errors import StoreError, UsageError, first_fault
from paper.studies.files import of_identity, read_file

EXAMPLES = Path("examples/real")
FOLDER = Path("results/real")
EXPECTED = "expected.json"
SEEDS = 5
"""Seeds of each diagnosis. Each holds out other events, and a small data set may then give another answer."""
UNSAID = {"candidates", "identifiability"}
"""Fields of a diagnosis that a record leaves out: they are long, and no part of the answer."""


class Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


class KnownValue(Strict):
    """A parameter of the missing effect whose value is known."""

    parameter: str
    value: float
    tolerance: float
    """What the measurement itself leaves open, such as its calibration."""
    unit: str


class Expected(Strict):
    """What is known of an example."""

    measured: str
    lacks: str
    answer: list[str]
    """Names of effects, each of which is right; none where nothing is missing."""
    also: list[str]
    """Names that tell a part of it, or the same less well."""
    why: str
    value: KnownValue | None


def expected(examples: Path = EXAMPLES) -> dict[str, Expected]:
    """The answers by the name of the example. Raises UsageError where the file is missing or makes no sense."""
    path = examples / EXPECTED
    if not path.is_file():
        raise UsageError(f"there is no {path}; run this in a clone of the repository, which has the examples")
    try:
        return TypeAdapter(dict[str, Expected]).validate_json(path.read_bytes())
    except ValidationError as error:
        raise UsageError(f"{path}: {': '.join(first_fault(error))}") from error


def real(folder: Path, seed: int = 0, examples: Path = EXAMPLES, jobs: int = 1) -> list[dict[str, Any]]:
    """The records of all examples in `folder`, of which those are made that are lacking, or of other data or answers.

    A new version of the diagnosis makes none of them anew: remove the folder for that. Raises StoreError for a damaged
    record.
    """
    records = []
    for name, answer in expected(examples).items():
        path = folder / f"{name}.json"
        module = importlib.import_module(user_files.module_name(examples / f"{name}.py"))
        identity = identity_of(name, answer, module.task, examples, seed)
        record = of_identity(path, identity)
        if not record:
            record = {"schema_version": SCHEMA_VERSION, **identity, **said(module.task, module.measured, seed, jobs)}
            write_atomically(path, encode(record))
        records.append(record)
    return records


def place(folder: Path, k: int) -> Path:
    """The folder of the records of the k-th seed: the folder itself for the first, and one within it for each other."""
    return folder / "seeds" / str(k) if k else folder


def with_seeds(folder: Path, first: int = 0, jobs: int = 1) -> list[list[dict[str, Any]]]:
    """Make the records of `real` for each of SEEDS seeds, from the first on."""
    for k in range(1, SEEDS):
        place(folder, k).mkdir(parents=True, exist_ok=True)
    return [real(place(folder, k), first + k, jobs=jobs) for k in range(SEEDS)]


def read_all(folder: Path = FOLDER) -> list[list[dict[str, Any]]]:
    """The records of all seeds, each as `read` gives them."""
    return [read(place(folder, k)) for k in range(SEEDS)]


def identity_of(name: str, answer: Expected, task: Any, examples: Path, seed: int) -> dict[str, Any]:
    """What determines a record but for the version of the diagnosis, with the lines that head the data."""
    data = (examples / f"{name}.csv").read_bytes()
    head = [line[2:] for line in data.decode().splitlines() if line.startswith("# ")]
    identity = {"study": "real", "name": name, "seed": seed, "expected": answer.model_dump(mode="json")}
    identity |= {"data_sha256": hashlib.sha256(data).hexdigest(), "data_head": head}
    return identity | registry.identity("task", f"{examples / name}.py:task", task)


def said(task: Any, measured: Any, seed: int, jobs: int) -> dict[str, Any]:
    """What the diagnosis says of the measured events, with its versions and the seconds of this process."""
    x, remarks = check_events(task, measured)
    started = time.process_time()
    diagnosis = diagnose(task, x, seed=seed, jobs=jobs).diagnosis
    seconds = time.process_time() - started
    diagnosis.notes[:0] = remarks
    told = diagnosis.model_dump(mode="json", exclude=UNSAID)
    return {"diagnosis": told, "processor_seconds": seconds, "versions": versions()}


def read(folder: Path = FOLDER) -> list[dict[str, Any]]:
    """The records of a results folder, by name. Raises StoreError when there are none or one is damaged."""
    paths = sorted(folder.glob("*.json"))
    if not paths:
        raise StoreError(f"no records in {folder}; `python -m paper.study real --results {folder}` makes them")
    return [read_file(path, "real") for path in paths]
