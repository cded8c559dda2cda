"""Files that are written whole or not at all, at places that a name cannot lead out of, and folders that take them."""

import errno
import os
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from avobench.tasks.errors import AvobenchError, StoreError, UsageError

NAMES = ("store.json", "records", "records.parquet", "running", "damaged", "sweeps.jsonl", ".lock", ".writer")
"""The names in the folder of a store. None may be a link: a folder from elsewhere could lead out by it."""
NO_LOCKS = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP)
"""A file system without locks raises one of these errors."""


def write_atomically(path: Path, content: bytes, check: Callable[[Path], None] | None = None) -> Path:
    """Write `content` to `path` so that a reader, or a crash, sees all of it or nothing.

    `check` is given the written file before it takes its place; what it raises leaves `path` as it was. A link stays a
    link; what is not a regular file, such as a terminal, is written to as it is, unchecked. An OSError names `path`.
    """
    temporary = None
    try:
        target = path.resolve()
        if target.exists() and not target.is_file():
            target.write_bytes(content)
            return path
        handle, temporary = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=target.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        if check is not None:
            check(Path(temporary))
        os.replace(temporary, target)
    except BaseException as error:
        if temporary is not None:
            os.unlink(temporary)
        if isinstance(error, OSError) and error.errno is not None:
            error.filename = str(path)
        raise
    return path


def write_file(path: Path, content: bytes) -> None:
    """Write `content` to `path`, whole or not at all. Raises StoreError when the disk does not take it.

    Raises UsageError for a place that a results folder uses: records might be overwritten.
    """
    for folder in path.resolve().parents[:2]:
        if path.resolve().relative_to(folder).parts[0] in NAMES and (folder / "store.json").exists():
            raise UsageError(f"{path} is a place of the results folder {folder}; choose a file outside of it")
    with disk_errors(f"{path} could not be written"):
        write_atomically(path, content)


@contextmanager
def disk_errors(what: str, kind: type[AvobenchError] = StoreError) -> Iterator[None]:
    """An OSError within the block is raised as an error of this kind, which says what could not be done and why."""
    try:
        yield
    except OSError as error:
        raise kind(f"{what}: {error.strerror or error}") from error


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


def locked(folder: Path, taken: str, **options: bool) -> FileLock:
    """A lock on a folder, which this process holds as long as it refers to it. `options` are those of FileLock.

    On a file system without locks it is not held. Raises UsageError with `taken` where another process holds it.
    """
    lock = FileLock(folder / ".lock", fallback_to_soft=False, **options)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        raise UsageError(taken) from error
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise UsageError(f"{folder} cannot be locked for writing: {error.strerror or error}") from error
    return lock


def not_plain(path: Path) -> str:
    """Why what is at `path` is no plain file or folder, such as a link or a pipe from elsewhere; "" where it is."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return ""
    if stat.S_ISLNK(mode):
        return f"is a link to {os.readlink(path)}"
    return "" if stat.S_ISREG(mode) or stat.S_ISDIR(mode) else "is neither a file nor a folder"


def require_folder(path: Path, *, make: bool = True) -> None:
    """Raise UsageError unless files can be written in the folder `path`."""
    if path.exists() and not path.is_dir():
        raise UsageError(f"{path} is not a folder")
    if not make and not path.exists():
        raise UsageError(f"there is no folder {path}")
    with disk_errors(f"the folder {path} cannot be made", UsageError):
        path.mkdir(parents=True, exist_ok=True)
    if not os.access(path, os.W_OK):
        raise UsageError(f"the folder {path} is read-only")
