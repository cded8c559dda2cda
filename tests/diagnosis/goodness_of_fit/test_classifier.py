import numpy as np
import pytest
from measurements import LIGHT, measured
from scipy.stats import binom, kstest

from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import classifier_gate, features_of, summary_gate
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.model import Model
from avobench.tasks import Box, Task
from avobench.tasks.poisson import Poisson


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_classifier_does_not_see_how_a_computer_rounds_whatever_the_unit(unit):
    rng = np.random.default_rng(0)
    x = np.column_stack([rng.integers(0, 9, 2000) * 0.708, rng.standard_normal(2000)]) * unit
    seen = features_of(target_of(x, bins_of(x, x), x))
    np.testing.assert_array_equal(seen(x)[:, 0], seen(x * (1 + 1e-9))[:, 0])
    np.testing.assert_allclose(seen(x), x, atol=1e-5 * unit)
    counts = rng.poisson(4, (2000, 1))
    assert features_of(target_of(counts, bins_of(counts, counts), counts))(counts) is counts


class Signs(Task):
    """Three Gaussians of width theta. In the measured events the product of their signs is a little more often +."""

    name, parameter_names, parameter_units, source = "signs", ("width",), ("1",), "test"
    prior, support = Box((0.5,), (1.5,)), Box((0.2,), (3.0,))
    num_features = 3
    summary = floor = None

    def simulate(self, theta, rng):
        return theta * np.abs(rng.standard_normal((len(theta), 3))) * rng.choice([-1, 1], (len(theta), 3))


def both_gates(task, x, rng):
    """The p-values of both gates."""
    fit, target = fit_null(Model(task), x, rng, LIGHT, None)
    gate, own, own_target = summary_gate(fit, target, rng, LIGHT)
    return gate.p_value, classifier_gate(own, own_target, x, rng).p_value


def test_p_values_of_a_true_model_are_uniform():
    """Of 40: a right gate fails once in a thousand times, by either of the two."""
    p = []
    for k in range(40):
        x, rng = measured(Poisson(), [1.5], 1000, k)
        p.append(both_gates(Poisson(), x, rng)[1])
    assert kstest(p, "uniform").pvalue > 5e-4
    assert (np.array(p) < 0.05).sum() <= binom.isf(5e-4, len(p), 0.05)


def test_it_sees_what_lives_in_three_features_together_where_no_bins_do():
    x, rng = measured(Signs(), [1.0], 6000, 0)
    x[(rng.random(len(x)) < 0.3) & (x.prod(axis=1) < 0), 0] *= -1
    summary, classifier = both_gates(Signs(), x, rng)
    assert summary > 1e-3
    assert classifier < 1e-6
