"""Who writes to a folder, told in a file there: for file systems that grant locks and do not hold them, as NFS may."""

import json
import os
import secrets
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from avobench.tasks.errors import UsageError

BEAT_SECONDS = 10.0
"""How often a writer shows that it is there."""
STALE_SECONDS = 60.0
"""After so long without that, a writer on another machine was ended: a few beats may be late on a busy server."""


@contextmanager
def claim(path: Path) -> Iterator[None]:
    """Be the only writer of the folder of `path`, a file that names this process as long as the block runs.

    The file of a process of this machine that is no more, or of one elsewhere that has long not shown itself, is taken
    over. Raises UsageError when another process writes, OSError when the file cannot be made.
    """
    own = _me()
    while True:
        try:
            _make(path, own)
            break
        except FileExistsError:
            _take_over(path)
    stop = threading.Event()
    thread = threading.Thread(target=_beat, args=(path, stop), daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
        with suppress(OSError):  # what stays is taken over by the next
            if path.read_bytes() == own:
                path.unlink()


def _make(path: Path, own: bytes) -> None:
    """Make the file with its content at once, or raise FileExistsError. A link is made in one step on NFS too."""
    written = _beside(path)
    try:
        written.write_bytes(own)
        try:
            os.link(written, path)
        except FileExistsError:
            raise
        except OSError:  # a file system without links
            with path.open("xb") as file:
                file.write(own)
    finally:
        written.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    """A new name for a temporary file in the same folder, which `Store.remove_leftovers` knows."""
    return path.with_name(f"{path.name}.{secrets.token_hex(4)}.tmp")


def _take_over(path: Path) -> None:
    """Move the file of a writer that is no more out of the way. Raises UsageError if the writer may be at work."""
    found, age = _read(path)
    if found is None:
        return  # just ended
    try:
        writer = json.loads(found)
        host, pid, started = writer["host"], writer["pid"], writer["started"]
    except (ValueError, KeyError, TypeError):
        host, pid, started = None, None, None  # not written by this version
    here = host == socket.gethostname()
    if (here and _started(pid) == started) or (not here and age < STALE_SECONDS):
        who = "" if pid is None else f" (process {pid} on {host})"
        raise UsageError(f"another avobench run{who} is writing to {path.parent}; wait for it or stop it")
    aside = _beside(path)
    with suppress(FileNotFoundError):  # another process has just done the same
        path.rename(aside)
        if aside.read_bytes() != found:  # it has, and has begun: this is its file
            os.link(aside, path)
        aside.unlink()


def _read(path: Path) -> tuple[bytes | None, float]:
    """What the file holds, None if it is gone, and the seconds since its last beat by the clock of its file system."""
    probe = _beside(path)
    try:
        content = path.read_bytes()
        probe.touch()
        return content, probe.stat().st_mtime - path.stat().st_mtime
    except FileNotFoundError:
        return None, 0.0
    finally:
        probe.unlink(missing_ok=True)


def _me() -> bytes:
    me: dict[str, Any] = {"host": socket.gethostname(), "pid": os.getpid(), "started": _started(os.getpid())}
    return (json.dumps(me) + "\n").encode()


def _started(pid: int) -> str | None:
    """When a process of this machine was started, so that another one of the same number is told apart; None if gone.

    Where the system does not tell when, its being there is all that is known.
    """
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except OSError:
        pass
    if Path("/proc/self/stat").exists():
        return None
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return None
    except OSError:
        pass
    return "running"


def _beat(path: Path, stop: threading.Event) -> None:
    while not stop.wait(BEAT_SECONDS):
        with suppress(OSError):
            os.utime(path)
