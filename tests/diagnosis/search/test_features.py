from types import SimpleNamespace

import numpy as np

from avobench.diagnosis.search.features import clears_feature, excess_by_feature, open_features
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.tasks.carl import Carl


def test_an_effect_on_one_feature_clears_that_feature_whatever_is_wrong_with_another():
    task, rng = Carl(), np.random.default_rng(0)
    theta = np.tile(task.prior.sample(1, rng), (4000, 1))
    x, simulated = task.simulate(theta, rng), task.simulate(theta, rng)
    x[:, 3] += 0.3 * x[:, 3].std()
    x[:, 0] *= 2
    target = target_of(x, bins_of(x, simulated), x)

    def fit(events, *features):
        effects = tuple(SimpleNamespace(feature=feature) for feature in features)
        return SimpleNamespace(
            predicted=target.summary.mean(events)[0], noise=1.0, model=SimpleNamespace(effects=effects)
        )

    mended = simulated.copy()
    mended[:, 3] += 0.3 * x[:, 3].std()
    before, found = fit(simulated), excess_by_feature(fit(simulated), target)
    assert sorted(found, key=found.get)[-2:] == [3, 0]
    assert clears_feature(fit(mended, 3), before, target)
    assert not clears_feature(fit(mended, 0), before, target)
    assert not clears_feature(fit(mended, 1), before, target)  # shows nothing that could be cleared
    assert not clears_feature(fit(mended, "all"), before, target)
    assert not clears_feature(fit(mended, "all", 3), fit(simulated, "all"), target)  # may be left by the effect on all
    assert clears_feature(fit(mended, 0, 3), fit(simulated, 0), target)
    assert list(open_features(before, target)) == [0, 3]
    assert list(open_features(fit(simulated, 0), target)) == [3]
