from types import SimpleNamespace

import pytest

from avobench.diagnosis.schema import Disorder
from avobench.reports.diagnosis.order import NOTHING, TAKEN, sentences


def said(*found):
    return sentences(SimpleNamespace(order=list(found)))


def finding(**given):
    plain = {"feature": "x1", "of": "level", "at": None, "along": "index", "size": 0.5, "unit": "its own unit"}
    return Disorder(**{**plain, "p_value": 1e-4, **given})


def test_nothing_is_said_unless_it_was_asked():
    assert sentences(SimpleNamespace(order=None)) == []
    assert said() == [NOTHING]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"kind": "drift"}, "x1 drifts by +0.5 (its own unit) from the first event to the last, p = 0.0001"),
        (
            {"kind": "change point", "at": 1500.0, "of": "spread", "unit": "of its mean"},
            "the spread of x1 changes by +0.5 (of its mean) at event 1500, p = 0.0001",
        ),
        (
            {"kind": "season", "at": 0.99920, "along": "time", "feature": None},
            "the count has a season of period 0.9992 in time and amplitude 0.5 (its own unit), p = 0.0001",
        ),
        (
            {"kind": "clustering", "at": 4, "unit": "correlation"},
            "x1 is alike in events 4 apart, +0.5 (correlation), p = 0.0001",
        ),
    ],
)
def test_a_finding_is_a_sentence_and_the_other_tests_take_it_not_to_be(given, sentence):
    assert said(finding(**given)) == [sentence, TAKEN]


def test_a_changing_rate_leaves_the_other_tests_right():
    (sentence,) = said(finding(kind="drift", of="rate", feature=None, along="time", unit="of the mean rate"))
    assert sentence.startswith("the rate of events drifts by +0.5 (of the mean rate)")
