"""Packing a store in a process that ends without warning at a chosen operation on files."""

import os
import signal
import sys
from pathlib import Path

from avobench.bench.store.pack import pack
from avobench.bench.store.store import Store

OPERATIONS = ("open", "tempfile.mkstemp", "os.chmod", "os.rename", "os.remove", "os.rmdir")
"""What Python tells an audit hook just before it does it."""


def pack_killed_at(path: Path, number: int) -> None:
    """Pack the store at `path`, killed by SIGKILL just before its operation `number`, from 0, below that folder."""
    seen = 0

    def kill(event: str, arguments: tuple) -> None:
        nonlocal seen
        if event in OPERATIONS and str(path) in str(arguments[0]):
            if seen == number:
                os.kill(os.getpid(), signal.SIGKILL)
            seen += 1

    sys.addaudithook(kill)
    pack(Store(path))


def pack_calmly(path: Path) -> None:
    pack(Store(path))
