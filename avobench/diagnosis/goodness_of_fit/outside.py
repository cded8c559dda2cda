"""What speaks for something outside the catalogue: what the best model of it leaves."""

import numpy as np

from avobench.diagnosis.schema import Gap
from avobench.diagnosis.settings import SCORE, TEST

LEAST = 1e-300
"""A p-value below which it tells no more."""


def left(before: Gap, after: Gap | None) -> float:
    """The share of the held-out gap that is left with effects: 1 if it did not shrink, or none was added."""
    if after is None or after.value >= before.value:
        return 1.0
    return float(np.clip((after.value - 1) / (before.value - 1), 0, 1)) if before.value > 1 else 0.0


def outside(p_value: float, share: float, alpha: float) -> float:
    """What outside weighs beside sets of effects, by the p-value of the best one and the share of the gap it leaves.

    If what is missing is in the catalogue, and so is its shape, p is uniform; if only its family is, most of the gap
    goes. What is left counts where the model is rejected, from half of the gap on as if it were all.
    """
    constant, of_p, of_gap = SCORE.outside
    rejected = p_value < TEST.rejected_share * alpha
    return float(np.exp(constant + of_p * misfit(p_value) + of_gap * rejected * min(2 * share, 1)))


def misfit(p_value: float) -> float:
    """ln(1 - log10 p), which is 0.7 at 0.1 and 5 at 1e-150."""
    return float(np.log1p(-np.log10(max(p_value, LEAST))))
