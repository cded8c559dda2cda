import io

import pytest
from rich.console import Console

from avobench.api import progress
from avobench.api.progress import displayed


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_diagnosis_says_now_and_then_how_far_it_is_and_what_is_left(clock):
    console = Console(file=io.StringIO(), width=200)
    with displayed(console) as shown:
        shown("first fit", 1, 100)
        assert console.file.getvalue() == ""
        clock[0] += 40
        shown("gates", 25, 100)
        shown("gates", 26, 100)
        clock[0] += 40
        shown("checks", 100, 100)
    first, second = console.file.getvalue().splitlines()
    assert first == "gates: 25 simulated events, 25% of what is usual, about 2 min left"
    assert second == "checks: 100 simulated events"


def test_on_a_terminal_it_is_a_bar():
    console = Console(file=io.StringIO(), width=100, force_terminal=True)
    with displayed(console) as shown:
        shown("search for effect 1", 30, 100)
    assert "search for effect 1" in console.file.getvalue()
