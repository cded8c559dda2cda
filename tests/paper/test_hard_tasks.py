"""The floors of the hard tasks are those known in closed form, and the events have the densities behind them."""

import numpy as np
import pytest
from scipy.special import polygamma

from paper.hard_tasks import HARD, Bump, GAndK, Stable, StudentTails
from paper.sbibm_tasks import SBIBM


def test_the_information_is_what_is_known_in_closed_form():
    nu = 3.0
    trigamma = polygamma(1, nu / 2) - polygamma(1, (nu + 1) / 2)
    of_student = (trigamma / 2 - (nu + 5) / (nu * (nu + 1) * (nu + 3))) / 2  # Lange, Little, Taylor 1989
    assert StudentTails().information(np.array([nu]))[0, 0] == pytest.approx(of_student, rel=1e-4)
    gaussian = GAndK().information(np.array([3.0, 2.0, 0.0, 0.0]))
    assert gaussian[:2, :2] == pytest.approx(np.diag([1, 2]) / 2**2, abs=1e-4)
    cauchy = Stable().information(np.array([1.0, 0.7]))
    assert cauchy[1, 1] == pytest.approx(1 / 2, rel=1e-3)
    assert Bump().information(np.array([0.3])) == pytest.approx(Bump().information(np.array([0.7])), rel=1e-6)


def test_the_information_of_the_bump_is_the_mean_square_of_the_score_of_its_events():
    task, theta = Bump(), np.array([0.4])
    x = task.simulate(np.tile(theta, (400_000, 1)), np.random.default_rng(0))[:, 0]
    z = (x - theta[0]) / task.width
    peak = task.share * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) / task.width
    score = z / task.width * peak / (peak + 1 - task.share)
    assert task.information(theta)[0, 0] == pytest.approx((score**2).mean(), rel=0.03)


def test_stable_events_have_their_characteristic_function():
    theta = np.array([1.4, 0.5])
    x = Stable().simulate(np.tile(theta, (200_000, 1)), np.random.default_rng(0))
    for t in (0.2, 0.6, 1.5):
        assert np.cos(t * x).mean() == pytest.approx(np.exp(-((t * np.exp(theta[1])) ** theta[0])), abs=0.007)


@pytest.mark.parametrize("task", [task() for task in (*HARD, *SBIBM) if task is not Stable], ids=lambda task: task.name)
def test_a_task_has_finite_events_of_its_kind_and_floors_that_add_up(task):
    theta = task.targets()
    x = task.simulate(theta, np.random.default_rng(0))
    assert (x.shape, x.dtype) == ((len(theta), task.num_features), task.dtype)
    assert np.isfinite(x).all()
    assert np.isfinite(task.summary(x)).all()
    floors = task.floors(theta[0], 1000, 4000)
    assert (floors > 0).all()
    assert floors.shape == task.identifiable(theta[:1])[0].shape
    assert task.floor(theta[0], 800, None) == pytest.approx(floors.sum())
    with pytest.raises(ValueError, match="outside the support"):
        task.simulate(np.array([task.support.high]) + 1, np.random.default_rng(0))
