"""Records of studies that are a file of their own and no cells."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, decode, encode
from avobench.bench.store.versions import versions
from avobench.tasks.errors import StoreError

Wanted = Iterable[tuple[dict[str, Any], Callable[[], dict[str, Any]]]]
"""What a study is to have: by what is wanted a row is known, and what makes it."""


class StudyFile:
    """The record of a study, the file `name` in a results folder."""

    def __init__(self, study: str) -> None:
        self.study, self.name = study, f"{study}.json"

    def read(self, folder: Path) -> dict[str, Any]:
        """The record in a results folder. Raises StoreError where there is no sound one."""
        return read_file(folder / self.name, self.study)

    def begun(self, path: Path, rows: str, **identity: Any) -> dict[str, Any]:
        """The record at `path` if it is of this identity, else a new one with an empty list of `rows`.

        Raises StoreError for a damaged file.
        """
        identity = {"study": self.study, **identity}
        return of_identity(path, identity) or {"schema_version": SCHEMA_VERSION, **identity, rows: []}

    def completed(self, path: Path, rows: str, wanted: Wanted, **identity: Any) -> dict[str, Any]:
        """The record as `begun` with a row for each key that is `wanted`: what is lacking is made, and written at once.

        A row takes the place of that of another `version` of the method.
        """
        record = self.begun(path, rows, **identity)
        for key, make in wanted:
            if not any(key.items() <= row.items() for row in record[rows]):
                made = {**key, **make()}
                same = {name: value for name, value in key.items() if name != "version"}.items()
                record[rows] = [row for row in record[rows] if not same <= row.items()] + [made]
                self.keep(path, record, "torch")
        return record

    def keep(self, path: Path, record: dict[str, Any], *packages: str) -> None:
        """Write a record, with the versions of what makes it."""
        record["versions"] = versions(packages)
        write_atomically(path, encode(record))


def read_file(path: Path, study: str) -> dict[str, Any]:
    """The record in a file. Raises StoreError, with the command that makes it, when it is missing or damaged."""
    command = f"`python -m paper.study {study} --results {path.parent}`"
    if not path.exists():
        raise StoreError(f"there is no {path}; {command} makes it")
    try:
        return decode(path.read_bytes())
    except ValueError as error:
        raise StoreError(f"{path} {error}; delete it, and {command} makes it again") from error


def of_identity(path: Path, identity: dict[str, Any]) -> dict[str, Any]:
    """The record at `path` if it is of this identity, else an empty one. Raises StoreError for a damaged file."""
    record = read_file(path, identity["study"]) if path.exists() else {}
    return record if {name: record.get(name) for name in identity} == identity else {}


def read_lines(path: Path) -> list[dict[str, Any]]:
    """The rows of a file of JSON lines."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def add_lines(path: Path, wanted: Wanted) -> None:
    """Add to a file of JSON lines what it lacks of the rows that are wanted, each as soon as it is made."""
    have = read_lines(path) if path.exists() else []
    for key, make in wanted:
        if not any(key.items() <= row.items() for row in have):
            line = json.dumps(make()) + "\n"
            with path.open("a") as file:
                file.write(line)
