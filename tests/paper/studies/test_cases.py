"""The cases of others stay those that were written down, and a study diagnoses each once."""

import numpy as np
import pytest

from avobench.tasks.errors import StoreError
from paper.cases.opened.first import measured
from paper.studies import cases

ALL = [case for groups in cases.CASES.values() for some in groups.values() for case in some]
CASES = {case.name: case for case in ALL}


def test_the_tables_have_the_published_totals():
    totals = {"claims": (9461, 2028), "cholera": (223, 86), "deaths": (1096, 2364), "bombs": (576, 537)}
    totals |= {"yeast": (400, 1872)}  # 4.68 a square: Student
    assert {name: (len(x), x.sum()) for name in totals for x in [CASES[name].x()]} == totals
    assert (len(measured.CRABS), len(measured.STATURE)) == (1000, 928)
    assert 1 + (measured.CRABS.mean() - 0.5815) / 0.004 == pytest.approx(16.799)  # Pearson's mean, in classes
    assert [(CASES["arrests"].x() < 52).sum(), (CASES["arrests"].x() == 52).sum()] == [110, 322]


def test_cases_have_names_of_their_own_and_events_that_do_not_change():
    assert len(CASES) == len(ALL)
    for name in ("birds-heaped", "households-unreported"):
        np.testing.assert_array_equal(CASES[name].x(), CASES[name].x())


def test_a_case_is_diagnosed_once_in_each_configuration(tmp_path, monkeypatch):
    few, chosen = cases.Configuration(False, 1_000_000), {"measured": [CASES["yeast"]]}
    [record] = cases.made(tmp_path, few, chosen)
    assert record["diagnosis"]["num_simulations"] <= few.simulations
    monkeypatch.setattr(cases, "said", lambda *_: pytest.fail("it was diagnosed again"))
    assert cases.made(tmp_path, few, chosen) == [record] == cases.read(tmp_path / few.name)
    (tmp_path / few.name / "yeast.json").write_text("{}")
    with pytest.raises(StoreError, match="delete it"):
        cases.made(tmp_path, few, chosen)


def test_a_record_has_what_each_set_was_told_by():
    told = cases.said(CASES["birds-empty"], cases.Configuration(False, 1_000_000))
    *sets, outside = told["sets"]
    probable = [each["effects"] for each in told["diagnosis"]["models"]]
    assert all(each in [one["effects"] for one in sets] for each in probable)
    assert outside["effects"] is None
    assert np.isfinite([each["marks"] for each in told["sets"]]).all()
