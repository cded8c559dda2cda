"""What is said of real data is judged by what was written down before."""

import pytest

from avobench.diagnosis.schema import Verdict
from paper.tables.real import format_table, judged


def said(*effects, verdict=Verdict.NAMED, **values):
    """A diagnosis that names effects: each a name, or a list of one with those that are tied with it."""
    lists = [effect if isinstance(effect, list) else [effect] for effect in effects]
    parameters = {name: {"value": value, "std": None} for name, value in values.items()}
    found = [{"name": a, "parameters": parameters, "tied_with": [{"name": b} for b in rest]} for a, *rest in lists]
    return {"verdict": verdict, "effects": found}


def known(*answer, also=(), value=None):
    return {"answer": list(answer), "also": list(also), "value": value}


LINE = {"parameter": "centre", "value": 867.38, "tolerance": 0.4, "unit": "keV"}


@pytest.mark.parametrize(
    ("expected", "diagnosis", "judgement"),
    [
        (known(), said(verdict=Verdict.NOTHING), "right"),
        (known(), said(verdict=Verdict.UNEXPLAINED), "wrong"),
        (known(), said("offset"), "wrong"),
        (known("offset"), said("offset"), "right"),
        (known("offset", "scale"), said("scale"), "right"),
        (known("offset"), said(verdict=Verdict.NOTHING), "wrong"),
        (known("offset"), said(verdict=Verdict.UNEXPLAINED), "wrong"),
        (known("offset"), said("scale"), "wrong"),
        (known("offset"), said(["scale", "offset"]), "defensible"),
        (known("offset"), said("scale", "offset"), "defensible"),
        (known("offset", also=["scale"]), said("scale"), "defensible"),
        (known("offset", also=["scale"]), said("outliers", "scale"), "wrong"),
        (known("peak", value=LINE), said("peak", centre=867.1), "right"),
        (known("peak", value=LINE), said("peak", centre=867.9), "wrong"),
        (known("peak", value=LINE), said("peak", place=867.4), "wrong"),
    ],
)
def test_a_diagnosis_is_judged(expected, diagnosis, judgement):
    assert judged(expected, diagnosis) == judgement


def test_what_is_said_with_every_seed_is_counted():
    gap = {"value": 2.0, "low": 1.0, "high": 3.0}
    more = {"num_events": 300, "gap_before": gap, "gap_after": None, "p_value_before": 0.01, "p_value_after": None}
    told = [said("offset"), said("scale"), said(["scale", "offset"])]
    seeds = [
        [{"name": "data", "expected": known("offset"), "diagnosis": {**each, **more}, "processor_seconds": 1.0}]
        for each in told
    ]
    *_, row, counts = format_table(seeds).splitlines()
    assert row.split()[-4:] == ["right", "1", "1", "1"]
    assert counts == "1 data sets with 3 seeds each: 1 right, 1 defensible, 1 wrong"
