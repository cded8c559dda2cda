"""The study of few observed events: what its table counts."""

import pytest

from paper.studies import few


def test_errors_that_hold_have_an_rms_of_one_and_what_is_off_without_a_doubt_is_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(few, "METHODS", ("smm",))
    monkeypatch.setattr(few, "EVENTS", (300,))
    record = few.made(path := tmp_path / few.FILE.name, num_fits=2, budget=4000)
    assert few.made(path, num_fits=2, budget=4000) == record
    rows = few.table([record]).set_index("task")
    assert rows["fits"].tolist() == [2, 2, 2]
    assert rows.loc["poisson", "rms"] < 3
    off = [
        {"task": "t", "events": 1, "method": "m", "off": [each, 0.0], "doubt": said}
        for each, said in ((4, ""), (5, "d"))
    ]
    [row] = few.table([{"fits": off}]).to_dict("records")
    assert (row["silent"], row["doubted"], row["bias"]) == (1, 1, 2.25)
    assert row["rms"] == pytest.approx((41 / 4) ** 0.5)
