import numpy as np
import pytest
from measurements import applied, entry, measured

from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of, whitening
from avobench.tasks.carl import Carl


def test_a_covariance_is_whitened_in_as_many_directions_as_it_has():
    x, _rng = measured(Carl(), [0.5, -1.0], 4000, 1)
    cov = bins_of(x, x).covariance(x)
    w = whitening(cov)
    np.testing.assert_allclose(w.T @ cov @ w, np.eye(w.shape[1]), atol=1e-6)
    assert w.shape[1] == np.linalg.matrix_rank(cov, tol=1e-9)


@pytest.mark.parametrize(("name", "strength"), [("offset", 0.1), ("scale", 0.02), ("flat_background", 0.1)])
def test_the_noise_of_what_an_effect_changes_is_known(name, strength):
    """The squared difference of the means with and without it, beyond what more events would leave."""
    task, rng, n = Carl(), np.random.default_rng(0), 4000
    theta = np.tile([0.1, -0.5], (n, 1))
    x = task.simulate(theta, rng)
    target = target_of(x, bins_of(x, x), x)
    effect = entry(task, name, 4, x).adapted(x)
    steps, moved = [], []
    for _ in range(60):
        before = task.simulate(theta, rng)
        after = applied(effect, before, [strength], rng)
        steps.append(target.whiten(target.summary.mean(after)[0] - target.summary.mean(before)[0]))
        moved.append(target.moved(before, after).mean())
    assert np.var(steps, axis=0, ddof=1).mean() == pytest.approx(np.mean(moved), rel=0.15)
    apart = target.moved(task.simulate(theta, rng), task.simulate(theta, rng)).mean()
    assert apart == pytest.approx(2, rel=0.1)
