import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from avobench.api import progress
from avobench.api.progress import displayed, shown


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_diagnosis_says_now_and_then_how_far_it_is_and_what_is_left(clock):
    console = Console(file=io.StringIO(), width=200)
    with displayed(console) as tell:
        tell("first fit", 1, 100)
        assert console.file.getvalue() == ""
        clock[0] += 40
        tell("gates", 25, 100)
        tell("gates", 26, 100)
        clock[0] += 40
        tell("checks", 100, 100)
    first, second = console.file.getvalue().splitlines()
    assert first == "gates: 25 simulated events, 25% of what is usual, about 2 min left"
    assert second == "checks: 100 simulated events"


def test_on_a_terminal_it_is_a_bar():
    console = Console(file=io.StringIO(), width=100, force_terminal=True)
    with displayed(console) as tell:
        tell("search for effect 1", 30, 100)
    assert "search for effect 1" in console.file.getvalue()


def test_in_a_notebook_it_is_one_line_that_changes_and_is_empty_at_the_end(clock, monkeypatch):
    lines = []

    def display(line, display_id=None):
        lines.append(line.data)
        return SimpleNamespace(update=display)

    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setattr("IPython.display.display", display)
    with shown(None) as tell:
        for done in (10, 50, 90):
            clock[0] += 2
            tell("smm", done, 100)
    assert lines[0].startswith("smm: 10 simulated events, 10%")
    assert lines[2:] == ["smm: 90 simulated events, 90% of what is usual, about 0.7 s left", ""]
