"""The code of the pages: it prints what stands below it, examples are quoted as they are, and shown commands work."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import exponnorm
from words import apart

from avobench.bench.plugins import registry
from paper.pages import executed

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLES = DOCS / "examples"
PAGES = [("add-a-method.md", "method", "nearest_summary.py"), ("add-a-task.md", "task", "decay_time.py")]
every_page = pytest.mark.parametrize(("page", "kind", "example"), PAGES)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of a user's own, with the examples in it."""
    for path in EXAMPLES.glob("*.py"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for path in EXAMPLES.glob("*.py"):
        sys.modules.pop(path.stem, None)


def blocks_of(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def blocks(page, language):
    return blocks_of((DOCS / page).read_text(), language)


def words_and_numbers(page):
    """Of the outputs on a page."""
    return apart("\n".join(blocks_of(page, "text")))


@pytest.mark.parametrize(
    "page", ["index.md", "tutorial.md", "features.md", "special-methods.md", "published-tables.md"]
)
def test_the_page_shows_what_its_code_prints_and_draws(page, tmp_path):
    """Numbers agree within a twentieth, as other processors round in another way."""
    (tmp_path / "figures").mkdir()
    shown = (DOCS / page).read_text()
    now = executed(shown, tmp_path)
    words, numbers = words_and_numbers(now)
    words_shown, numbers_shown = words_and_numbers(shown)
    assert words_shown == words
    assert numbers_shown == pytest.approx(numbers, rel=0.05)
    for picture in (tmp_path / "figures").iterdir():
        assert f"(figures/{picture.name})" in shown
        assert (DOCS / "figures" / picture.name).stat().st_size < 60_000


@every_page
def test_the_page_quotes_its_example_and_its_other_code_runs_after_it(page, kind, example):
    quoted, *others = blocks(page, "python")
    assert quoted == (EXAMPLES / example).read_text()
    names = {"__name__": "page"}
    for code in (quoted, *others):
        exec(code, names)
    assert len((EXAMPLES / example).read_text().splitlines()) <= 100


@every_page
def test_every_command_of_the_page_works_and_prints_what_is_shown(page, kind, example, folder, done):
    shown = [re.split(r"^\$ avobench (.*)\n", block, flags=re.MULTILINE)[1:] for block in blocks(page, "console")]
    assert [len(block) // 2 for block in shown] == [3, 1]
    for command, output in [pair for block in shown for pair in zip(block[::2], block[1::2], strict=True)]:
        told = done(*shlex.split(command))
        assert output in ("", told)
    assert list((folder / "results" / "local").iterdir())


@every_page
def test_an_entry_point_gives_the_example_its_name(page, kind, example, folder):
    (text,) = blocks(page, "toml")
    ((group, points),) = tomllib.loads(text)["project"]["entry-points"].items()
    ((name, value),) = points.items()
    assert group == registry.GROUPS[kind]
    assert registry.load(kind, value).name == name
    installed = folder / "example-1.0.dist-info"  # what installing a distribution leaves behind
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: example\nVersion: 1.0\n")
    (installed / "entry_points.txt").write_text(f"[{group}]\n{name} = {value}\n")
    command = [sys.executable, "-m", "avobench", "list", f"{kind}s"]  # this process has read the entry points already
    listed = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(folder)})
    assert f"  {name}: " in listed.stdout, listed.stderr


def test_decay_times_have_the_moments_and_the_distribution_of_their_density(folder):
    task = registry.build("task", "decay_time:DecayTime", {"resolution": 0.7})
    x = task.simulate(np.full((100_000, 1), 2.5), np.random.default_rng(0))[:, 0]
    assert x.mean() == pytest.approx(2.5, abs=5 * 2.6 / np.sqrt(len(x)))
    assert x.var() == pytest.approx(2.5**2 + 0.7**2, rel=0.05)
    for t in (0, 1, 5):
        expected = exponnorm.cdf(t, 2.5 / 0.7, scale=0.7)
        assert (x < t).mean() == pytest.approx(expected, abs=5 * np.sqrt(expected * (1 - expected) / len(x)))
