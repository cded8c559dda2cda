"""Folders and files that can be written, or say why not."""

import os
from pathlib import Path

from avobench.bench.store.atomic import write_atomically
from avobench.tasks.errors import StoreError, UsageError


def require_folder(path: Path, *, make: bool = True) -> None:
    """Raise UsageError unless files can be written in the folder `path`."""
    if path.exists() and not path.is_dir():
        raise UsageError(f"{path} is not a folder")
    if not make and not path.exists():
        raise UsageError(f"there is no folder {path}")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"the folder {path} cannot be made: {error.strerror or error}") from error
    if not os.access(path, os.W_OK):
        raise UsageError(f"the folder {path} is read-only")


def write_file(path: Path, content: bytes) -> None:
    """Write `content` to `path`, whole or not at all; StoreError when the disk does not take it."""
    try:
        write_atomically(path, content)
    except OSError as error:
        raise StoreError(f"{path} could not be written: {error.strerror or error}") from error
