"""The study of outliers: what there is to find, and an interrupted study goes on."""

import numpy as np
import pytest

from paper.figures import contamination as report
from paper.studies import contamination as study


def test_the_minimiser_of_the_divergence_is_the_clean_theta_for_far_outliers_and_else_between():
    tasks = study.contaminated()
    assert abs(tasks["normal"].minimiser(np.array([0.0]), 0.05)[0]) < 1e-3
    assert 1e-3 < tasks["normal"].minimiser(np.array([1.5]), 0.2)[0] - 1.5 < 0.1
    weinberg, theta = tasks["weinberg"], np.array([44.0, 1.0])
    c = weinberg.task.identifiable(np.stack([theta, weinberg.minimiser(theta, 0.2)]))[:, 0]
    assert c[1] > c[0] + 0.1  # outliers at a large cosine raise the asymmetry


def test_means_move_by_the_outliers_and_only_what_is_lacking_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHODS", {"smm": ("smm", {})})
    monkeypatch.setattr(study, "SHARES", (0.0, 0.2))
    monkeypatch.setattr(study, "NUM_TARGETS", 1)
    path, started, one = tmp_path / study.FILE.name, [], study.one

    def interrupted(*arguments):
        started.append(arguments[2])
        if len(started) == 2:
            raise KeyboardInterrupt
        return one(*arguments)

    monkeypatch.setattr(study, "one", interrupted)

    def made():
        return study.made(path, tasks=("normal",), num_events=5000, budget=8000)

    with pytest.raises(KeyboardInterrupt):
        made()
    record = made()
    assert started == [0.0, 0.2, 0.2]
    assert study.read(tmp_path) == record
    clean, moved = record["runs"]
    assert abs(clean["estimate"][0] - clean["theta"][0]) < 5 * clean["error"][0]
    expected = 0.8 * moved["theta"][0] + 0.2 * 6
    assert abs(moved["estimate"][0] - min(expected, 2)) < 0.2  # the mean of all events, or the edge of the prior
    numbers = report.table([record])
    assert numbers["pull"][0] < 5 < numbers["pull"][1]
    report.drawn([record])
