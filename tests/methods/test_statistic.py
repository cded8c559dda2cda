"""The learnt statistic against the score, which is known where an event's scale is the parameter."""

import numpy as np

from avobench.methods.statistic import Statistic

N = 20_000


def of_a_scale(seed):
    """Events x = exp(u / 2) e, whose mean says nothing of u: x (n, 1), u (n, 1)."""
    rng = np.random.default_rng(seed)
    u = rng.normal(0, 0.7, (N, 1))
    return (np.exp(u / 2) * rng.standard_normal((N, 1))).astype(np.float32), u


def efficiency(half, seed=1, u=0.0, step=0.2):
    """Information of the mean of a statistic about u, over Fisher's of an event, 1/2: at most 1 but for chance."""
    rng = np.random.default_rng(seed)
    low, high = (
        half((np.exp(at / 2) * rng.standard_normal((2 * N, 1))).astype(np.float32)) for at in (u - step, u + step)
    )
    return ((high.mean() - low.mean()) / (2 * step)) ** 2 / np.mean([low.var(), high.var()]) / 0.5


def test_it_finds_nearly_all_that_an_event_says_where_the_mean_says_nothing():
    x, u = of_a_scale(0)
    statistic = Statistic(1, 1, np.random.default_rng(0))
    before = efficiency(lambda x: statistic.of(x)[0])
    statistic.learn(x, u, 300)
    assert statistic.of(x)[0].shape == (N // 2, 1)
    for half in range(2):
        assert before < 0.8 < efficiency(lambda x, half=half: statistic.of(x)[half]) < 1.05


def test_each_half_is_told_by_what_was_learnt_on_the_other():
    x, u = of_a_scale(0)
    u[::2] = np.random.default_rng(2).permutation(u[::2])  # so nothing can be learnt on the first half
    statistic = Statistic(1, 1, np.random.default_rng(0))
    statistic.learn(x, u, 300)
    odd, even = (efficiency(lambda x, half=half: statistic.of(x)[half]) for half in range(2))
    assert odd < 0.3 < 0.8 < even
