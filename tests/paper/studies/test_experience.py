"""Examples of what effects look like, and what is learnt from them."""

import numpy as np
import pytest

from avobench.tasks.errors import UsageError
from paper.studies import experience
from paper.studies.experience import examples, of_kind
from shapes import SEEN


@pytest.fixture
def few(monkeypatch):
    """Three shapes, one pair, and few events."""
    monkeypatch.setattr(experience, "OWN", 0)
    monkeypatch.setattr(experience, "TWO", 1)
    monkeypatch.setattr(experience, "NUM_EVENTS", (3000, 3001))
    return SEEN[:3]


def test_examples_are_those_of_their_seed_with_their_families(few):
    one, again, other = (examples("poissons", 3, np.random.default_rng(seed), few) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.portraits, again.portraits)
    assert one.portraits.shape[1] == other.portraits.shape[1]
    assert len(one.portraits) != len(other.portraits) or not np.array_equal(one.portraits, other.portraits)
    assert set(one.families.ravel()) <= {shape.family for shape in few}


def test_what_was_kept_is_not_made_again_and_what_is_missing_is_told(few, tmp_path, monkeypatch):
    monkeypatch.setattr(experience, "LEARNT_FROM", ("poissons",))
    made = examples("poissons", 2, np.random.default_rng(0), few)
    made.write(tmp_path / "poissons.npz")
    before = (tmp_path / "poissons.npz").read_bytes()
    assert experience.made("poissons", 0, tmp_path).read_bytes() == before
    kept = of_kind("count", tmp_path)
    np.testing.assert_array_equal(kept.portraits, made.portraits)
    np.testing.assert_array_equal(kept.families, made.families)
    (tmp_path / "poissons.npz").unlink()
    with pytest.raises(UsageError, match=r"there is no .*poissons\.npz"):
        of_kind("count", tmp_path)
