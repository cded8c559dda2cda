"""Records of studies that are a file of their own and no cells."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, decode, encode
from avobench.bench.store.versions import versions
from avobench.tasks.errors import StoreError


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
        record = read_file(path, self.study) if path.exists() else {}
        if {name: record.get(name) for name in identity} == identity:
            return record
        return {"schema_version": SCHEMA_VERSION, **identity, rows: []}

    def completed(
        self,
        path: Path,
        record: dict[str, Any],
        rows: str,
        wanted: Iterable[tuple[dict[str, Any], Callable[[], dict[str, Any]]]],
        *packages: str,
    ) -> dict[str, Any]:
        """The record with a row for each key that is `wanted`, and no other, as of an earlier version of a method.

        What is lacking is made, and written at once.
        """
        wanted = list(wanted)
        for key, make in wanted:
            if not any(key.items() <= row.items() for row in record[rows]):
                record[rows].append({**key, **make()})
                self.keep(path, record, *packages)
        kept = [row for row in record[rows] if any(key.items() <= row.items() for key, _ in wanted)]
        if len(kept) < len(record[rows]):
            record[rows] = kept
            self.keep(path, record, *packages)
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
