"""The study of a wrong simulator: its proposal takes up what varies, and an interrupted study goes on."""

import pytest

from avobench.tasks.errors import StoreError
from paper.figures import misspecification as report
from paper.studies import misspecification as study


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(study, "TASKS", ("poisson",))
    monkeypatch.setattr(study, "STRENGTHS", (0.0, 0.3))
    monkeypatch.setattr(study, "REPETITIONS", 1)
    one = study.one
    monkeypatch.setattr(study, "one", lambda *a: one(*a, num_events=20_000, budget=20_000))


def test_the_proposal_widens_with_what_varies_and_the_diagnosis_sees_it(small, tmp_path):
    record = study.made(tmp_path / study.FILE)
    calm, varied = record["runs"]
    assert calm["p_value"] > 1e-4 > varied["p_value"]
    assert varied["width"][0] > 2 * calm["width"][0]
    rows = report.medians(record)
    assert rows["width"].tolist() == [calm["width"][0], varied["width"][0]]
    assert len(report.draw([record], tmp_path)) == 3


def test_an_interrupted_study_makes_only_what_is_lacking_and_a_damaged_file_is_named(small, tmp_path, monkeypatch):
    path, made, one = tmp_path / study.FILE, [], study.one

    def interrupted(*arguments):
        if made:
            raise KeyboardInterrupt
        made.append(arguments)
        return one(*arguments)

    monkeypatch.setattr(study, "one", interrupted)
    with pytest.raises(KeyboardInterrupt):
        study.made(path)
    monkeypatch.setattr(study, "one", lambda *a: made.append(a) or one(*a))
    assert len(study.made(path)["runs"]) == len(made) == 2
    path.write_bytes(path.read_bytes().replace(b"width", b"widht"))
    with pytest.raises(StoreError, match="was changed after it was written"):
        study.read(tmp_path)
    with pytest.raises(StoreError, match="study misspecification"):
        study.read(tmp_path / "nowhere")
