"""The study of outliers: what there is to find."""

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
    assert tasks["near"].minimiser(at := tasks["near"].task.targets()[0], 0.2) > at + 0.1  # no fit leaves them out
    hole = tasks["hole"]
    assert hole.density_of_outliers(hole.points).sum() * np.diff(hole.points)[0] == pytest.approx(1, abs=1e-3)
    assert abs(hole.outliers(20_000, np.random.default_rng(0)).mean() - at[0] + 0.0725) < 0.03
    assert tasks["tails"].minimiser(np.array([0.3, 0.2]), 1.0) == pytest.approx([0.4, 0.2997], abs=1e-3)


def test_means_move_by_the_outliers(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHODS", {"smm": ("smm", {})})
    monkeypatch.setattr(study, "NUM_TARGETS", 1)
    record = study.made(tmp_path / study.FILE.name, tasks=("normal",), num_events=5000, budget=8000)
    clean, moved = record["runs"][0], record["runs"][-1]
    assert abs(clean["estimate"][0] - clean["theta"][0]) < 5 * clean["error"][0]
    expected = 0.8 * moved["theta"][0] + 0.2 * 6
    assert abs(moved["estimate"][0] - min(expected, 2)) < 0.2  # the mean of all events, or the edge of the prior
    numbers = report.table([record])
    assert numbers["pull"][0] < 5 < numbers["pull"][3]
    report.drawn([record])
