"""Files that are written whole or not at all, at places that a name cannot lead out of."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from avobench.tasks.errors import UsageError


def write_atomically(path: Path, content: bytes, check: Callable[[Path], None] | None = None) -> Path:
    """Write `content` to `path` so that a reader, or a crash, sees all of it or nothing.

    `check` is given the written file before it takes its place; what it raises leaves `path` as it was. A link stays a
    link; what is not a regular file, such as a terminal, is written to as it is, unchecked. An OSError names `path`.
    """
    try:
        return _write(path, content, check)
    except OSError as error:
        if error.errno is not None:
            error.filename = str(path)
        raise


def _write(path: Path, content: bytes, check: Callable[[Path], None] | None) -> Path:
    target = path.resolve()
    if target.exists() and not target.is_file():
        target.write_bytes(content)
        return path
    handle, temporary = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        if check is not None:
            check(Path(temporary))
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise
    return path


def sync_folder(folder: Path) -> None:
    """Have the disk keep which files `folder` holds, so that a file renamed into it is there after a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def within(folder: Path, name: str) -> Path:
    """The path of the file `name` in `folder`. Raises UsageError where the name would lead to another folder."""
    path = folder / name
    if path.parent != folder or path.name in ("", ".", "..") or "\0" in name or "\\" in name:
        raise UsageError(f"a file named '{name}' would not lie in {folder}; names must not contain a path")
    return path
