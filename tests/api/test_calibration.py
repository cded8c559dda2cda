"""Calibration on a task of one's own: right errors pass, others are found, and an interrupted one goes on."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.api import calibration


class Normal:
    """Events around the parameter; it counts those that it makes, and fails at parameters above `least`."""

    def __init__(self, least=np.inf):
        self.used, self.least = 0, least

    def __getstate__(self):  # the calls that it counts are no part of what it is
        return {"used": 0, "least": self.least}

    def __call__(self, theta, rng):
        self.used += len(theta)
        if len(theta) == 97 and theta[0, 0] > self.least:  # where the observed events are made
            raise RuntimeError("too far")
        return rng.normal(theta[:, 0], 1)


HOW = {"events": 97, "budget": 600, "progress": False}


def normal(*least, high=2):
    return avobench.task(Normal(*least), prior={"mean": (-2, high)}, name="normal")


def test_the_errors_of_smm_hold_and_smaller_ones_do_not(tmp_path):
    found = avobench.calibrate(task := normal(), n=24, folder=tmp_path, **HOW)
    assert found.to_frame()["uniform"].iloc[0] > 1e-3
    assert 0.35 < found.to_frame()["in 68%"].iloc[0] < 0.9  # each has a probability of 4e-4
    assert len(found.plot().axes) == 2
    assert str(found).startswith("24 fits by smm")
    task.function.used = 0
    again = avobench.calibrate(task, n=25, folder=tmp_path, **HOW)
    assert task.function.used <= 700 + 100
    assert again.ranks[:24].equals(found.ranks)
    for fit in again.fits:  # a tenth of the error
        fit.quoted[1][:] /= 10
    assert again.to_frame()["in 68%"].iloc[0] < 0.4
    with pytest.raises(avobench.UsageError, match="other arguments"):
        avobench.calibrate(task, n=24, folder=tmp_path, seed=1, **HOW)


@pytest.mark.parametrize(
    "other",
    [
        lambda: avobench.task(lambda theta, rng: rng.normal(theta[:, 0], 50), prior={"mean": (-2, 2)}, name="normal"),
        lambda: normal(high=3),
    ],
)
def test_a_folder_is_of_one_simulator_and_one_prior(tmp_path, other):
    avobench.calibrate(normal(), n=1, folder=tmp_path, **HOW)
    with pytest.raises(avobench.UsageError, match="another task"):
        avobench.calibrate(other(), n=1, folder=tmp_path, **HOW)


def test_jobs_change_nothing_and_a_damaged_fit_is_made_again(tmp_path):
    one = avobench.calibrate(task := normal(), n=2, folder=tmp_path, **HOW)
    (tmp_path / "fit-1.json").write_text("{")
    assert avobench.calibrate(task, n=2, folder=tmp_path, jobs=2, **HOW).ranks.equals(one.ranks)


def test_a_fit_that_fails_is_counted_and_if_all_do_the_reason_is_raised():
    found = avobench.calibrate(normal(0.0), n=6, **HOW)
    assert 0 < len(found.failed) < 6
    assert len(found.fits) == len(found.truth) == 6 - len(found.failed)
    assert (found.truth["mean"] <= 0).all()
    shown = dataclasses.replace(found, failed=("RuntimeError: x < 0", *found.failed))._repr_html_()
    assert shown.startswith(f"<p>{str(found).partition(' by ')[0]} by smm, ")
    assert shown.count("<tr") == 2  # the names of the columns, and one parameter
    assert "x &lt; 0" in shown
    with pytest.raises(avobench.UsageError, match="too small"):
        avobench.calibrate("poisson", n=2, **{**HOW, "budget": 20})


def test_the_rank_of_a_posterior_is_that_of_its_points():
    sample = avobench.WeightedSample(np.array([[0.0], [1.0], [2.0]]), np.array([0.2, 0.3, 0.5]))
    (fit,) = avobench.calibrate(normal(), n=1, **HOW).fits
    object.__setattr__(fit.estimate, "sample", sample)
    ranks = calibration.Calibration((fit,), pd.DataFrame({"mean": [1.5]})).ranks
    assert ranks["mean"].tolist() == [0.5]
