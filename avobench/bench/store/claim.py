"""The claim of a writer on a folder, a file there: for file systems that grant locks and do not hold them, as NFS may.

filelock's SoftFileLease keeps the file, which takes 75 lines fewer than to do it by hand. What filelock does not do is
added here: it judges a half-written file after 2 s only, as of a power cut, and never an empty one.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import SoftFileLease, Timeout

from avobench.tasks.errors import UsageError

BEAT_SECONDS = 10.0
"""A writer renews its claim this often."""
STALE_SECONDS = 60.0
"""A writer on another machine was ended if it did not renew its claim for so long: a busy server delays a few beats."""
HALF_SECONDS = 3.0
"""A writer was ended while it made its file if that stays half-written for so long; filelock judges after 2 s."""


@contextmanager
def claim(path: Path) -> Iterator[None]:
    """The caller is the only writer of the folder of `path`, a file that names its process, while the block runs.

    The claim of a process of this machine that is no more is taken over at once. One from elsewhere that seems to be
    abandoned is watched for STALE_SECONDS before, as the clocks of two machines may differ. Raises UsageError when
    another process writes, or when the file cannot be made.
    """
    lease = SoftFileLease(path, lease_duration=STALE_SECONDS, heartbeat_interval=BEAT_SECONDS)
    try:
        lease.acquire(timeout=_patience(lease, path))
    except Timeout as error:
        who = "" if (owner := lease.owner) is None else f" (process {owner.pid} on {owner.hostname})"
        raise UsageError(f"another avobench run{who} is writing to {path.parent}; wait for it or stop it") from error
    except OSError as error:
        raise UsageError(f"{path.parent} cannot be locked for writing: {error.strerror or error}") from error
    try:
        yield
    finally:
        with suppress(OSError):  # the next writer takes over what stays
            lease.release()


def _patience(lease: SoftFileLease, path: Path) -> float:
    """Seconds for which a claim is to be watched, so that it can be taken over if nobody renews it."""
    try:
        if path.stat().st_size == 0:
            time.sleep(HALF_SECONDS)
            if path.stat().st_size == 0:  # filelock would wait for ever for what nobody writes any more
                path.unlink()
        if time.time() - path.stat().st_mtime > STALE_SECONDS:
            return STALE_SECONDS + BEAT_SECONDS
        return HALF_SECONDS if lease.owner is None else 0
    except FileNotFoundError:
        return 0
