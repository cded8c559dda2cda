"""What is said of cases of others is judged by what was written down before."""

import pytest

from avobench.diagnosis.schema import Verdict
from paper.studies.cases import CASES
from paper.tables import cases

CASE = {"single": "spikes_gain", "pair": "spikes_down_states", "null": "spikes_plain"}


def effect(label):
    name, _, feature = label.partition(" on ")
    return {"name": name, "feature": feature or None}


def record(kind, effects=(), verdict=Verdict.NAMED, models=(), outside=0.0):
    case = next(case for case in CASES["opened"]["simulated"] if case.name == CASE.get(kind, kind))
    models = [{"effects": [effect(label) for label in labels], "probability": share} for labels, share in models]
    diagnosis = {"verdict": verdict, "effects": [*map(effect, effects)], "models": models, "outside": outside}
    return {"case": case.name, "right": case.right, "defensible": case.defensible, "diagnosis": diagnosis}


OUTSIDE = next(case.name for case in CASES["opened"]["simulated"] if case.kind == "outside")


@pytest.mark.parametrize(
    ("of", "right"),
    [
        (record("null", verdict=Verdict.NOTHING), True),
        (record("null", verdict=Verdict.UNEXPLAINED), False),
        (record("single", ["overdispersion"]), True),
        (record("single", ["mixture"]), False),
        (record("single", verdict=Verdict.NOTHING), False),
        (record("pair", ["zero_inflation", "dead_time"]), True),
        (record("pair", ["zero_inflation"]), False),
        (record(OUTSIDE, verdict=Verdict.UNEXPLAINED), True),
        (record(OUTSIDE, verdict=Verdict.NOTHING), False),
        (record(OUTSIDE, ["mixture"], models=[(["mixture"], 0.3)], outside=0.4), True),
        (record(OUTSIDE, ["mixture"], models=[(["mixture"], 0.5)], outside=0.4), False),
    ],
)
def test_an_answer_is_right_or_not(of, right):
    assert cases.right(of) == right


def test_only_the_right_effects_and_no_others_are_the_truth():
    one = record("single", models=[(["overdispersion", "mixture"], 0.5)])
    assert not cases.in_set(one)
    assert cases.in_set(record("single", models=[(["mixture"], 0.5), (["overdispersion"], 0.1)]))
    assert cases.in_set(record("pair", models=[(["dead_time", "zero_inflation"], 0.1)]))
    assert not cases.in_set(record("pair", models=[(["dead_time"], 0.5), (["zero_inflation"], 0.4)]))


def fits(**q):
    """A record of a single overdispersion, with so large a chi-squared for each effect alone, and of a pair."""
    sets = [{"effects": [{"name": name, "feature": None}], "q": each, "dof": 9} for name, each in q.items()]
    both = {"effects": [{"name": "overdispersion", "feature": None}, {"name": "mixture", "feature": None}], "q": 1.0}
    return record("single") | {"sets": [{"effects": [], "q": 2.0}, *sets, both, {"effects": None}]}


def test_the_simplest_rule_takes_the_effect_that_fits_best_alone():
    assert cases.lowest_right(fits(overdispersion=5.0, mixture=6.0))
    assert not cases.lowest_right(fits(overdispersion=5.0, mixture=4.0))
    assert not cases.lowest_right(record("single") | {"sets": []})


def test_one_misleads_that_fits_far_better_than_the_right_one():
    assert not cases.misled(fits(overdispersion=14.0, mixture=5.0))
    assert cases.misled(fits(overdispersion=16.0, mixture=5.0))
    assert cases.misled(fits(mixture=5.0))
    assert not cases.misled(fits(overdispersion=50.0))
