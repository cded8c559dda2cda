"""Weights that make simulated events look like measured ones, where no effect explains the disagreement."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.goodness_of_fit.classifier import features_of, trained
from avobench.diagnosis.summary.target import Target


@dataclass(frozen=True)
class Correction:
    """Simulated events of the final model and weights that make them look like measured ones.

    A description of the disagreement, and not a cause.
    """

    x: NDArray
    """(n, d)"""
    weights: NDArray[np.float64]
    """(n,), of mean 1."""


def correction(fit: Fit, target: Target, x: NDArray, rng: np.random.Generator) -> Correction:
    """Odds of a classifier between measured events x (N, d) and as many simulated ones, for as many others."""
    simulated = fit.model.simulate(np.tile(fit.params, (2 * len(x), 1)), rng)
    learn, use = simulated[: len(x)], simulated[len(x) :]
    seen = features_of(target)
    trees = trained(seen(x), seen(learn), int(rng.integers(2**31)))
    odds = np.exp(np.clip(trees.decision_function(seen(use)), -10, 10))
    return Correction(use, odds / odds.mean())
