"""The page as a reader sees it, in a real browser without network."""

import base64
import io

import numpy as np
import pandas as pd
import pytest
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.support.ui import Select

from avobench.bench.store.store import Store
from avobench.reports.page import provenance, render

HOSTILE = "<script>document.title = 'taken'</script> & \"quoted\" <b>bold</b>"
CELLS = "#cells table"


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
    return render(store.path)


@pytest.fixture
def opened(page, browser, tmp_path):
    (tmp_path / "index.html").write_text(page)
    browser.open(tmp_path / "index.html")
    return browser


def test_it_opens_without_network_or_complaint_and_shows_its_figures(opened):
    assert opened.complaints() == []
    sizes = opened.run("return [...document.images].map(image => [image.complete, image.naturalWidth, image.alt])")
    assert len(sizes) == 3
    assert all(complete and width > 500 and alt for complete, width, alt in sizes)
    assert opened.run("return document.querySelectorAll('.missing').length") == 0
    links = "[...document.querySelectorAll('nav a')]"
    assert opened.run(f"return {links}.length") >= 5
    assert opened.run(f"return {links}.every(a => document.querySelector(a.hash))")


@pytest.mark.parametrize("width", [1300, 800, 390])
def test_no_window_needs_a_horizontal_scrollbar(opened, width):
    opened.require_fit(width)


def test_light_and_dark_show_the_same_legibly(opened):
    light, dark = opened.in_both_schemes()
    assert np.median(light) > 240
    assert np.median(dark[:200]) < 40
    with opened.scheme("dark"):  # figures are drawn on white, and stay so
        opened.run("document.querySelector('figure').scrollIntoView()")
        assert (opened.screenshot() == 255).all(axis=2).mean() > 0.2


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


def shown_cells(opened):
    """The texts of the rows of cells that are not filtered out."""
    rows = f"[...document.querySelector('{CELLS}').tBodies[0].rows].filter(row => row.checkVisibility())"
    return opened.run(f"return {rows}.map(row => [...row.cells].map(cell => cell.textContent))")


def test_cells_are_filtered_by_words_and_by_choices(opened, store):
    cells = opened.driver.find_element("id", "cells")
    words = cells.find_element("css selector", "input[type=search]")
    choices = {label.text.split()[0]: label for label in cells.find_elements("css selector", "label:has(select)")}
    assert set(choices) == {"task", "method", "status"}
    everything = shown_cells(opened)
    assert len(everything) == len(store.read_all())

    choose = {name: Select(label.find_element("tag name", "select")) for name, label in choices.items()}
    choose["method"].select_by_visible_text("avo")
    assert shown_cells(opened) == [row for row in everything if row[1] == "avo"]
    choose["task"].select_by_visible_text("weinberg")
    chosen = [row for row in everything if row[:2] == ["weinberg", "avo"]]
    assert shown_cells(opened) == chosen
    assert cells.find_element("tag name", "output").text == f"{len(chosen)} of {len(everything)} rows"
    choose["status"].select_by_visible_text("method_error")
    assert shown_cells(opened) == []
    for select in choose.values():
        select.select_by_visible_text("all")
    assert shown_cells(opened) == everything

    words.send_keys("POISSON title")  # in any order and case, in any column: the message of the cell that failed
    assert [row[4] for row in shown_cells(opened)] == ["method_error"]
    words.clear()
    words.send_keys("poissonavo")  # words do not reach from one cell into the next
    assert shown_cells(opened) == []
    assert opened.complaints() == []


def test_columns_are_sorted_from_the_keyboard(opened):
    header = f"document.querySelector('{CELLS} th:nth-child(3)')"
    opened.run(f"{header}.querySelector('button').focus()")
    for key, order in ((Keys.ENTER, "ascending"), (Keys.SPACE, "descending")):
        ActionChains(opened.driver).send_keys(key).perform()
        assert opened.run(f"return {header}.getAttribute('aria-sort')") == order
    assert opened.run(f"return document.querySelectorAll('{CELLS} th[aria-sort]').length") == 1


def test_without_scripts_everything_is_there_and_nothing_that_does_not_work(opened, store):
    with opened.without_scripts():
        opened.driver.refresh()
        assert len(opened.driver.find_elements("css selector", f"{CELLS} tbody tr")) == len(store.read_all())
        assert opened.driver.find_elements("css selector", "button, input, select") == []


