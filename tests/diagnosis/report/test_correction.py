import numpy as np
import pytest
from measurements import LIGHT, with_effect
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.metrics import roc_auc_score

from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import correction
from avobench.effects.model import Model
from avobench.tasks.weinberg import Weinberg


def area(measured, simulated, weights):
    """Under the ROC curve of a new classifier, on the half of the events that it did not learn from."""
    x, labels = np.concatenate([measured, simulated]), np.repeat([1, 0], [len(measured), len(simulated)])
    w = np.concatenate([np.ones(len(measured)), weights])
    learn = np.random.default_rng(0).random(len(x)) < 0.5
    trees = HistGradientBoostingClassifier(max_iter=30, random_state=0).fit(x[learn], labels[learn], w[learn])
    return roc_auc_score(labels[~learn], trees.decision_function(x[~learn]), sample_weight=w[~learn])


def test_weights_make_simulated_events_look_like_measured_ones():
    """To a classifier that knows nothing of them, on other measured events."""
    x = with_effect(Weinberg(), "dead_region", [45.5, 1.0], [0.8, 0.3, 0.3], 40_000)
    rng = np.random.default_rng(0)
    fit, target = fit_null(Model(Weinberg()), x[:20_000], rng, LIGHT, None)
    found = correction(fit, target, x[:20_000], rng)
    assert found.x.shape == (20_000, 1)
    assert found.weights.mean() == pytest.approx(1)
    assert (found.weights > 0).all()
    other = x[20_000:]
    assert area(other, found.x, np.ones(20_000)) > 0.53
    assert area(other, found.x, found.weights) == pytest.approx(0.5, abs=0.015)  # three standard errors of an area
