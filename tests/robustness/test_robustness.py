"""The proofs of robustness at a size for every day; `make soak` runs them in full."""

import json
import os
import sys

import pytest

from robustness import preload, warm
from robustness.cluster import soak
from robustness.kills import SUBJECTS, Campaign

LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux") or preload.compiler() is None, reason="needs Linux and a C compiler"
)
KILLS = {"run": 6, "pack": 6, "solve": 1, "diagnose": 1}


@pytest.fixture(autouse=True)
def _surroundings(monkeypatch):
    """`warm` sets them for the processes that it starts; here they must end with the test."""
    for name in ("PYTHONPATH", "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, os.environ.get(name, ""))
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.chdir(warm.USERS)


@pytest.mark.parametrize("name", KILLS)
def test_kills_at_random_moments_lose_nothing(name, tmp_path):
    campaign = Campaign(SUBJECTS[name](), tmp_path / name, 0)
    campaign.go(KILLS[name])
    assert campaign.total == KILLS[name]
    fell = set(campaign.drawn + campaign.aimed)
    assert fell <= set(campaign.subject.phases)
    assert len(fell) > 1 or KILLS[name] < 6


def proof(module, tmp_path, *arguments):
    """What a proof found, in a process with the object that lets operations fail."""
    library = preload.compiled(tmp_path)
    process = preload.run_with(library, ["-m", f"robustness.{module}", "--place", str(tmp_path), *arguments])
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout.splitlines()[-1])


@LINUX
def test_every_kind_of_failure_of_the_file_system_is_told_or_harmless(tmp_path):
    warm.environment()
    found = proof("faults", tmp_path, "--every", "36")
    assert found["wrong"] == []
    assert sum(count for *_, count in found["outcomes"]) > 7


@LINUX
def test_several_writers_are_refused_or_right_whatever_locks_do(tmp_path):
    warm.environment()
    found = proof("writers", tmp_path, "--rounds", "1")
    assert set(found) == {"that work", "refused", "not there", "granted, not held"}
    for outcomes in found.values():
        assert any(outcome.endswith("done") for outcome in outcomes)
    assert any(outcome.endswith("refused") for outcomes in found.values() for outcome in outcomes)


def test_a_cluster_whose_workers_and_scheduler_die_finishes_every_cell_once(tmp_path):
    told = soak(tmp_path, cells=60, workers=3, seconds=0.3, seed=0)
    assert "60 records, each made once, all ok" in told
    assert "1 scheduler killed" in told
