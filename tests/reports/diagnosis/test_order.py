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
    ("given", "told"),
    [
        ({"kind": "drift"}, ("x1",)),
        ({"kind": "change point", "at": 1500.0, "of": "spread"}, ("spread of x1", "event 1500")),
        ({"kind": "season", "at": 0.99920, "along": "time", "feature": None}, ("count", "0.9992 in time")),
        ({"kind": "clustering", "at": 4}, ("x1", "4 apart")),
    ],
)
def test_a_finding_says_of_what_it_is_where_and_how_large_and_that_other_tests_rule_it_out(given, told):
    sentence, taken = said(finding(**given))
    assert all(part in sentence for part in (*told, "0.5 (its own unit)", "p = 0.0001"))
    assert taken == TAKEN


def test_a_changing_rate_leaves_the_other_tests_right():
    (sentence,) = said(finding(kind="drift", of="rate", feature=None, along="time", unit="of the mean rate"))
    assert sentence.startswith("the rate of events drifts by +0.5 (of the mean rate)")
