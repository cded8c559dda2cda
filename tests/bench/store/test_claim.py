"""Who writes to a folder whose locks cannot be trusted."""

import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from avobench.bench.store import claim as module
from avobench.bench.store.claim import claim
from avobench.tasks.errors import UsageError


@pytest.fixture
def path(tmp_path):
    return tmp_path / ".writer"


@pytest.fixture
def abandoned(path):
    """What a writer of this machine leaves that was killed."""
    code = "import os, signal; from pathlib import Path; from avobench.bench.store.claim import claim\n"
    code += f"with claim(Path({str(path)!r})): os.kill(os.getpid(), signal.SIGKILL)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == -signal.SIGKILL
    return path.read_text()


def test_a_second_writer_is_refused_by_name_and_the_file_goes_with_the_first(path):
    with claim(path):
        with pytest.raises(UsageError, match=f"process {os.getpid()} on {socket.gethostname()}"), claim(path):
            pass
        assert path.exists()
    assert list(path.parent.iterdir()) == []


def test_a_writer_of_this_machine_that_was_killed_is_taken_over_at_once(path, abandoned):
    start = time.monotonic()
    with claim(path):
        assert path.read_text() != abandoned
    assert time.monotonic() - start < 50  # and not the minute after which it would be stale
    assert not path.exists()


def test_a_claim_from_elsewhere_is_taken_over_only_once_it_was_long_not_renewed(path, abandoned, monkeypatch):
    path.write_text(abandoned.replace(socket.gethostname(), "elsewhere").replace("duration=60.0", "duration=3.0"))
    monkeypatch.setattr(module, "BEAT_SECONDS", 2.5)
    monkeypatch.setattr(module, "STALE_SECONDS", 3.0)
    with pytest.raises(UsageError, match="on elsewhere"), claim(path):
        pass
    os.utime(path, (0, 0))
    with claim(path):
        pass


@pytest.mark.parametrize("share", [0, 0.5])
def test_a_writer_that_was_killed_while_it_made_its_file_is_taken_over(path, abandoned, share):
    path.write_text(abandoned[: int(share * len(abandoned))])
    with claim(path):
        assert path.read_text().count("\n") == abandoned.count("\n")
