"""Every published number is one that a command prints from the committed records."""

import contextlib
import io
import re
import runpy
import shlex
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from scipy.optimize import minimize
from scipy.stats import norm
from words import apart

from avobench.bench.store.status import Status
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.reports.figures import FIGURES, draw
from paper import gallery
from paper.claims.reproduction import gather
from paper.claims.reproduction import pages as claims
from paper.figures.__main__ import FOLDERS
from paper.figures.__main__ import draw as draw_of_the_paper
from paper.printed import BLOCK, STEADY, filled, output
from paper.studies import real
from paper.tables.real import page as real_page
from paper.tables.records import fields_table

ROOT = Path(__file__).parents[2]
REFERENCE = Store(ROOT / "results" / "reference")
SHOWN = re.compile(r"<!-- (printed by|text of|code of): ")
PAGES = [page.relative_to(ROOT).as_posix() for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))]


@pytest.fixture
def printed_here(done, monkeypatch):
    """What `paper.printed.printed` gives, without a process for each command."""

    def printed(command):
        program, *arguments = shlex.split(command)
        if program == "avobench":
            told = done(*arguments)
        else:
            module = arguments[0] == "-m"
            monkeypatch.setattr(sys, "argv", arguments[module:])
            with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.suppress(SystemExit):
                if module:
                    runpy.run_module(arguments[1], run_name="__main__", alter_sys=True)
                else:
                    monkeypatch.syspath_prepend(str(Path(arguments[0]).parent))
                    runpy.run_path(arguments[0], run_name="__main__")
            told = out.getvalue()
        return "\n".join(line.rstrip() for line in told.strip("\n").splitlines()) + "\n"

    return printed


@pytest.mark.parametrize("page", [page for page in PAGES if SHOWN.search((ROOT / page).read_text())])
def test_a_page_shows_what_its_commands_print_and_its_files_hold(page, printed_here, monkeypatch):
    monkeypatch.chdir(ROOT)
    text = (ROOT / page).read_text()
    assert filled(text, STEADY | {"printed": printed_here}) == text


def test_what_the_page_on_cost_quotes_stands_among_the_timings():
    """They depend on the machine, so they are kept as printed once: on one page all, on the other the main lines."""
    timings = (ROOT / "docs" / "tables" / "performance.md").read_text().splitlines()
    page = (ROOT / "docs" / "performance.md").read_text()
    unmarked = re.sub(r"<!-- printed by: .*?^```$.*?^```$", "", page, flags=re.M | re.S)
    quoted = [line for block in re.findall(r"^```\n(.*?)^```$", unmarked, re.M | re.S) for line in block.splitlines()]
    assert len(quoted) > 10
    assert set(quoted) <= set(timings)


def test_the_readme_shows_what_its_example_prints(tmp_path):
    """Word by word; numbers within a hundredth of them, as another processor rounds, but for how long it took."""
    text = (ROOT / "README.md").read_text()
    (shown,) = [block[4] for block in BLOCK.finditer(text) if block[2] == "output"]
    words, numbers = apart(shown)
    words_now, numbers_now = apart(output(ROOT / "examples" / "gamma_line.py", tmp_path))
    assert words_now == words
    assert numbers_now == pytest.approx(numbers, rel=0.01)


def test_the_readme_is_read_in_one_go():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 100


@pytest.mark.parametrize("name", [*FIGURES, *FOLDERS])
def test_the_committed_figures_are_of_the_committed_records(name, monkeypatch, tmp_path):
    monkeypatch.setattr(Figure, "savefig", lambda self, file, **_: file.write(b"figure"))  # the numbers are enough
    if name in FOLDERS:
        draw_of_the_paper(name, ROOT / FOLDERS[name], tmp_path)
    else:
        draw(name, REFERENCE.read_all(), tmp_path)
    drawn, committed = tmp_path / f"{name}.csv", ROOT / "docs" / "figures" / f"{name}.csv"
    pd.testing.assert_frame_equal(pd.read_csv(drawn), pd.read_csv(committed))
    assert all((ROOT / "docs" / "figures" / f"{name}.{suffix}").exists() for suffix in ("pdf", "png"))


