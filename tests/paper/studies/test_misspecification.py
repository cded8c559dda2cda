"""The study of a wrong simulator: its proposal takes up what varies, and an interrupted study goes on."""

from dataclasses import replace

import pytest

from avobench.tasks.errors import StoreError
from paper.figures import misspecification as report
from paper.studies import misspecification as study


def test_the_proposal_widens_with_what_varies_and_only_what_is_lacking_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHOD", replace(study.METHOD, iterations=100))
    monkeypatch.setattr(study, "TASKS", ("poisson",))
    monkeypatch.setattr(study, "STRENGTHS", (0.0, 0.3))
    monkeypatch.setattr(study, "REPETITIONS", 1)
    path, started, one = tmp_path / study.FILE.name, [], study.one

    def interrupted(*arguments):
        started.append(arguments)
        if len(started) == 2:
            raise KeyboardInterrupt
        return one(*arguments, num_events=5_000, budget=8_000)

    monkeypatch.setattr(study, "one", interrupted)
    with pytest.raises(KeyboardInterrupt):
        study.made(path)
    record = study.made(path)
    assert [arguments[:2] for arguments in started] == [("poisson", 0.0), ("poisson", 0.3), ("poisson", 0.3)]
    calm, varied = record["runs"]
    assert calm["p_value"] > 1e-4 > varied["p_value"]
    assert varied["width"][0] > 2 * calm["width"][0]
    assert report.medians(record)["width"].tolist() == [calm["width"][0], varied["width"][0]]
    report.drawn([record])
    path.write_bytes(path.read_bytes().replace(b"width", b"widht"))
    with pytest.raises(StoreError, match="was changed after it was written"):
        study.read(tmp_path)
    with pytest.raises(StoreError, match="study misspecification"):
        study.read(tmp_path / "nowhere")
