"""The real data are those that were published, and what is said of them is kept until data or answer change."""

import importlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from avobench.bench.plugins import registry, user_files
from avobench.diagnosis.schema import Verdict
from avobench.effects.catalogue import families
from avobench.tasks.errors import StoreError, UsageError
from paper.studies import real as study

EXAMPLES = Path(__file__).parents[3] / study.EXAMPLES
RESULTS = Path(__file__).parents[3] / study.FOLDER
NAMES = sorted(study.expected(EXAMPLES))


def module(name):
    return importlib.import_module(user_files.module_name(EXAMPLES / f"{name}.py"))


@pytest.mark.parametrize(
    ("name", "events", "total"),
    [
        ("alpha_particles", 2608, 10_097),  # Rutherford and Geiger
        ("horse_kicks", 200, 122),  # Bortkiewicz
        ("dice", 26_306, 106_602),  # Pearson
        ("accidents", 647, 301),  # Greenwood and Yule
        ("families", 6115, 38_100),  # Geissler
    ],
)
def test_a_table_of_counts_has_the_published_totals(name, events, total):
    measured = module(name).measured
    assert (len(measured), measured.sum()) == (events, total)


def test_the_events_have_the_means_that_are_known_of_them():
    assert module("eruptions").measured.mean() == pytest.approx(3.488, abs=5e-4)
    nights = module("nights").measured
    assert nights.mean() == pytest.approx(3.461, abs=5e-4)
    assert [(nights == minutes).sum() for minutes in (2, 4)] == [23, 53]
    assert np.median(module("dimuons").measured) == pytest.approx(91.19, abs=1)  # the Z boson's mass
    energy, counts = np.histogram(module("gamma_line").measured, bins=np.arange(850, 885.1, 0.5))[::-1]
    assert energy[counts.argmax()] + 0.25 == pytest.approx(867.38, abs=0.5)
    assert module("earthquakes").measured.min() >= 0


@pytest.mark.parametrize("name", NAMES)
def test_every_example_has_its_source_and_licence_and_a_simulator_of_such_events(name):
    head = [line for line in (EXAMPLES / f"{name}.csv").read_text().splitlines() if line.startswith("#")]
    assert any(line.startswith("# Source: ") for line in head)
    assert any(line.startswith("# Licence: ") for line in head)
    task, measured = module(name).task, module(name).measured
    x = task.simulate(np.tile(task.prior.center, (2000, 1)), np.random.default_rng(0))[:, 0]
    assert x.dtype == measured.dtype
    assert x.min() <= np.median(measured) <= np.quantile(x, 0.99)
    assert registry.load("task", f"{EXAMPLES / name}.py:task").name == name.replace("_", "-")


def test_the_background_of_the_gamma_line_has_the_density_that_it_states():
    task, n = module("gamma_line").task, 200_000
    for slope in (-0.6, 0.0, 0.4):
        x = task.simulate(np.full((n, 1), slope), np.random.default_rng(1))[:, 0]
        x = 2 * (x - 849.98657) / (884.92439 - 849.98657) - 1
        assert x.mean() == pytest.approx(slope / 3, abs=5 / np.sqrt(3 * n))
        assert (x**2).mean() == pytest.approx(1 / 3, abs=5 * np.sqrt(4 / 45 / n))


def test_the_masses_of_two_muons_have_half_of_a_breit_wigner_within_its_width():
    example, n = module("dimuons"), 200_000
    x = example.task.simulate(np.full((n, 1), 91.0), np.random.default_rng(1))[:, 0]
    inside = 2 * np.arctan(1) / 2 / np.arctan(15 / (example.WIDTH / 2))  # of what lies 15 GeV on either side
    assert (np.abs(x - 91) < example.WIDTH / 2).mean() == pytest.approx(inside, abs=5 * 0.5 / np.sqrt(n) + 1e-3)
    assert x.min() > example.LOW
    assert x.max() < example.HIGH


def test_every_answer_is_one_that_an_installed_effect_could_give():
    names = {family.name for family in families().values()}
    for answer in study.expected(EXAMPLES).values():
        assert {*answer.answer, *answer.also} <= names
        assert not set(answer.answer) & set(answer.also)


@pytest.fixture
def horse_kicks(tmp_path):
    """A folder with the smallest example alone."""
    for suffix in ("py", "csv"):
        shutil.copy(EXAMPLES / f"horse_kicks.{suffix}", tmp_path)
    answers = json.loads((EXAMPLES / study.EXPECTED).read_text())
    (tmp_path / study.EXPECTED).write_text(json.dumps({"horse_kicks": answers["horse_kicks"]}))
    return tmp_path


def test_a_record_is_made_once_and_again_when_the_answer_changes(horse_kicks, tmp_path, monkeypatch):
    folder = tmp_path / "records"
    folder.mkdir()
    (record,) = study.real(folder, examples=horse_kicks)
    assert record["diagnosis"]["verdict"] == Verdict.NOTHING
    assert record["diagnosis"]["num_events"] == 200
    assert record["processor_seconds"] > 0
    assert study.read(folder) == [record]
    made = []
    monkeypatch.setattr(study, "said", lambda *a: made.append(a) or {})
    assert study.real(folder, examples=horse_kicks) == [record]
    assert not made
    answers = horse_kicks / study.EXPECTED
    answers.write_text(answers.read_text().replace('"why": "', '"why": "another reason: '))
    study.real(folder, examples=horse_kicks)
    assert len(made) == 1


def test_what_is_missing_or_damaged_is_told_in_one_line(horse_kicks, tmp_path):
    with pytest.raises(UsageError, match="clone of the repository"):
        study.real(tmp_path, examples=tmp_path / "nowhere")
    with pytest.raises(StoreError, match="study real"):
        study.read(tmp_path / "nowhere")
    (tmp_path / "a.json").write_text("{}")
    with pytest.raises(StoreError, match="delete it"):
        study.read(tmp_path)
    (horse_kicks / study.EXPECTED).write_text('{"horse_kicks": {"answer": 3}}')
    with pytest.raises(UsageError, match=r"expected\.json: horse_kicks"):
        study.expected(horse_kicks)


def test_the_committed_records_are_of_the_committed_data_and_answers():
    for seed, known in enumerate(study.read_all(RESULTS)):
        records = {record["name"]: record for record in known}
        assert sorted(records) == NAMES
        for name, answer in study.expected(EXAMPLES).items():
            identity = study.identity_of(name, answer, module(name).task, EXAMPLES, seed)
            assert {field: records[name][field] for field in identity} == identity
