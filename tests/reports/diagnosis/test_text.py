"""What is said follows from the verdict, the p-values, the gap and the ties."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.schema import Verdict
from avobench.reports.diagnosis.text import MEANT, details, meaning, summary
from diagnoses import diagnosis as made

NAMES = ("saturation", "outliers", "scale", "offset")


def named(name, feature="mass"):
    return {"name": name, "feature": feature}


def diagnosis(verdict, ties=0, p_before=1e-9, p_after=0.4, **changes):
    added = verdict in (Verdict.NAMED, Verdict.FAMILY)
    parameters = {
        "sigma": {"value": 1.5, "std": 0.1, "null": 0.0, "unit": "of the feature"},
        "knee": {"value": 0.924, "std": None, "null": None, "unit": "of half the range"},
    }
    found = {**named(NAMES[0]), "parameters": parameters, "tied_with": list(map(named, NAMES[1 : 1 + ties]))}
    ranks = [{**named(name), "score": 1.0, "p_value": 0.3, "held_out_gap": 1.0} for name in NAMES]
    content = {
        "p_value_before": p_before,
        "p_value_after": p_after if added else None,
        "gates": {
            "summary": {"statistic": 60.0, "dof": 43, "p_value": 0.8 * p_before, "share": 0.8},
            "cells": {"statistic": 1.0, "dof": None, "p_value": 0.5, "share": 0.2, "sides": 2},
        },
        "theta_before": {"mu": {"value": 1.0, "std": 0.1}},
        "identified_after": None,
        "effects": [found] if added else [],
        "regions": [
            {"feature": "mass", "low": 3, "high": 4, "kind": "excess", "z": 5.0, "p_global": 0.001, "unit": "GeV"}
        ],
        "candidates": ranks if added else [],
    }
    return made(verdict, **{**content, **changes})


GAPS = st.lists(st.floats(0.2, 900), min_size=3, max_size=3).map(
    lambda ends: dict(zip(("low", "value", "high"), sorted(ends), strict=True))
)
P = st.floats(-300, 0).map(lambda power: 10**power)


@given(st.sampled_from([Verdict.NAMED, Verdict.FAMILY, Verdict.UNEXPLAINED]), P, GAPS, GAPS, st.integers(0, 3))
def test_no_sentence_contradicts_a_number_beside_it(verdict, p_after, before, after, ties):
    """Whatever the numbers of a result are, also if the search and the tests would not have made it."""
    added = verdict != Verdict.UNEXPLAINED
    models = [{"effects": [named("saturation")], "probability": 0.6}]
    changes = {"gap_before": before, "models": models, "outside": 0.37} | ({"gap_after": after} if added else {})
    one = diagnosis(verdict, ties, p_after=p_after, **changes)
    for said in (summary(one), details(one)):
        assert ("the gap shrinks" not in said) or after["value"] < before["value"]
        agree = "With it, simulation and measurement agree" in said
        assert not agree or (p_after >= one.alpha and verdict == Verdict.NAMED)
        assert ("is most probably" not in said) or (verdict == Verdict.NAMED and not ties)
        assert ("\nmissing: " in said) == (verdict == Verdict.NAMED)
        assert MEANT in said  # no probability without what it means
    if verdict == Verdict.UNEXPLAINED:
        assert "as if events were added: excess at mass 3 to 4 GeV" in meaning(one)


def test_p_values_are_printed_as_they_are_compared_with_alpha_and_say_how_many_sides():
    told = details(diagnosis(Verdict.NOTHING, p_before=0.055))
    assert "(compare with 0.05): summary 0.055 (one-sided), cells 1 (two-sided)" in told
    assert "0.044" not in told  # which is below alpha


def test_numbers_say_in_which_unit_and_of_which_feature():
    told = details(diagnosis(Verdict.NAMED))
    for part in (
        "sigma = 1.50 ± 0.10 in the unit of mass",
        "knee = 0.924 of half the range of mass (read off the events)",
    ):
        assert part in told
    assert "excess at mass 3 to 4 GeV" in told


def test_a_summary_is_ten_lines_with_what_was_found_and_the_rest_is_in_the_details():
    each = {"outliers": 0.21, "smearing": 0.62, "scale": 0.001}
    probable = [{**named(name, None), "probability": p} for name, p in each.items()]
    models = [{"effects": [named("smearing", None)], "probability": 0.62}, {"effects": [], "probability": 0.35}]
    one = diagnosis(Verdict.NAMED, probabilities=probable, outside=0.15, models=models, notes=["A note."])
    short, long = summary(one), details(one)
    assert len(short.splitlines()) <= 10
    both = (
        "saturation on mass",
        "sigma = 1.50 ± 0.10",
        "smearing, 0.62; the simulator as it is, 0.35",
        "1.10 [0.60, 1.60]",
    )
    rest = ("smearing, 0.62; outliers, 0.21; something outside the catalogue, 0.15\n", "A note.", "one-sided")
    assert [part for part in (*both, *rest) if part in short] == [*both]
    assert all(part in long for part in (*both, *rest))
    assert "probability" not in details(diagnosis(Verdict.NAMED))


def decision(events, low, high, condition="", **where):
    pair = {"true": [named("saturation")], "rival": [named("scale")], "chi_squared": 14.2}
    return pair | {"condition": condition, "events": events, "low": low, "high": high, **where}


def test_it_is_said_how_many_events_would_decide_and_of_which_set():
    place = {"where": {"feature": "mass", "low": 9.2, "high": 12, "kind": "excess", "unit": "GeV"}, "share": 0.71}
    same, one = decision(178_400, 90_000, 1_250_000, **place), decision(20_300, 9000, 40_000, "46 GeV")
    short = summary(diagnosis(Verdict.NAMED, decisions=[same, decision(None, 5, None, "45 GeV"), one]))
    assert "180 000 more events (90 000 to 1 200 000) would tell saturation on mass from scale on mass." in short
    assert "71 % of the difference is its excess at mass 9.2 to 12 GeV." in short
    assert "20 000 more events (9 000 to 40 000) of 46 GeV alone would." in short


@pytest.mark.parametrize(
    ("numbers", "word"),
    [((None, None, None), "look the same"), ((None, 31_000, None), "at least 31 000"), ((0, 0, 0), "14 larger")],
)
def test_no_number_is_said_where_none_is_known_or_needed(numbers, word):
    told = details(diagnosis(Verdict.NAMED, decisions=[decision(*numbers)]))
    assert word in told
    assert "more events (" not in told


@pytest.mark.parametrize(("chi_squared", "ahead"), [(33.0, "saturation"), (-9.0, "scale"), (1.0, None)])
def test_enough_events_speak_for_the_model_that_is_nearer_to_them_or_for_neither(chi_squared, ahead):
    told = details(diagnosis(Verdict.NAMED, decisions=[decision(0, 0, 0) | {"chi_squared": chi_squared}]))
    (said,) = [line for line in told.splitlines() if "chi-squared is" in line]
    assert said.startswith(f"These events speak for {ahead} ") == (ahead is not None)
