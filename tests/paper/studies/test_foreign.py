"""The cases of others stay those that were written down, and a study diagnoses each once."""

import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.tasks.errors import StoreError
from paper.foreign import measured, simulated
from paper.studies import foreign

CASES = {case.name: case for cases in foreign.CASES.values() for case in cases}


def test_the_tables_have_the_published_totals():
    totals = {"claims": (9461, 2028), "cholera": (223, 86), "deaths": (1096, 2364), "bombs": (576, 537)}
    totals |= {"yeast": (400, 1872)}  # 4.68 a square: Student
    assert {name: (len(x), x.sum()) for name in totals for x in [CASES[name].x()]} == totals
    assert (len(measured.CRABS), len(measured.STATURE)) == (1000, 928)
    assert 1 + (measured.CRABS.mean() - 0.5815) / 0.004 == pytest.approx(16.799)  # Pearson's mean, in classes
    assert [(CASES["arrests"].x() < 52).sum(), (CASES["arrests"].x() == 52).sum()] == [110, 322]


def test_cases_have_names_of_their_own_and_events_that_do_not_change():
    assert len(CASES) == len(simulated.CASES) + len(measured.CASES)
    for name in ("birds-heaped", "households-unreported"):
        np.testing.assert_array_equal(CASES[name].x(), CASES[name].x())


@pytest.mark.parametrize("number", [1, 3])
def test_a_family_has_as_many_shapes_as_it_may_the_plainest_first(number):
    entries = catalogue(CASES["earthquakes-null"].task)
    shapes = {}
    for effect in entries:
        shapes.setdefault(effect.key, []).extend(shape.shape for shape in effect.shapes())
    fewer = {}
    for effect in foreign.plainest(entries, number):
        fewer.setdefault(effect.key, []).extend(shape.shape for shape in effect.shapes())
    assert fewer == {key: own[:number] for key, own in shapes.items()}
    assert len({type(effect) for effect in foreign.plainest(entries, number)}) <= len({type(e) for e in entries})


def test_a_case_is_diagnosed_once_in_each_configuration(tmp_path, monkeypatch):
    few, cases = foreign.Configuration(1, False, 1_000_000), {"measured": [CASES["yeast"]]}
    [record] = foreign.made(tmp_path, few, cases=cases)
    assert record["diagnosis"]["num_simulations"] <= few.simulations
    monkeypatch.setattr(foreign, "said", lambda *_: pytest.fail("it was diagnosed again"))
    assert foreign.made(tmp_path, few, cases=cases) == [record] == foreign.read(tmp_path)[few.name]
    (tmp_path / few.name / "yeast.json").write_text("{}")
    with pytest.raises(StoreError, match="delete it"):
        foreign.made(tmp_path, few, cases=cases)