def test_only_the_script_of_the_page_itself_may_run(browser, page, tmp_path):
    taken = "<script>document.title = 'taken'</script>"
    (tmp_path / "index.html").write_text(page.replace("</main>", f"{taken}</main>"))
    browser.open(tmp_path / "index.html")
    assert browser.driver.title != "taken"
    assert any("Content Security Policy" in line for line in browser.complaints())


def test_what_users_wrote_is_shown_not_run(opened):
    assert opened.driver.title.startswith("avobench: records in")
    text = opened.run("return document.body.innerText")
    assert text.count(HOSTILE) == 2
    assert opened.run("return document.querySelectorAll('td b').length") == 0


def downloaded(browser):
    """The table of cells that the page has to download."""
    link = browser.run("return document.querySelector('a[download=\"cells.csv\"]').href")
    return pd.read_csv(io.BytesIO(base64.b64decode(link.partition("base64,")[2])))


def test_the_downloads_hold_every_cell(opened, store):
    assert sorted(downloaded(opened)["id"]) == sorted(record["id"] for record in store.read_all())
    downloads = opened.run("return [...document.querySelectorAll('a[download]')].map(a => a.download)")
    assert {"benchmark.csv", "efficiency.csv", "settings.csv"} <= set(downloads)


def test_each_number_has_its_settings_versions_and_commit(benchmark):
    other = {**benchmark[0], "versions": {**benchmark[0]["versions"], "commit": "0123456789ab"}}
    table = provenance([*benchmark, other])
    assert table["cells"].sum() == len(benchmark) + 1
    assert set(table["commit"]) == {"0123456789ab", benchmark[0]["versions"]["commit"]}
    own = table[(table["task"] == "poisson") & (table["method"] == "avo")]
    assert sorted(own["cells"]) == [1, 6]
    assert "numpy" in own["versions"].iloc[0]


def test_of_many_cells_the_page_shows_those_to_look_at_and_says_so(make_record, monkeypatch, browser, tmp_path):
    monkeypatch.setattr("avobench.reports.page.MOST_CELLS", 5)
    store = Store(tmp_path / "results", create=True)
    for target, error in enumerate((0.1, 400, 2, 30, None, 0.0005)):
        store.write(make_record("poisson", "avo", target, error))
    (tmp_path / "index.html").write_text(render(store.path))
    browser.open(tmp_path / "index.html")
    assert "5 of 6, first those that failed" in browser.run("return document.querySelector('#cells p').textContent")
    rows = shown_cells(browser)
    assert [row[2] for row in rows] == ["4", "1", "3", "2", "0"]  # the failed one, then from the worst on
    assert len(downloaded(browser)) == 5
    summary = browser.run("return document.querySelector('#summary tbody').innerText")
    assert "6" in summary.split()  # all cells count
    assert browser.complaints() == []


def test_where_no_cell_has_an_estimate_a_sentence_says_so(avobench, make_record, tmp_path):
    store = Store(tmp_path / "results", create=True)
    for target in range(2):
        store.write(make_record("weinberg", "avo", target, None))
    code, _, err = avobench("figure", "efficiency", "--results", store.path, "--out", tmp_path)
    assert (code, "no cell has an estimate" in err, len(err.splitlines())) == (1, True, 1)
    assert "The figure “efficiency” could not be drawn: " in render(store.path)


def test_a_figure_or_table_that_fails_leaves_the_rest(monkeypatch, store):
    def fails(*_):
        raise ZeroDivisionError("a user's <b>floor</b>")

    monkeypatch.setattr("avobench.reports.efficiency.numbers", fails)
    monkeypatch.setattr("avobench.reports.page.provenance", fails)
    page = render(store.path)
    told = "ZeroDivisionError: a user&#39;s &lt;b&gt;floor&lt;/b&gt;"
    assert f"The figure “efficiency” could not be drawn: {told}" in page
    assert f"The table “settings” could not be made: {told}" in page
    assert page.count("<figure ") == 2
    assert 'id="cells-title"' in page


def test_the_command_writes_one_file(done, make_record, tmp_path):
    store = Store(tmp_path / "results", create=True)
    store.write(make_record("poisson", "bolfi", 0, 0.1))
    assert done("report", "--results", store.path, "--out", tmp_path / "page").strip().endswith("index.html")
    assert [path.name for path in (tmp_path / "page").iterdir()] == ["index.html"]
