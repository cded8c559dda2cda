"""Who writes to a folder whose locks cannot be trusted."""

import json
import os
import socket
import subprocess
import sys
import time

import pytest

from avobench.bench.store import claim as module
from avobench.bench.store.claim import STALE_SECONDS, claim
from avobench.tasks.errors import UsageError


@pytest.fixture
def path(tmp_path):
    return tmp_path / ".writer"


def test_a_second_writer_is_refused_by_name_and_the_file_goes_with_the_first(path):
    with claim(path):
        with pytest.raises(UsageError, match=f"process {os.getpid()} on {socket.gethostname()}"), claim(path):
            pass
        assert json.loads(path.read_text())["pid"] == os.getpid()
    assert list(path.parent.iterdir()) == []


def test_a_writer_of_this_machine_that_was_killed_is_taken_over_at_once(path):
    code = "import os, signal; from pathlib import Path; from avobench.bench.store.claim import claim\n"
    code += f"with claim(Path({str(path)!r})): os.kill(os.getpid(), signal.SIGKILL)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == -9
    assert path.exists()
    with claim(path):
        assert json.loads(path.read_text())["pid"] == os.getpid()
    assert not path.exists()


def test_another_process_of_the_same_number_is_not_the_writer(path):
    path.write_text(json.dumps({"host": socket.gethostname(), "pid": os.getpid(), "started": "1"}))
    with claim(path):
        pass


@pytest.mark.parametrize("content", ['{"host": "elsewhere", "pid": 1, "started": "1"}', "", "[]", "nonsense"])
def test_a_writer_elsewhere_is_taken_over_only_once_it_has_long_been_silent(path, content):
    path.write_text(content)
    with pytest.raises(UsageError, match="another avobench run"), claim(path):
        pass
    silent = time.time() - STALE_SECONDS - 5
    os.utime(path, (silent, silent))
    with claim(path):
        pass


def test_a_writer_shows_that_it_is_there(path, monkeypatch):
    monkeypatch.setattr(module, "BEAT_SECONDS", 0.05)
    with claim(path):
        os.utime(path, (0, 0))
        deadline = time.monotonic() + 10
        while path.stat().st_mtime == 0:
            assert time.monotonic() < deadline
            time.sleep(0.02)


def test_a_file_system_without_links_has_claims_too(path, monkeypatch):
    def refuses(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuses)
    with claim(path), pytest.raises(UsageError, match="another avobench run"), claim(path):
        pass
    assert not path.exists()
