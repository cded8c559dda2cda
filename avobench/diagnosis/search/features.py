"""Where there are several features: which of them shows something that no effect so far explains."""

import numpy as np

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.summary.bins import Bins
from avobench.diagnosis.summary.target import Target, whitening

CLOSES = 0.5
"""Share of the excess that an effect must close to be named: one that leaves the larger part is not what is missing."""
CLEARLY = 4.0
"""Standard deviations of chi-squared by which the excess of a feature's own bins must stand out to count: with tens of
features, four are next to never reached by chance."""


def excess_by_feature(fit: Fit, target: Target) -> dict[int, float]:
    """By how much chi-squared of each feature's own bins exceeds their number.

    Nothing where there is one feature, or where the summary does not tell them apart.
    """
    if not isinstance(target.summary, Bins) or len(target.summary.edges) == 1:
        return {}
    residual, start, found = target.mean - fit.predicted, 0, {}
    for features, size in target.summary.blocks:
        if len(features) == 1:
            own = slice(start, start + size)
            w = whitening(target.cov[own, own])
            q = target.num_events * float(((residual[own] @ w) ** 2).sum())
            found[features[0]] = q - (1 + fit.noise) * w.shape[1]
        start += size
    return found


def open_features(fit: Fit, target: Target) -> dict[int, float]:
    """By how much chi-squared of a feature's own bins is too large, where that is plain and no effect acts on it yet.

    What is left in a feature that no effect acts on is not left by a wrong shape. Largest first.
    """
    acted = {effect.feature for effect in fit.model.effects}
    found = sorted(excess_by_feature(fit, target).items(), key=lambda item: -item[1])
    return {
        feature: value
        for feature, value in found
        if acted.isdisjoint({feature, "all"}) and value > CLEARLY * np.sqrt(2 * len(target.summary.edges[feature]))
    }


def clears_feature(fit: Fit, before: Fit, target: Target) -> bool:
    """Whether the last effect closes most of what its feature shows, on which no effect before it acts."""
    feature, shown = fit.model.effects[-1].feature, open_features(before, target)
    return feature in shown and excess_by_feature(fit, target)[feature] < (1 - CLOSES) * shown[feature]
