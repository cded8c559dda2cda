"""Records of studies that are a file of their own and no cells."""

from pathlib import Path
from typing import Any

from avobench.bench.store.record import decode
from avobench.tasks.errors import StoreError


def read_file(path: Path, study: str) -> dict[str, Any]:
    """The record in a file. Raises StoreError, with the command that makes it, when it is missing or damaged."""
    command = f"`python -m paper.study {study} --results {path.parent}`"
    if not path.exists():
        raise StoreError(f"there is no {path}; {command} makes it")
    try:
        return decode(path.read_bytes())
    except ValueError as error:
        raise StoreError(f"{path} {error}; delete it, and {command} makes it again") from error
