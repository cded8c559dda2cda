"""The study of doubts: sound fits and others, and an interrupted study goes on."""

from avobench.tasks.function import task
from paper.studies import agreement as study


def test_what_is_lacking_is_made_and_counted(tmp_path, monkeypatch):
    mean = task(lambda theta, rng: rng.normal(theta[:, 0], 1), prior={"mean": (-2, 2)}, name="mean")
    right = study.Case(mean, lambda n, rng: rng.normal(0.3, 1, (n, 1)), ((200, 600),), sound=True)
    wrong = study.Case(mean, lambda n, rng: rng.choice([-1.0, 1.0], (n, 1)), ((200, 600),))
    monkeypatch.setattr(study, "cases", lambda: {"right": right})
    first = study.made(tmp_path / study.FILE.name, num_seeds=2)["fits"]
    monkeypatch.setattr(study, "cases", lambda: {"right": right, "wrong": wrong})
    record = study.made(tmp_path / study.FILE.name, num_seeds=2)
    assert record["fits"][:2] == first
    assert study.read(tmp_path) == record
    assert study.table([record])["doubted"].tolist() == [0, 2]
