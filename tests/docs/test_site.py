"""What the site adds to its pages, that no link is dead, and what a browser makes of the site if it has been built."""

import importlib.util
import re
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from markdown.extensions.toc import slugify
from mkdocs.exceptions import PluginError

ROOT = Path(__file__).parents[2]
SITE = ROOT / "site"
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.ipynb")])
built = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="`make docs` has not built the site")


@pytest.fixture(scope="module")
def hooks():
    spec = importlib.util.spec_from_file_location("hooks", ROOT / "docs" / "hooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def prose(page):
    """The text of a page without its fenced blocks and code."""
    return re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(), flags=re.M | re.S)


def anchors(page):
    return {slugify(title, "-") for title in re.findall(r"^#+ (.*)$", page.read_text().replace("`", ""), re.M)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_link_is_dead_where_the_repository_is_read(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if "://" not in target:
            name, _, anchor = target.partition("#")
            path = page.parent / name if name else page
            assert path.exists(), target
            assert not anchor or anchor in anchors(path), target


@pytest.mark.parametrize("task", ["carl", "poisson", "alignment"])
def test_the_page_of_effects_says_of_each_what_it_does_its_shapes_and_its_parameters(hooks, task):
    page = hooks.on_page_markdown((ROOT / "docs" / "effects.md").read_text())
    sections = dict(re.findall(r"^### (\w+)\n\n(.*?)(?=^##)", page + "\n## ", re.M | re.S))
    for name, family in hooks.families(task).items():
        assert name in sections
        own = hooks.described(family, task)
        assert own in page
        assert family[0].sentence in own
        shapes = {shape.shape: shape for effect in family for shape in effect.shapes()}.values()
        for shape in shapes:
            assert len(shapes) == 1 or not shape.shape or re.search(rf"^Shapes: .*\b{shape.shape}[,.]", own, re.M)
            for p in shape.parameters:  # with its own bounds, and so that its shape has them
                rows = re.findall(rf"^\| {p.name} \| (.*) to (.*) \| {p.unit} \| (.*) \|$", own, re.M)
                (where,) = [having for low, high, having in rows if (low, high) == (f"{p.low:.3g}", f"{p.high:.3g}")]
                assert where == "all" or shape.shape in where.split(", ")


def test_an_effect_on_features_without_negative_values_is_on_the_page_once(hooks):
    page = hooks.on_page_markdown((ROOT / "docs" / "effects.md").read_text())
    assert "decays-second-exponential.png" in page
    for name in ("resolution", "second_exponential", "radiative_tail"):
        assert page.count(f"\n### {name}\n") == 1


def test_formulas_become_mathml_in_the_line_and_by_themselves(hooks):
    inline = hooks.on_page_content('of <span class="arithmatex">\\(\\theta\\)</span> is')
    assert re.fullmatch(r'of <math [^>]*display="inline">.*<mi>&#x003B8;</mi>.*</math> is', inline)
    block = hooks.on_page_content('<div class="arithmatex">\\[\n\\frac{a}{b}\n\\]</div>')
    assert re.fullmatch(r'<math [^>]*display="block">.*<mfrac>.*</math>', block)


def test_a_page_that_would_fetch_something_from_a_network_ends_the_build_and_one_that_links_to_it_does_not(hooks):
    page = SimpleNamespace(file=SimpleNamespace(src_uri="page.md"))
    for tag in (
        '<script src="https://example.org/a.js"></script>',
        '<link rel="stylesheet" href="https://example.org/a.css">',
        '<img alt="" src=http://example.org/a.png>',
    ):
        with pytest.raises(PluginError, match=r"page\.md needs a network"):
            hooks.on_post_page(f"<html>{tag}</html>", page)
    html = '<a href="https://example.org">there</a><link rel="stylesheet" href="style.css"><img src="figure.png">'
    assert hooks.on_post_page(html, page) == html


def test_the_places_that_contributing_names_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    package = {path.name for path in (ROOT / "avobench").iterdir() if (path / "__init__.py").exists()}
    assert set(re.findall(r"^  (\w+)/ ", text, re.M)) == package
    named = re.findall(r"`((?:avobench|paper|shapes|docs|tests)/[\w/.-]*)`", text)
    assert len(named) > 5
    assert [path for path in named if not (ROOT / path).exists()] == []


@built
@pytest.mark.parametrize("width", [400, 1200])
def test_no_page_scrolls_sideways(browser, width):
    pages, too_wide = sorted(SITE.rglob("*.html")), []
    with browser.window(width):
        for page in pages:
            browser.open(page)
            end, window = browser.widest()
            too_wide += [(page.name, end)] if end > window else []
    assert len(pages) > 20
    assert too_wide == []


@built
def test_the_site_is_searched_from_a_folder_without_a_network(browser):
    browser.open(SITE / "index.html")
    browser.run("document.querySelector('input.md-search__input').focus()")
    browser.driver.switch_to.active_element.send_keys("dead_time")
    found, deadline = [], time.monotonic() + 30
    while not found and time.monotonic() < deadline:
        time.sleep(0.2)
        found = browser.run("return [...document.querySelectorAll('.md-search-result__link')].map(link => link.href)")
    assert any("effects.html" in link for link in found)
    assert all(link.startswith("file:") for link in found)
    assert not any("http" in line for line in browser.complaints())
