"""The page as a reader sees it, in a real browser without network."""

import base64
import io

import pandas as pd
import pytest

from avobench.bench.store import Store
from avobench.reports.page import provenance, render

HOSTILE = "<script>document.title = 'taken'</script> & \"quoted\" <b>bold</b>"
CELLS = "#cells + p + .scroll table"


@pytest.fixture(scope="module")
def store(benchmark, make_record, tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("page") / "results", create=True)
    failed = {**make_record("poisson", "avo", 9, None), "message": HOSTILE}
    shown = [record for record in benchmark if record["task"] in ("poisson", "weinberg")]
    for record in [*shown, failed]:
        store.write(record)
    store.log_sweep({"command": f"avobench run --set x={HOSTILE}", "versions": {}})
    return store


@pytest.fixture(scope="module")
def page(store):
    return render(store.path, None)


@pytest.fixture
def opened(page, browser, tmp_path):
    (tmp_path / "index.html").write_text(page)
    browser.open(tmp_path / "index.html")
    return browser


def test_it_opens_without_network_or_complaint_and_shows_its_figures(opened):
    assert opened.complaints() == []
    sizes = opened.run("return [...document.images].map(image => [image.complete, image.naturalWidth, image.alt])")
    assert len(sizes) == 4
    assert all(complete and width > 500 and alt for complete, width, alt in sizes)
    links = opened.run(
        "return [...document.querySelectorAll('nav a')].map(a => document.querySelector(a.hash) !== null)"
    )
    assert len(links) >= 5
    assert all(links)


def test_a_phone_scrolls_wide_tables_and_figures_not_the_page(opened):
    size = {"width": 390, "height": 800, "deviceScaleFactor": 2, "mobile": True}
    opened.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        assert opened.run("return document.documentElement.scrollWidth") <= 390
        assert opened.run("return Math.min(...[...document.images].map(image => image.clientWidth))") > 390
    finally:
        opened.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_tables_sort_by_number_or_text_with_what_is_missing_last(opened):
    def values(column):
        rows = f"[...document.querySelector('{CELLS}').tBodies[0].rows]"
        return opened.run(f"return {rows}.map(row => row.cells[arguments[0]].dataset.value)", column)

    names = opened.run(f"return [...document.querySelectorAll('{CELLS} th')].map(th => th.textContent)")
    for name, kind in (("squared_error", float), ("task", str)):
        column = names.index(name)
        click = f"document.querySelectorAll('{CELLS} th button')[arguments[0]].click()"
        for descending in (False, True):
            opened.run(click, column)
            found = values(column)
            known = [kind(value) for value in found if value != ""]
            assert known == sorted(known, reverse=descending)
            assert all(value == "" for value in found[len(known) :])
        header = f"return document.querySelectorAll('{CELLS} th')[arguments[0]].getAttribute('aria-sort')"
        assert opened.run(header, column) == "descending"
    assert opened.complaints() == []


def test_what_users_wrote_is_shown_not_run(opened):
    assert opened.driver.title.startswith("avobench: records in")
    text = opened.run("return document.body.innerText")
    assert text.count(HOSTILE) == 2
    assert opened.run("return document.querySelectorAll('td b').length") == 0


def test_the_downloads_hold_every_cell(opened, store):
    link = opened.run("return document.querySelector('a[download=\"cells.csv\"]').href")
    table = pd.read_csv(io.BytesIO(base64.b64decode(link.partition("base64,")[2])))
    assert sorted(table["id"]) == sorted(record["id"] for record in store.read_all())
    downloads = opened.run("return [...document.querySelectorAll('a[download]')].map(a => a.download)")
    assert {"benchmark.csv", "weinberg.csv", "efficiency.csv", "cost.csv", "targets.csv", "settings.csv"} <= set(
        downloads
    )


def test_each_number_has_its_settings_versions_and_commit(benchmark):
    other = {**benchmark[0], "versions": {**benchmark[0]["versions"], "commit": "0123456789ab"}}
    table = provenance([*benchmark, other])
    assert table["cells"].sum() == len(benchmark) + 1
    assert set(table["commit"]) == {"0123456789ab", benchmark[0]["versions"]["commit"]}
    own = table[(table["task"] == "poisson") & (table["method"] == "avo")]
    assert sorted(own["cells"]) == [1, 4]
    assert "numpy" in own["versions"].iloc[0]


def test_the_command_writes_one_file(avobench, make_record, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where there is no results/studies
    store = Store(tmp_path / "results", create=True)
    store.write(make_record("poisson", "bolfi", 0, 0.1))
    code, out, err = avobench("report", "--results", store.path, "--out", tmp_path / "page")
    assert code == 0, err
    assert [path.name for path in (tmp_path / "page").iterdir()] == ["index.html"]
    assert out.strip().endswith("index.html")
    code, _, err = avobench("report", "--results", tmp_path / "none", "--out", tmp_path / "other")
    assert (code, "there is no results folder" in err) == (2, True)