PAGES_OF_RECORDS = {
    "claims": lambda: claims(gather(*(ROOT / "results" / name for name in ("reference", "studies", "ablation")))),
    "real data": lambda: {"real-data.md": real_page(real.read_all(ROOT / "results" / "real"))},
    "gallery": lambda: {gallery.PAGE.name: gallery.page(real.read(ROOT / "results" / "real"))},
}


@pytest.mark.parametrize("kind", PAGES_OF_RECORDS)
def test_a_page_that_a_command_writes_is_of_the_committed_records(kind):
    pages = PAGES_OF_RECORDS[kind]()
    assert pages == {path: (ROOT / "docs" / path).read_text() for path in pages}


def test_the_gallery_has_a_small_picture_of_each_example():
    shown = re.findall(r"\]\((figures/.*?)\)", (ROOT / gallery.PAGE).read_text())
    assert [Path(path).stem for path in shown] == sorted(path.stem for path in (ROOT / gallery.EXAMPLES).glob("*.py"))
    assert all((ROOT / "docs" / path).stat().st_size < 60_000 for path in shown)


def test_the_reference_records_are_the_cells_of_todays_defaults():
    """A changed default or version would leave the published records behind: they would have to be made again."""
    records = REFERENCE.read_all()
    tasks = ["poisson", "carl", "weinberg", "alignment"]
    swept = [(["avo"], 3), (["avo-paper", "abc-smc", "bolfi"], 1)]
    cells = [cell for methods, n in swept for cell in plan(tasks, methods, "0-14", n, 160_000, 100_000, 0, [])]
    assert {cell.id for cell in cells} <= {record["id"] for record in records}
    assert all(record["simulations_used"] <= 160_000 for record in records)
    assert {record["status"] for record in records} == {"ok"}


def test_what_the_readme_says_of_the_line_s_centre_is_what_a_direct_fit_gives():
    """The likelihood of the counts in each channel, with a Gaussian line on a straight background."""
    energy, counts = np.loadtxt(ROOT / "examples" / "real" / "gamma_line.csv", delimiter=",", unpack=True)
    half = (energy[1] - energy[0]) / 2

    def deviance(p):
        line = p[0] * (norm.cdf(energy + half, p[3], p[4]) - norm.cdf(energy - half, p[3], p[4]))
        mean = np.maximum(line + p[1] * (1 + p[2] * (energy - energy.mean())), 1e-9)
        return 2 * (mean - counts * np.log(mean)).sum()

    def best(centre):
        free = lambda p: deviance([*p[:3], centre, p[3]])  # noqa: E731
        options = {"maxiter": 4000, "maxfev": 4000, "fatol": 1e-6}
        return minimize(free, [13_000, 160, 0, 0.76], method="Nelder-Mead", options=options).fun

    centres = np.array([867.417, 867.437, 867.457])
    curve = np.polyfit(centres - 867.437, [best(centre) for centre in centres], 2)
    centre, error = 867.437 - curve[1] / (2 * curve[0]), curve[0] ** -0.5
    text = (ROOT / "README.md").read_text()
    direct, its_error = map(float, re.search(r"([\d.]+) ± ([\d.]+) keV\. The line", text).groups())
    found, found_error = map(float, re.search(r"centre = ([\d.]+) ± ([\d.]+) keV", text).groups())
    assert direct == pytest.approx(centre, abs=0.001)
    assert its_error == pytest.approx(error, abs=0.001)
    assert abs(found - direct) < 2 * found_error
    assert direct - 867.380 > 5 * its_error  # so the difference from the line's energy is the file's


def test_the_docs_have_the_fields_and_every_status():
    text = (ROOT / "docs" / "records.md").read_text()
    assert fields_table() in text
    assert all(f"| `{status}` |" in text or f"`{status}` exactly when" in text for status in Status)
