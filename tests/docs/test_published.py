"""Every published number is one that a command prints from the committed records."""

import re
from pathlib import Path

import pandas as pd
import pytest
from matplotlib.figure import Figure

from avobench.bench import cli
from avobench.bench.cost import format_cost
from avobench.bench.plan import plan
from avobench.bench.store import Store
from avobench.reports.cli import FIGURES, STUDY_FIGURES, draw, records_for
from avobench.reports.reproduction import gather, page

ROOT = Path(__file__).parents[2]
REFERENCE = Store(ROOT / "results" / "reference")
STUDIES = Store(ROOT / "results" / "studies")


def blocks(page):
    """The fenced blocks of a page, without the white space at line ends."""
    return [strip(block) for block in re.findall(r"^```\n(.*?)^```$", (ROOT / page).read_text(), re.M | re.S)]


def strip(text):
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines())


@pytest.mark.parametrize(
    ("page", "results"), [("README.md", "results/reference"), ("docs/performance.md", "results/bolfi-gpy")]
)
def test_a_page_shows_what_status_prints(page, results, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("sys.argv", ["avobench", "status", "--results", results])
    with pytest.raises(SystemExit):
        cli.main()
    assert strip(capsys.readouterr().out) in blocks(page)


def test_the_page_on_cost_shows_what_the_records_say():
    assert strip(format_cost(REFERENCE)) in blocks("docs/performance.md")


@pytest.mark.parametrize("name", FIGURES)
def test_the_committed_figures_are_of_the_committed_records(name, monkeypatch, tmp_path):
    monkeypatch.setattr(Figure, "savefig", lambda self, file, **_: file.write(b"figure"))  # the numbers are enough
    draw(name, records_for(name, STUDIES if name in STUDY_FIGURES else REFERENCE), tmp_path)
    drawn, committed = tmp_path / f"{name}.csv", ROOT / "docs" / "figures" / f"{name}.csv"
    pd.testing.assert_frame_equal(pd.read_csv(drawn), pd.read_csv(committed))
    assert all((ROOT / "docs" / "figures" / f"{name}.{suffix}").exists() for suffix in ("pdf", "png"))


def test_the_page_on_the_papers_claims_is_what_its_command_prints():
    assert page(gather(REFERENCE.path, STUDIES.path)) == (ROOT / "docs" / "reproduction.md").read_text()


def test_the_reference_records_are_the_cells_of_todays_defaults():
    """A changed default or version would leave the published records behind: they would have to be made again."""
    records = REFERENCE.read_all()
    cells = plan(
        tasks=["poisson", "carl", "weinberg", "alignment"],
        methods=["avo-paper", "abc-smc", "bolfi"],
        targets="0-2",
        repetitions=1,
        budget=160_000,
        num_observations=100_000,
        seed=0,
        settings=[],
    )
    assert {cell.id for cell in cells} <= {record["id"] for record in records}
    assert all(record["simulations_used"] <= 160_000 for record in records)
    assert {record["status"] for record in records} == {"ok"}
