import numpy as np
from measurements import LIGHT, measured
from scipy.stats import binom

from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.regions import regions
from avobench.effects.model import Model
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


def found(task, x, rng, alpha=0.05, names=()):
    fit, target = fit_null(Model(task), x, rng, LIGHT, None)
    return regions(fit, target, target.summary.view(x).spans, rng, alpha, names)


def test_a_bump_is_covered_and_its_neighbourhood_is_not():
    x, rng = measured(Weinberg(), [45.5, 1.0], 10_000, 0)
    bump = rng.random(len(x)) < 0.03
    x[bump, 0] = rng.uniform(0.2, 0.3, bump.sum())
    strongest, *others = found(Weinberg(), x, rng, names=("cos_angle",))
    assert (strongest.feature, strongest.kind) == ("cos_angle", "excess")
    assert strongest.z > 5
    assert strongest.p_global < 0.01
    width = 2 / 50  # of a bin: the ends are no more precise
    assert abs(strongest.low - 0.2) < 1.5 * width
    assert abs(strongest.high - 0.3) < 1.5 * width
    assert all(other.high <= strongest.low or other.low >= strongest.high for other in others)


def test_a_hole_is_a_deficit_in_the_feature_where_it_is():
    task, rng = Carl(), np.random.default_rng(0)
    x = task.simulate(np.tile([0.5, -0.5], (20_000, 1)), rng)
    middle = np.median(x[:, 2])
    lost = (np.abs(x[:, 2] - middle) < 0.3 * x[:, 2].std()) & (rng.random(len(x)) < 0.4)
    strongest, *_ = found(task, x[~lost], rng, names=task.labels)
    assert (strongest.feature, strongest.kind) == (task.labels[2], "deficit")
    assert strongest.low < middle < strongest.high


def test_where_nothing_is_missing_a_region_stands_out_as_seldom_as_alpha_says():
    """Although hundreds of intervals are looked at. A right scan fails once in two thousand times."""
    count, alpha = 40, 0.2
    hits = sum(bool(found(Poisson(), *measured(Poisson(), [2.0], 3000, k), alpha)) for k in range(count))
    assert hits <= binom.isf(5e-4, count, alpha)
    assert hits > 0  # of 40 none at all would be odder: once in 7 000 times
