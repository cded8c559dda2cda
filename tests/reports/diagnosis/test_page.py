"""The figures and the page of a diagnosis, the page in a real browser."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from avobench.diagnosis import Result
from avobench.diagnosis.answer.pictures import Maps, Pictures, Spectrum
from avobench.diagnosis.schema import Diagnosis, Verdict
from avobench.effects.model import Model
from avobench.reports.diagnosis import write
from avobench.tasks import Box, Task
from avobench.tasks.poisson import Poisson

HOSTILE = "<script>document.title = 'run'</script><img src=x onerror=alert(1)> & \"quotes\""
VALUE = {"value": 1.5, "std": 0.1}
EFFECT = {"name": "zero_inflation", "feature": None}


def diagnosis(task, verdict=Verdict.NAMED, **changes):
    named = verdict in (Verdict.NAMED, Verdict.REDUCED)
    theta = {name: VALUE for name in task.parameter_names}
    parameter = {"value": 0.04, "std": 0.002, "null": 0.0, "unit": "1"}
    found = {**EFFECT, "parameters": {"fraction": parameter}, "tied_with": [{**EFFECT, "name": "dead_time"}]}
    content = {
        "verdict": verdict,
        "alpha": 0.05,
        "p_value_before": 1e-9,
        "p_value_after": 0.4 if named else None,
        "gates": {"summary": {"statistic": 900.0, "dof": 12, "p_value": 1e-9}},
        "gap_before": {"value": 70.0, "low": 65.0, "high": 75.0},
        "gap_after": {"value": 1.1, "low": 0.6, "high": 1.6} if named else None,
        "theta_before": theta,
        "theta_after": theta if named else None,
        "identified_before": [],
        "identified_after": [] if named else None,
        "effects": [found] if named else [],
        "regions": [
            {"feature": None, "low": -0.5, "high": 0.5, "kind": "excess", "z": 20.0, "p_global": 0.0005},
            {"feature": None, "low": 3.5, "high": 6.5, "kind": "deficit", "z": -9.0, "p_global": 0.0005},
        ],
        "candidates": [
            {**EFFECT, "score": 3.5, "p_value": 0.4, "held_out_gap": 1.1},
            {**EFFECT, "name": "dead_time", "score": 3.6, "p_value": 0.3, "held_out_gap": 1.2},
            {**EFFECT, "name": "pile_up", "score": 6.0, "p_value": 1e-9, "held_out_gap": None},
        ],
        "identifiability": [
            {
                **EFFECT,
                "retained": 0.6,
                "minimum_detectable": 0.006,
                "theta_bias": {"log_rate": 0.01},
                "rivals": [EFFECT],
            }
        ],
        "notes": [HOSTILE],
        "num_events": 5000,
        "num_simulations": 100_000,
        "seconds": 2.0,
        "seed": 0,
        "versions": {"avobench": "0.1.0"},
    }
    pictures = Pictures((spectrum(task, named),), maps(named) if task.event_shape else None)
    fit = SimpleNamespace(model=Model(task))
    return Result(task, Diagnosis.model_validate({**content, **changes}), fit, pictures, None)


class Images(Task):
    """Images of 8 x 12 cells."""

    name, parameter_names, parameter_units, source = "images", ("rate",), ("1",), "test"
    prior = support = Box((0.1,), (0.9,))
    num_features, event_shape, dtype = 96, (8, 12), np.uint8
    simulate = summary = floor = None


def maps(after):
    """A cell that does not fire in the measurement."""
    before = np.full((8, 12), 0.5)
    measured = before * (np.indices((8, 12)).sum(axis=0) > 0)
    return Maps(measured, np.full((8, 12), 0.01), before, measured.copy() if after else None)


def spectrum(task, after):
    """Poisson counts with zeros in excess, without and with them in the simulation; shares of 5000 events."""
    before = np.array([0.02, 0.08, 0.2, 0.4, 0.2, 0.1])
    measured = 0.96 * before + 0.04 * np.eye(6)[0]
    error = np.sqrt(measured * (1 - measured) / 5000)
    edges = np.array([0, 0.5, 1.5, 2.5, 3.5, 4.5, 20])
    name = task.feature_names[0] if task.feature_names else "hits"
    return Spectrum(name, edges, measured, error, before, measured.copy() if after else None)


def test_the_page_opens_without_network_shows_its_figures_and_escapes(browser, tmp_path):
    task = Poisson()
    paths = write(task, diagnosis(task), tmp_path, title=HOSTILE)
    names = {"distribution-1", "gap", "theta", "candidates"}
    assert {path.name for path in paths} == {f"{name}.{kind}" for name in names for kind in ("pdf", "png", "csv")} | {
        "report.html"
    }
    assert (tmp_path / "gap.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "gap.png").read_bytes().startswith(b"\x89PNG")
    drawn = pd.read_csv(tmp_path / "distribution-1.csv")
    assert drawn["pull_before"][0] == pytest.approx(0.0392 / np.sqrt(0.0592 * 0.9408 / 5000), rel=1e-4)
    assert (drawn["pull_after"] == 0).all()
    browser.open(tmp_path / "report.html")
    assert browser.complaints() == []
    widths = browser.run("return [...document.images].map(image => image.naturalWidth)")
    assert len(widths) == len(names)
    assert min(widths) > 200
    assert browser.driver.title.startswith("<script>document.title")
    assert browser.run("return document.querySelector('h1').textContent") == HOSTILE
    assert browser.run("return document.querySelector('#notes li').textContent") == HOSTILE
    assert browser.run("return document.scripts.length") == 0
    assert browser.run("return document.querySelector('#verdict').textContent") == "missing effect named"
    text = browser.run("return document.body.innerText")
    for expected in ("zero_inflation", "cannot tell it from dead_time", "0.04 ± 0.002", "deficit", "log_rate 0.01"):
        assert expected in text


@pytest.mark.parametrize("verdict", [Verdict.NOTHING, Verdict.REDUCED], ids=lambda verdict: verdict.name.lower())
def test_every_verdict_has_a_page_also_where_there_is_nothing_to_show(browser, tmp_path, verdict):
    task = Images()
    row = {"feature": "row", "low": -0.5, "high": 1.5, "kind": "deficit", "z": -9.0, "p_global": 0.0005}
    regions = [row, {**row, "feature": "column"}] if verdict == Verdict.REDUCED else []
    content = diagnosis(task, verdict, regions=regions, candidates=[], identifiability=[], notes=[])
    named = content.diagnosis.theta_after is not None
    write(Poisson(), diagnosis(Poisson()), tmp_path, "of other data, with other figures")
    (tmp_path / "distribution-mine.csv").write_text("not of a diagnosis")
    paths = write(task, content, tmp_path, "images")
    assert {path.name for path in paths} | {"distribution-mine.csv"} == {path.name for path in tmp_path.iterdir()}
    browser.open(tmp_path / "report.html")
    assert browser.complaints() == []
    assert browser.run("return document.querySelector('#verdict').textContent") == str(verdict.value)
    assert browser.run("return document.querySelector('#figure-maps img').naturalWidth") > 200
    drawn = pd.read_csv(tmp_path / "maps.csv")
    assert (drawn["pull_before"][0], drawn["pull_before"][1:].abs().max()) == (-50, 0)
    assert ("pull_after" in drawn) == named
