"""How far what was named misses the truth."""

from pathlib import Path

import numpy as np
import pytest

from avobench.challenge.case import Case
from avobench.challenge.records import read_records
from avobench.tasks.poisson import Poisson
from paper.tables import undecided

RECORDS = Path(__file__).parents[3] / "results" / "challenge" / "poisson-sixth-40.jsonl"


@pytest.fixture
def named():
    """A case in which an effect was named, of a hidden share of empty events."""
    head, *rows = read_records(RECORDS)
    row = next(row for row in rows if row["effects"][0]["shape"] == "StuckShutter" and row["kind"] == "foreign")
    return Case(Poisson(), row, row["diagnosis"]), head


def test_what_was_hidden_is_made_again_as_it_was(named):
    case, head = named
    (answer,) = case.answer["effects"]
    assert undecided.injection(case, head, int(case.answer["case"])).settings == answer["settings"]


def test_the_right_effect_misses_the_truth_by_less_than_none(named, monkeypatch):
    monkeypatch.setattr(undecided, "NUM_SIMULATED", 200_000)
    case, head = named
    model, params = undecided.named(case)
    found = undecided.misses(case, head, int(case.answer["case"]))
    monkeypatch.setattr(undecided, "named", lambda _: (model.minus(0), params[:1]))
    assert 5 * found < undecided.misses(case, head, int(case.answer["case"]))


def test_the_truth_misses_itself_by_chance_alone(named, monkeypatch):
    monkeypatch.setattr(undecided, "NUM_SIMULATED", 200_000)
    case, head = named
    number = int(case.answer["case"])
    true = undecided.injection(case, head, number)

    class Truth:
        def simulate(self, theta, rng):
            return true.measure(Poisson().simulate, theta, rng)

    monkeypatch.setattr(undecided, "named", lambda _: (Truth(), np.array(case.answer["theta"])))
    assert abs(undecided.misses(case, head, number)) < 5
