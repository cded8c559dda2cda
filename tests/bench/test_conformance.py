"""The conformance suite passes what is sound and tells each fault by the check that it breaks."""

import re

import faulty
import numpy as np
import pytest

from avobench.bench import conformance as check


@pytest.fixture(autouse=True)
def _error_state():
    with np.errstate():  # one of the faults changes it
        yield


SOUND = ("task poisson", "task carl", "task weinberg", "task faulty:SoundTask", "task faulty:SoundGenerator")


@pytest.mark.parametrize("name", [*SOUND, "method faulty:SoundMethod", "method smm"])
def test_what_is_sound_passes(name):
    results = list(check.run(*name.split()))
    assert len(results) > 12
    assert all(result.passed and result.why == "" for result in results)


BASES = {"task": faulty.SoundTask, "method": faulty.SoundMethod}
FAULTY = [
    (kind, name, found.breaks)
    for kind, base in BASES.items()
    for name, found in vars(faulty).items()
    if isinstance(found, type) and issubclass(found, base) and hasattr(found, "breaks")
]


@pytest.mark.parametrize(("kind", "name", "breaks"), FAULTY)
def test_what_is_faulty_fails_on_what_it_breaks(kind, name, breaks):
    faults = {result.what: result.why for result in check.run(kind, f"faulty:{name}") if not result.passed}
    assert next(iter(faults)).startswith(breaks)
    assert all(reason and "\n" not in reason for reason in faults.values())


def test_the_command_prints_every_check_and_fails_with_one_line(avobench):
    code, out, err = avobench("check", "task", "faulty:FirstTheta")
    assert code == 1
    assert len(re.findall(r"^pass  [a-z ]", out, re.M)) > 10
    assert len(re.findall(r"^FAIL  [a-z ,]+: at theta = ", out, re.M)) == 1
    assert err.splitlines() == ["avobench: task faulty:FirstTheta does not keep the contract"]
    assert avobench("check", "task", "faulty:SoundTask")[0] == 0
