"""The proofs of robustness at a size for every day; `make soak` runs them in full, and prints what came of them."""

import os
import sys

import pytest

from robustness import faults, preload, writers
from robustness.cluster import soak
from robustness.kills import SUBJECTS, campaign

LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux") or preload.compiler() is None, reason="needs Linux and a C compiler"
)
FULL = "SOAK" in os.environ
EVERY = {"run": 12, "pack": 6, "challenge solve": 9, "diagnose": 40}
"""Of the operations on files of a command, one in so many is tried in the suite."""


@pytest.mark.parametrize("name", SUBJECTS)
def test_kills_before_operations_on_files_lose_nothing(name, tmp_path):
    operations = campaign(name, tmp_path / name, 1 if FULL else EVERY[name])
    print(f"{name}: killed before each of {operations} operations on files, nothing lost, every end as undisturbed")
    assert operations >= 9


@LINUX
def test_every_kind_of_failure_of_the_file_system_is_told_or_harmless(tmp_path):
    found = preload.proof("faults", tmp_path, 1 if FULL else 36)
    print(faults.table(found))
    assert found["wrong"] == []
    assert sum(count for *_, count in found["outcomes"]) > 7


@LINUX
def test_several_writers_are_refused_or_right_whatever_locks_do(tmp_path):
    found = preload.proof("writers", tmp_path, 25 if FULL else 1)
    print(writers.table(found))
    assert set(found) == {"that work", "refused", "not there", "granted, not held"}
    for outcomes in found.values():
        assert any(outcome.endswith("done") for outcome in outcomes)
    assert any(outcome.endswith("refused") for outcomes in found.values() for outcome in outcomes)


@pytest.mark.parametrize("seed", range(3 if FULL else 1))
def test_a_cluster_whose_workers_and_scheduler_die_finishes_every_cell_once(seed, tmp_path, beside_users_modules):
    size = {"cells": 2000, "workers": 8, "seconds": 3.0} if FULL else {"cells": 60, "workers": 3, "seconds": 0.3}
    told = soak(tmp_path, **size, seed=seed)
    print(told)
    assert f"{size['cells']} records, each made once, all ok" in told
    assert "1 scheduler killed" in told
