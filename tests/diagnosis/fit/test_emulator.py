"""The learnt likelihood of bins: the probabilities are the simulator's, and a narrow peak is found wherever it is."""

import numpy as np
import pytest

import avobench
from avobench.diagnosis.fit.emulator import Blocks, Network, most_likely
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.model import Model

PRIOR = {"lifetime": (1, 4), "share": (0, 0.9), "place": (0, 15), "width": (0.02, 2)}


def peak_on_a_decay(theta, rng):
    lifetime, share, place, width = theta.T
    return np.where(rng.random(len(theta)) < share, rng.normal(place, width), rng.exponential(lifetime))


def test_it_learns_the_probabilities_of_bins_of_features_and_pairs():
    """Of two Gaussians with a correlation u, beside which a third feature is noise."""
    rng = np.random.default_rng(0)

    def simulate(u):
        x = rng.standard_normal((len(u), 3))
        x[:, 1] = u[:, 0] * x[:, 0] + np.sqrt(1 - u[:, 0] ** 2) * x[:, 1]
        return x

    seen, u = simulate(np.full((5000, 1), 0.5)), rng.uniform(-1, 1, (30_000, 1))
    blocks = Blocks.of(bins_of(seen, simulate(rng.uniform(-1, 1, (5000, 1)))))
    assert len(blocks.starts) > 3
    network = Network(u, blocks.bins(simulate(u)), blocks, rng)
    for at in (-0.6, 0.0, 0.6):
        learnt = np.exp(network(np.array([[at]])))[0]
        some = blocks.bins(simulate(np.full((200_000, 1), at)))
        exact = np.bincount(some.ravel(), minlength=blocks.size) / len(some)
        assert np.add.reduceat(learnt, blocks.starts) == pytest.approx(1, abs=1e-4)
        distances = np.add.reduceat(np.abs(learnt - exact), blocks.starts) / 2
        assert distances.max() < 0.06


def test_a_narrow_peak_of_unknown_place_is_found():
    """In four dimensions, of which it takes up a hundredth in one, and a tenth in two others."""
    task = avobench.task(peak_on_a_decay, prior=PRIOR, features=["t"])
    truth, model, near = np.array([2.2, 0.09, 5.05, 0.15]), Model(task), []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        x = task.simulate(np.tile(truth, (3300, 1)), rng)
        simulated = task.simulate(task.prior.sample(3300, rng), rng)
        summary = bins_of(x, simulated)
        target = target_of(x, summary, simulated)
        point, error = most_likely(
            lambda u, rng=rng: task.simulate(model.from_cube(u), rng), target, Blocks.of(summary), 4, rng, 14_400
        )
        assert (error < 0.2).all()
        near.append(np.abs(model.from_cube(point) - truth) < [0.5, 0.06, 0.3, 0.4])
    assert np.all(near, axis=1).sum() >= 2
