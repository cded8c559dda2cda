"""The study of a wrong simulator: its proposal takes up what varies."""

from dataclasses import replace
from functools import partial

from paper.figures import misspecification as report
from paper.studies import misspecification as study


def test_the_proposal_widens_with_what_varies(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHOD", replace(study.METHOD, iterations=100))
    monkeypatch.setattr(study, "TASKS", ("poisson",))
    monkeypatch.setattr(study, "STRENGTHS", (0.0, 0.3))
    monkeypatch.setattr(study, "REPETITIONS", 1)
    monkeypatch.setattr(study, "one", partial(study.one, num_events=5_000, budget=8_000))
    record = study.made(tmp_path / study.FILE.name)
    calm, varied = record["runs"]
    assert calm["p_value"] > 1e-4 > varied["p_value"]
    assert varied["width"][0] > 2 * calm["width"][0]
    assert report.medians(record)["width"].tolist() == [calm["width"][0], varied["width"][0]]
    report.drawn([record])
