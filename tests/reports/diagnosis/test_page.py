"""The figures and the page of a diagnosis, the page in a real browser."""

import itertools
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from avobench.diagnosis import Result
from avobench.diagnosis.report.result import Maps, Pictures, Spectrum
from avobench.diagnosis.schema import Region, Verdict
from avobench.effects.model import Model
from avobench.reports.diagnosis import write
from avobench.reports.diagnosis.distribution import distribution
from avobench.reports.diagnosis.page import render
from avobench.tasks import Box, Task
from avobench.tasks.poisson import Poisson
from diagnoses import diagnosis as made

HOSTILE = "<script>document.title = 'run'</script><img src=x onerror=alert(1)> & \"quotes\""
VALUE = {"value": 1.5, "std": 0.1}
EFFECT = {"name": "zero_inflation", "feature": None}


def diagnosis(task, verdict=Verdict.NAMED, **changes):
    named = verdict in (Verdict.NAMED, Verdict.FAMILY)
    theta = {name: VALUE for name in task.parameter_names}
    parameter = {"value": 0.04, "std": 0.002, "null": 0.0, "unit": "1"}
    found = {**EFFECT, "parameters": {"fraction": parameter}, "tied_with": [{**EFFECT, "name": "dead_time"}]}
    card = {**EFFECT, "retained": 0.6, "minimum_detectable": 0.006, "theta_bias": {"log_rate": 0.01}}
    content = {
        "gates": {"summary": {"statistic": 900.0, "dof": 12, "p_value": 1e-9}},
        "gap_before": {"value": 70.0, "low": 65.0, "high": 75.0},
        "theta_before": theta,
        "theta_after": theta if named else None,
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
        "identifiability": [{**card, "rivals": [EFFECT]}],
        "notes": [HOSTILE],
        "num_events": 5000,
    }
    pictures = Pictures((spectrum(task, named),), maps(named) if task.event_shape else None)
    return Result(task, made(verdict, **{**content, **changes}), SimpleNamespace(model=Model(task)), pictures, None)


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
    names = {"distribution-1", "theta"}
    files = {f"{name}.{kind}" for name in names for kind in ("pdf", "png", "csv")}
    assert {path.name for path in paths} == files | {"report.html"}
    assert (tmp_path / "theta.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "theta.png").read_bytes().startswith(b"\x89PNG")
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
    assert browser.run("return document.scripts.length") == 1  # the page's own
    assert browser.run("return document.querySelector('#verdict').textContent") == "missing effect named"
    text = browser.run("return document.body.innerText")
    for expected in (
        "the 95 % set has 2",
        "one-sided",
        "zero_inflation",
        "Others of the 95 % set: dead_time",
        "0.0400 ± 0.0020",
        "deficit",
        "log_rate 0.01",
    ):
        assert expected in text


NARROW = {"feature": None, "kind": "excess", "z": 12.1, "p_global": 0.0005}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of a diagnosis with p-values of 0 and an excess at the very edge of a feature."""
    task, folder = Poisson(), tmp_path_factory.mktemp("edge")
    content = diagnosis(task, p_value_before=0.0, regions=[{**NARROW, "low": 0.99, "high": 1.0}])
    told = content.diagnosis
    told.candidates[2].p_value = told.gates["summary"].p_value = 0.0
    content = replace(content, pictures=Pictures((edge(12.0),)))
    write(task, content, folder, "an excess at the edge")
    return folder


@pytest.fixture
def opened(folder, browser):
    browser.open(folder / "report.html")
    return browser


def edge(pull):
    """A flat feature of 100 bins from 0 to 1, with a measurement that exceeds it in the last one."""
    before, error = np.full(100, 0.01), np.full(100, 1e-3)
    measured = before + pull * error * np.eye(100)[-1]
    return Spectrum("angle", np.linspace(0, 1, 101), measured, error, before, measured - error)


def test_no_p_value_is_told_as_zero(opened):
    assert opened.run("return document.body.innerText").count("p < 1e-300") == 1
    assert [cell.text for cell in opened.driver.find_elements("css selector", "#tests td")][-1] == "< 1e-300"
    column = [cell.text for cell in opened.driver.find_elements("css selector", "#candidates td:nth-child(3)")]
    assert column == ["0.4", "0.3", "< 1e-300"]


@pytest.mark.parametrize("width", [1300, 800, 390])
def test_no_window_needs_a_horizontal_scrollbar(opened, width):
    opened.require_fit(width)


def test_the_page_says_what_the_numbers_say():
    gates = {"summary": {"statistic": 60.0, "dof": 43, "p_value": 0.044, "share": 0.8}}
    probable = [{**EFFECT, "probability": 0.62}]
    task = Poisson()
    nothing = render(task, diagnosis(task, Verdict.NOTHING, gates=gates, p_value_before=0.055), [], "title")
    assert "These data do not contradict the simulator (p = 0.055, alpha = 0.05)" in nothing
    assert "0.055" in nothing[nothing.index("corrected p") :]
    assert "Probability of being in the model" not in nothing
    ranked = render(task, diagnosis(task, probabilities=probable, outside=0.15), [], "title")
    assert "Probability of being in the model: zero_inflation, 0.62; something outside the catalogue, 0.15." in ranked
    assert "is most probably" not in ranked  # of two that are tied


def test_a_narrow_region_at_the_edge_is_seen_and_labelled():
    region = Region.model_validate({**NARROW, "low": 0.995, "high": 1.0})
    axis = distribution(edge(12.0), [region], "distribution-1").figure.axes[0]
    (span,) = (patch for patch in axis.patches if patch.get_label() == "excess")
    drawn = span.get_extents().transformed(axis.transData.inverted()).intervalx
    assert tuple(drawn) == pytest.approx((0.988, 1))
    assert [text.get_text() for text in axis.texts] == [r"$+12.1\,\sigma$"]


def test_a_table_is_drawn_over_its_feature_and_its_last_bin_does_not_squeeze_the_others():
    published = replace(spectrum(Poisson(), after=True), feature="table 1", axis="count", unit="keV")
    far = replace(published, edges=np.append(published.edges[:-1], 1e9))
    for drawn in (published, far):
        shown = distribution(drawn, [], "distribution-1", drawn.unit)
        *_, last = shown.figure.axes
        assert last.get_xlabel() == "count [keV]"
        assert last.get_xlim() == (0, 9)
        assert f"reaches to {drawn.edges[-1]:g}" in shown.caption
        assert shown.table["high"].iloc[-1] == drawn.edges[-1]


def test_labels_of_near_regions_do_not_stand_on_each_other():
    near = ((0.5, 5), (0.56, 6), (0.62, 7), (0.9, 8))
    regions = [Region.model_validate({**NARROW, "low": low, "high": low + 0.05, "z": z}) for low, z in near]
    figure = distribution(edge(12.0), regions, "distribution-1").figure
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(boxes) == 4
    assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


@pytest.mark.parametrize(("pull", "scale"), [(3.0, "linear"), (12.0, "linear"), (80.0, "symlog")])
def test_pulls_before_and_after_have_one_scale(pull, scale):
    drawn = distribution(edge(pull), [], "distribution-1")
    _, before, after = drawn.figure.axes
    assert before.get_ylim() == after.get_ylim()
    assert before.get_ylim()[1] >= pull
    assert before.get_yscale() == after.get_yscale() == scale
    assert ("logarithmic" in drawn.caption) == (scale == "symlog")


def test_a_figure_that_cannot_be_drawn_is_a_sentence_and_the_rest_is_there(browser, tmp_path):
    task, content = Poisson(), diagnosis(Poisson())
    good = spectrum(task, after=True)
    content = replace(content, pictures=Pictures((replace(good, before=good.before[:5]), good)))
    names = {path.name for path in write(task, content, tmp_path, "a spectrum without one of its bins")}
    assert "distribution-1.png" not in names
    assert {"distribution-2.png", "theta.png", "report.html"} <= names
    browser.open(tmp_path / "report.html")
    text = browser.run("return document.querySelector('#figure-distribution-1').textContent")
    assert text.startswith("The figure “distribution-1” could not be drawn: ValueError")
    assert browser.run("return document.images.length") == 2
    assert browser.complaints() == []


@pytest.mark.parametrize("verdict", [Verdict.NOTHING, Verdict.FAMILY], ids=lambda verdict: verdict.name.lower())
def test_every_verdict_has_a_page_also_where_there_is_nothing_to_show(browser, folder, tmp_path, verdict):
    task = Images()
    row = {"feature": "row", "low": -0.5, "high": 1.5, "kind": "deficit", "z": -9.0, "p_global": 0.0005}
    regions = [row, {**row, "feature": "column"}] if verdict == Verdict.FAMILY else []
    content = diagnosis(task, verdict, regions=regions, candidates=[], identifiability=[], notes=[])
    named = content.diagnosis.theta_after is not None
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)  # of other data, with other figures
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
