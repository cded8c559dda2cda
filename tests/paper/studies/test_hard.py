"""The study of hard fits: an interrupted one goes on, and its table says what is far off without a doubt."""

import pytest

from paper.hard_tasks import Bump
from paper.studies import hard as study


def test_what_is_lacking_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHODS", {"smm": ("smm", {})})
    monkeypatch.setattr(study, "DEVELOPMENT_TARGETS", 1)
    small = {"tasks": (Bump,), "num_events": 300, "budget": 2000}
    path = tmp_path / study.FILE.name
    first = study.made(path, num_targets=1, **small)["fits"]
    record = study.made(path, num_targets=2, **small)
    assert record["fits"][:1] == first
    assert study.read(tmp_path) == record
    assert study.table([record])["targets"].tolist() == ["seen", "unseen"]


def test_the_table_counts_what_is_far_off_without_a_doubt():
    def fit(off, error, doubt):
        kept = {"task": "bump", "target": 0, "method": "avo", "theta": [0.0, 0.0], "floors": [1.0, 4.0], "seconds": 1.0}
        return {**kept, "estimate": [0.0, off], "error": [1.0, error], "doubt": doubt}

    fits = [fit(2.0, 2.0, ""), fit(20.0, 2.0, "d"), fit(20.0, 20.0, ""), fit(20.0, 2.0, "")]
    [row] = study.table([{"fits": fits}]).to_dict("records")
    assert row["error / floor"] == "1, 1e+02 D, 1e+02, 1e+02"
    assert (row["far"], row["undoubted"], row["silent"]) == (3, 2, 1)
    assert row["rms pull"] == pytest.approx(((1 + 100 + 1 + 100) / 8) ** 0.5)
