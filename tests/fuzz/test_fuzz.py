"""A few hostile inputs of every kind; `make fuzz` tries a thousand of each."""

import os
import time
from collections import Counter
from functools import partial

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from fuzz import answers
from fuzz.inputs import Bomb
from fuzz.targets import GUARD, KINDS, Events, Manifests

EXAMPLES = int(os.environ.get("FUZZ", 15))
FORMATS = ("npy", "npz", "csv", "parquet", "root")


def outcomes(target):
    """What became of the examples. Raises AssertionError for the first bad one, as small as it can be made."""
    found, begun = Counter(), time.monotonic()
    how = {"database": None, "suppress_health_check": list(HealthCheck), "phases": (Phase.generate, Phase.shrink)}

    @seed(int(os.environ.get("FUZZ_SEED", 0)))
    @settings(max_examples=EXAMPLES, **how)
    @given(target.inputs())
    def check(made):
        found[target.check(made)] += 1

    check()
    counts = f"{found['taken']:6} taken {found['refused']:6} refused"
    print(f"{target.name:16}{found.total():6} inputs {counts} {time.monotonic() - begun:6.0f} s")
    return found


MADE = {kind.name: kind for kind in (*KINDS, *answers.KINDS)} | {kind: partial(Events, kind=kind) for kind in FORMATS}


@pytest.mark.parametrize("kind", MADE)
def test_no_input_is_taken_for_what_it_is_not_or_does_harm(kind, tmp_path):
    assert outcomes(MADE[kind](tmp_path)).total() == EXAMPLES


@pytest.mark.parametrize("name", ["../../x", "/x", "..", "", None])
def test_a_manifest_leads_to_no_other_folder_and_runs_no_code_that_it_names(name, tmp_path):
    manifests = Manifests(tmp_path)
    change = {"task": "planted:X"} if name is None else {"cases": [{"case": name, "effects": None}]}
    assert manifests.check(manifests.document | change) == "refused"


def test_the_guard_sees_what_it_must(tmp_path):
    """A guard that sees nothing would let every other test here pass."""
    own, other = tmp_path / "own", tmp_path / "other"
    own.mkdir()
    other.mkdir()
    with GUARD.watching(own):
        (own / "x").write_text("")
    with pytest.raises(AssertionError, match="other"), GUARD.watching(own):
        (other / "x").write_text("")
    with pytest.raises(AssertionError, match=r"os\.rename"), GUARD.watching(own):
        (own / "x").rename(other / "y")
    with pytest.raises(AssertionError, match="foreign code"), GUARD.watching(own):
        Bomb(own / "was-run").__reduce__()[0](own / "was-run")
    (own / "was-run").unlink()
