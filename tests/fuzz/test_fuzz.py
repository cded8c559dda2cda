"""A few hostile inputs of every kind; `make fuzz` tries a thousand of each."""

import pytest

from fuzz import answers
from fuzz.__main__ import outcomes
from fuzz.inputs import Bomb
from fuzz.targets import GUARD, KINDS, Events, Manifests, Models

EXAMPLES = 15
FORMATS = ("npy", "npz", "csv", "parquet", "root")


@pytest.mark.parametrize("kind", [*KINDS, *answers.KINDS], ids=lambda kind: kind.name)
def test_no_input_is_taken_for_what_it_is_not_or_does_harm(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(answers, "RARE", 1000)  # avo takes seconds, and methods/test_inputs.py has it
    assert outcomes(kind(tmp_path), EXAMPLES, 0).total() == EXAMPLES


@pytest.mark.parametrize("kind", FORMATS)
def test_no_file_of_events_is_taken_for_what_it_is_not_or_does_harm(kind, tmp_path):
    assert outcomes(Events(tmp_path, kind), EXAMPLES, 0).total() == EXAMPLES


@pytest.mark.parametrize("spec", ["planted:X", "planted.py:X"])
def test_a_model_runs_no_code_that_it_names(spec, tmp_path):
    models = Models(tmp_path)
    assert models.check({**models.document, "task": spec}) == "refused"


def test_a_manifest_runs_no_code_that_it_names(tmp_path):
    manifests = Manifests(tmp_path)
    assert manifests.check({**manifests.document, "task": "planted:X"}) == "refused"


@pytest.mark.parametrize("name", ["../../x", "/x", "..", ""])
def test_a_manifest_leads_to_no_other_folder(name, tmp_path):
    manifests = Manifests(tmp_path)
    assert manifests.check({**manifests.document, "cases": [{"case": name, "effects": None}]}) == "refused"


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
