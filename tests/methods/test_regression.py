"""Regression adjustment of ABC."""

import numpy as np
import pytest

from avobench.methods.regression import Evaluation, regressed
from avobench.tasks import Box


def test_parameters_linear_in_the_summary_are_moved_to_the_observed_one():
    rng = np.random.default_rng(0)
    box = Box((-1, -10), (1, 10))
    theta = box.sample(60, rng)
    mix = rng.normal(size=(2, 8))
    summaries = theta @ mix + rng.normal(scale=1e-3, size=(60, 8))
    truth = np.array([0.4, -3.0])
    tried = [Evaluation(one, summary, 0) for one, summary in zip(theta, summaries, strict=True)]
    kept = slice(0, 15)
    found = regressed(theta[kept], np.full(15, 1 / 15), tried, truth @ mix, box)
    assert found == pytest.approx(truth, abs=0.02)
    assert np.abs(theta[kept].mean(axis=0) - truth).max() > 0.2  # what it was without


def test_summaries_that_never_vary_are_left_out_and_the_answer_stays_in_the_box():
    box = Box((0,), (1,))
    theta = np.linspace(0, 1, 20)[:, None]
    tried = [Evaluation(one, np.array([one[0], 7.0]), 0) for one in theta]
    assert regressed(theta, np.full(20, 0.05), tried, np.array([3.0, 9.0]), box)[0] == 1
