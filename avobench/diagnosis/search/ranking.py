"""Which fitted effect deserves the name, and which others these data cannot tell from it."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.diagnosis.fit.fit import Fit
from avobench.effects import Effect

MODEL_ERROR = 0.03
"""No shape of the catalogue is expected to describe a real effect better than to this share of what it does."""
INDEPENDENT = 8.0
"""Wrong shapes leave smooth remainders, as if the summary had so many independent parts."""
SHAPE_PRICE = 5.0
"""Of a free shape parameter, in chi-squared: what searching a range of shapes gains by chance."""
TIE = 9.0
"""Families this close in score are not told apart: the price of a parameter, and four for scatter."""


@dataclass(frozen=True)
class Ranked:
    """A family's best fit, and how much worse it is than that of the best family, in chi-squared."""

    effect: Effect
    fit: Fit
    score: float
    others: tuple[Fit, ...] = ()
    """Those of the family in its other shapes, or elsewhere in the same, best first."""


def shape_parameters(effect: Effect) -> int:
    return len(effect.parameters) - 1 + effect.choices


def prices(fit: Fit) -> list[float]:
    """What each effect of a fit costs, in chi-squared: its shape parameters, and a strength that is unusual."""
    found = []
    for effect, at in zip(fit.model.effects, fit.model.strengths(fit.point), strict=True):
        strength = effect.parameters[0]
        unusual = float((fit.params[at] - strength.null) / strength.usual)
        found.append(SHAPE_PRICE * shape_parameters(effect) + 2 * np.log1p(unusual**2))  # as of a Cauchy distribution
    return found


def yardstick_of(left: float, q_without: float) -> float:
    """What differences of chi-squared count in, where the best fit leaves so much beyond noise."""
    return 1 + max(left, MODEL_ERROR**2 * q_without, 0) / INDEPENDENT


def likely(fit: Fit, best: Fit, q_without: float) -> bool:
    """Whether with more events a fit may turn out to be tied with the one that seems best."""
    yardstick = yardstick_of(best.noiseless_q + best.noiseless_q_error - best.dof, q_without)
    return fit.noiseless_q - 2 * fit.noiseless_q_error < best.noiseless_q + 2 * best.noiseless_q_error + yardstick * (
        TIE + 2 * SHAPE_PRICE
    )


def left(fit: Fit) -> float:
    """What a fit leaves, at most: one that is known badly must not win by chance. Below noise nothing is better."""
    return max(fit.noiseless_q + fit.noiseless_q_error, fit.dof - 2 * np.sqrt(2 * fit.dof))


def cost(fit: Fit, yardstick: float = 1.0) -> float:
    """What a fit leaves, measured by the yardstick, and the prices of all its effects."""
    return left(fit) / yardstick + sum(prices(fit))


def ranking(fits: list[Fit], q_without: float) -> list[Ranked]:
    """The best shape of each family, best family first; the score of the first is 0.

    A score is a difference of chi-squared, in units of what the best fit itself leaves beyond noise. Where it leaves
    nothing, differences count as they are: data that resolve two effects tell them apart. Where it leaves much, since
    the real effect has another shape than the catalogue's, only the share matters that a rival leaves. Few parameters
    count, because a flexible shape imitates others.
    """
    if not fits:
        return []
    yardstick = 1.0
    for _ in range(len(fits)):  # the best depends on the yardstick, and the yardstick on the best
        best = min(fits, key=lambda fit: left(fit) + yardstick * prices(fit)[-1])
        last, yardstick = yardstick, yardstick_of(left(best) - best.dof, q_without)
        if yardstick == last:
            break
    families: dict[tuple, Ranked] = {}
    for fit in fits:
        effect = fit.model.effects[-1]
        entry = Ranked(effect, fit, (left(fit) - left(best)) / yardstick + prices(fit)[-1] - prices(best)[-1])
        if effect.key not in families or entry.score < families[effect.key].score:
            families[effect.key] = entry
    ranks = sorted(families.values(), key=lambda entry: entry.score)
    by_gap = sorted(fits, key=lambda fit: fit.noiseless_q)
    return [
        replace(entry, others=tuple(f for f in by_gap if f.model.effects[-1].key == key and f is not entry.fit))
        for entry in ranks
        for key in [entry.effect.key]
    ]


def tied(ranks: list[Ranked]) -> list[Ranked]:
    """The families that the first cannot be told from."""
    return [entry for entry in ranks[1:] if entry.score < ranks[0].score + TIE]
