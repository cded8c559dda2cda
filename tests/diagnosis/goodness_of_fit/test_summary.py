import numpy as np
import pytest
from measurements import LIGHT, measured
from scipy.stats import binom, kstest

from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import summary_gate
from avobench.diagnosis.goodness_of_fit.regions import regions
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson


def p_values(count, theta=1.0, share=0.0):
    """Of the gate, for so many data sets of 3 000 counts, of which a share was not recorded but counted as zero."""
    found = []
    for k in range(count):
        x, rng = measured(Poisson(), [theta], 3000, 100 + k)
        x[rng.random(len(x)) < share] = 0
        fit, target = fit_null(Model(Poisson()), x, rng, LIGHT, None)
        found.append(summary_gate(fit, target, rng, LIGHT)[0].p_value)
    return np.array(found)


@pytest.mark.parametrize("theta", [0.0, 2.5])
def test_p_values_of_a_true_model_are_uniform(theta):
    """Of 40: a right gate fails once in a thousand times, by either of the two."""
    p = p_values(40, theta)
    assert kstest(p, "uniform").pvalue > 5e-4
    assert (p < 0.05).sum() <= binom.isf(5e-4, len(p), 0.05)


def test_the_gate_sees_what_is_plainly_missing():
    """Zeros in excess of 3 % of 3 000 events, of which theta can take up a part: some seven standard errors."""
    assert (p_values(10, 1.5, 0.03) < 0.01).all()


def coins(share, seed=0):
    """Coins of which theta is the share of heads, 0.4 to 0.6: it takes up the one degree of freedom. And a fit."""
    coin = task(
        lambda theta, rng: (rng.random(len(theta)) < theta[:, 0]).astype(int), prior={"p": (0.4, 0.6)}, name="coin"
    )
    rng = np.random.default_rng(seed)
    x = (rng.random((3000, 1)) < share).astype(int)
    fit, target = fit_null(Model(coin), x, rng, LIGHT, None)
    return x, fit, target, rng


def test_a_distance_that_theta_cannot_bridge_is_seen_also_where_no_degree_of_freedom_is_left():
    _, fit, target, rng = coins(0.1)
    assert fit.p_value < 1e-100
    gate = summary_gate(fit, target, rng, LIGHT)[0]
    assert gate.statistic > 500
    assert gate.p_value < 1e-100


def test_where_theta_takes_up_all_there_is_nothing_disagrees_and_nowhere():
    x, fit, target, rng = coins(0.5)
    gate, own, _ = summary_gate(fit, target, rng, LIGHT)
    assert own.dof == 0
    assert gate.p_value > 1e-3
    assert regions(own, target, target.summary.view(x).spans, rng, 0.05, ()) == []


def test_where_nothing_is_expected_and_nothing_measured_a_fit_makes_nothing():
    """Without counts below 6, the model's own covariance knows none either, and would let the threshold fall."""
    (effect,) = (e for e in catalogue(Poisson()) if e.name == "threshold_loss")
    x = np.random.default_rng(41).poisson(9.0, 40_000)
    x = x[x > 5][:5000, None]
    model = Model(Poisson(), (effect.adapted(x),))
    at = np.array([np.log(9.0), 1.0, 6.0])
    rng = np.random.default_rng(0)
    simulated = Poisson().simulate(np.tile(at[:1], (20_000, 1)), rng)
    target = target_of(x, bins_of(x, simulated), simulated)
    for seed in range(4):
        fit = refine(model, target, model.to_cube(at), 0.005, np.random.default_rng(seed), num_events=20_000)
        gate, own, _ = summary_gate(fit, target, np.random.default_rng(seed), LIGHT)
        assert own.params[2] > 5.9
        assert gate.dof < target.rank - 3  # what cannot be otherwise is no degree of freedom
        assert gate.p_value > 1e-3
