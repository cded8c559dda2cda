"""What these data could not have shown, and what it would do to theta unseen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.screening import Sample
from avobench.diagnosis.settings import REPORT, SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect


def noncentrality(dof: int, alpha: float) -> float:
    """That with which a chi-squared test at level alpha rejects with probability REPORT.power."""
    critical = chi2.isf(alpha, dof)
    return float(brentq(lambda value: ncx2.sf(critical, dof, value) - REPORT.power, 1e-3, 1e4 + 10 * dof))


@dataclass(frozen=True)
class Row:
    """What the data could show of one effect."""

    effect: Effect
    retained: float | None
    """Share of its signal that is left when theta follows; None where it makes no difference that simulation shows."""
    minimum_detectable: float | None
    """The smallest strength seen with probability REPORT.power; None where none within its bounds is."""
    theta_bias: NDArray[np.float64]
    """Of theta (p,) at that strength, if it is not noticed; empty without one."""
    rivals: tuple[Effect, ...] = ()


def card_events(effects: list[Effect], effort: Effort) -> int:
    """Simulated events that the card takes at most: for each effect, with it and without."""
    return (2 * len(effects) + 1) * effort.card * len(SEARCH.strengths)


def card(
    fit: Fit, target: Target, effects: list[Effect], alpha: float, rng: np.random.Generator, effort: Effort
) -> list[Row]:
    """A row for each effect that the model has not, in its plainest shape with middling shape parameters.

    Of several classes of a family that is the first one's.

    `alpha` is the level of the summary gate.
    """
    need = noncentrality(max(fit.dof, 1), alpha) * (1 + fit.noise)
    sample = Sample(fit, target, effort.card * len(SEARCH.strengths), rng)
    there = {effect.key for effect in fit.model.effects}
    rows, left = [], []
    for effect in effects:
        if effect.key not in there:
            there.add(effect.key)
            row, direction = _row(sample, effect, need, rng, effort.card)
            rows.append(row)
            left.append(direction)
    if not rows:
        return []
    alike = np.array(left) @ np.array(left).T
    return [
        replace(row, rivals=tuple(r.effect for j, r in enumerate(rows) if j != i and alike[i, j] > REPORT.rivals))
        for i, row in enumerate(rows)
    ]


def _row(
    sample: Sample, effect: Effect, need: float, rng: np.random.Generator, events: int
) -> tuple[Row, NDArray[np.float64]]:
    """The row without rivals, and the direction (r,) of what the effect leaves after the fit; zero if that is noise."""
    strength, *shape = effect.parameters
    side = strength.high if strength.high != strength.null else strength.low
    middle = [np.sqrt(p.low * p.high) if p.logarithmic else (p.low + p.high) / 2 for p in shape]
    size = np.array(SEARCH.strengths) * abs(side - strength.null)
    points = np.column_stack(
        [strength.null + np.sign(side - strength.null) * size, *(np.full(len(size), m) for m in middle)]
    )
    fit, target = sample.fit, sample.target
    change, scatter = sample.changes(effect, points, events, rng)
    free = change @ fit.projector()
    whole = (change**2).sum(axis=1) - scatter
    kept = (free**2).sum(axis=1) - scatter * fit.dof / target.rank
    i = len(size) - 1
    if whole[i] <= REPORT.shown * scatter[i]:
        return Row(effect, None, None, np.empty(0)), np.zeros(target.rank)
    retained = float(np.clip(kept[i] / whole[i], 0, 1))
    noisy = kept[i] <= REPORT.shown * scatter[i] * np.sqrt(2 / target.rank)
    direction = np.zeros(target.rank) if noisy else free[i] / np.linalg.norm(free[i])
    if noisy or kept[i] < need:
        return Row(effect, retained, None, np.empty(0)), direction
    i = int(np.argmax(kept >= need))
    if i == 0 or kept[i - 1] <= 0:  # the signal grows as the square of the strength
        size_needed = size[i] * np.sqrt(need / kept[i])
    else:
        size_needed = np.exp(np.interp(np.log(need), np.log(kept[i - 1 : i + 1]), np.log(size[i - 1 : i + 1])))
    shift = fit.follow(change[i] * size_needed / size[i])
    bias = fit.model.from_cube(np.clip(fit.point + shift, 0, 1)) - fit.params
    detectable = float(strength.null + np.sign(side - strength.null) * size_needed)
    return Row(effect, retained, detectable, bias[: fit.model.num_theta]), direction
