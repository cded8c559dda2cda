"""What binned summaries cannot see: a classifier between measured and simulated events, and its test."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import surrogate
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary.pixels import Pixels
from avobench.diagnosis.summary.target import Target
from avobench.effects.pool import Pool

if TYPE_CHECKING:
    from sklearn.ensemble import HistGradientBoostingClassifier

TREES = 60
"""Boosted one after the other. Chosen by trial."""
LEAVES = 12
"""Of a tree, at most: more than three splits deep, for correlations of three features, which no summary sees."""
CHECK_EVENTS = 4
"""Simulated events a measured one, from which the classifier's expectation is taken."""
GRAIN = 1e-6
"""Of a feature's spread: values closer than that are one."""
Features = Callable[[NDArray], NDArray]


def features_of(target: Target) -> Features:
    """What a classifier sees of events: their features, of images the parts of their summary."""
    if isinstance(target.summary, Pixels):
        return target.summary.vectors
    spread = [np.ptp(edges) if len(edges) > 1 else 1.0 for edges in target.summary.edges]
    return partial(rounded, grain=GRAIN * np.array(spread))


def rounded(x: NDArray, grain: NDArray[np.float64]) -> NDArray:
    """Events (n, d) to multiples of `grain` (d,): equal values must not differ by how a computer arrives at them."""
    return x if np.issubdtype(x.dtype, np.integer) else np.rint(x / grain) * grain


def trained(x: NDArray, simulated: NDArray, seed: int) -> "HistGradientBoostingClassifier":
    """A classifier of measured (1) against simulated (0) events."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    labels = np.r_[np.ones(len(x)), np.zeros(len(simulated))]
    trees = HistGradientBoostingClassifier(
        max_iter=TREES, max_leaf_nodes=LEAVES, learning_rate=0.1, early_stopping=False, random_state=seed
    )
    return trees.fit(np.concatenate([x, simulated]), labels)


@dataclass(frozen=True)
class Score:
    """A classifier's log odds, as a summary of one number."""

    trees: "HistGradientBoostingClassifier"
    features: Features

    def of(self, x: NDArray) -> NDArray[np.float64]:
        """(n, d) -> (n,)"""
        return self.trees.decision_function(self.features(x))

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """weights^T s(x): (n, d), (n, b) -> (b, 1)."""
        return weights.T @ self.of(x)[:, None]

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        """Squared change of each event, in units of the variance: (n, d) twice -> (n,)."""
        a = self.of(before)
        return (a - self.of(after)) ** 2 / max(a.var(), 1e-30)


def classifier_gate(fit: Fit, target: Target, x: NDArray, rng: np.random.Generator) -> Gate:
    """Does a classifier, trained on one half of the events x (N, d), tell the other half from simulated ones?

    The statistic is the mean log odds of the second half, less what the model expects, in standard errors; one-sided,
    because a classifier that learned something raises it. Theta was fitted on the same events, to the summary of
    `target`: each event's pull on theta is taken out of the statistic and of its variance, which calibrates the test
    without refits. The halves are not exchanged and averaged: fluctuations that the two halves share by chance raise
    both statistics at once, and their mean is wider than it seems.
    """
    half = len(x) // 2
    learn, judge = x[:half], x[half:]
    at = np.tile(fit.params, (len(x), 1))
    seen, model = features_of(target), fit.model
    if isinstance(model.events, Pool):
        # The pool serves the expectation below; a classifier knows again the events that it learned from.
        model = replace(model, events=model.events.fresh)
    score = Score(trained(seen(learn), seen(model.simulate(at[:half], rng)), int(rng.integers(2**31))), seen)
    expected = surrogate(fit.model, score, fit.design, CHECK_EVENTS * len(x), rng)
    at_fit, slope = expected.at(fit.point)
    g = score.of(judge)
    # Where theta moves if the summary of one event is added, in the directions that the data identify.
    inverse = np.linalg.pinv(fit.information[0] * (1 + fit.noise), hermitian=True)
    pull = np.sqrt(target.num_events) * (slope[:, 0] @ inverse @ fit.jacobian.T) @ target.whitening.T  # (K,)
    s = target.summary.project(x, pull)
    share = len(judge) / len(x)
    influence = -(s - s.mean())
    influence[half:] += (g - g.mean()) / share
    simulation = expected.variance_at(fit.point) * g.var()
    error = np.sqrt(influence.var() / len(x) + simulation)
    t = float((g.mean() - at_fit[0]) / max(error, 1e-12))  # no error where all events are alike
    return Gate(statistic=t, dof=None, p_value=float(norm.sf(t)))
