"""Which fitted effect deserves the name, and which others these data cannot tell from it."""

from dataclasses import dataclass

import numpy as np

from avobench.diagnosis.effects import Effect
from avobench.diagnosis.fit import Fit

MODEL_ERROR = 0.03
"""Of the gap: no shape of the catalogue is expected to describe an effect better than that."""
SHAPE_PRICE = 0.35
"""Of a free shape parameter, in units of ln Q."""
TIE = 0.35
"""Families this close in ln Q are not told apart: their shapes differ by as much."""


@dataclass(frozen=True)
class Ranked:
    """A family's best fit."""

    effect: Effect
    fit: Fit
    score: float


def score(fit: Fit, gap_without: float, num_events: int) -> float:
    """ln(Q / inflation + q ln(N) / 2) + SHAPE_PRICE a shape parameter; low is good.

    What remains matters as a share, not as a difference: an effect in another shape than the catalogue's leaves more
    than noise, and the larger it is the more. With few parameters counts, because a flexible shape imitates others.
    """
    effect = fit.model.effects[-1]
    inflation = 1 + MODEL_ERROR**2 * max(gap_without / fit.dof - 1, 0)
    q = len(effect.parameters)
    left = max(fit.gap, fit.dof / 2) / inflation
    return float(np.log(left + q * np.log(num_events) / 2) + SHAPE_PRICE * (q - 1 + effect.choices))


def ranking(fits: list[Fit], gap_without: float, num_events: int) -> list[Ranked]:
    """The best shape of each family, best family first."""
    best: dict[tuple, Ranked] = {}
    for fit in fits:
        effect = fit.model.effects[-1]
        entry = Ranked(effect, fit, score(fit, gap_without, num_events))
        if effect.key not in best or entry.score < best[effect.key].score:
            best[effect.key] = entry
    return sorted(best.values(), key=lambda entry: entry.score)


def tied(ranks: list[Ranked]) -> list[Ranked]:
    """The families that the first cannot be told from."""
    return [entry for entry in ranks[1:] if entry.score < ranks[0].score + TIE]
