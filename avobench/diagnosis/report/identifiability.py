"""The identifiability card: what these data could not have shown, and what it would do to theta unseen."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.schema import Identifiable, Named
from avobench.diagnosis.search.screening import Sample
from avobench.diagnosis.settings import REPORT, SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.tasks import Task


def noncentrality(dof: int, alpha: float) -> float:
    """The noncentrality with which a chi-squared test at level alpha rejects with the power of the card."""
    critical = chi2.isf(alpha, dof)
    return float(brentq(lambda value: ncx2.sf(critical, dof, value) - REPORT.power, 1e-3, 1e4 + 10 * dof))


def card(
    fit: Fit, target: Target, effects: list[Effect], alpha: float, rng: np.random.Generator, effort: Effort
) -> list[Identifiable]:
    """A row for each effect that the model has not, in its plainest shape with middling shape parameters.

    Of several classes of a family that is the first one's. `alpha` is the level of the summary test.
    """
    need = noncentrality(max(fit.dof, 1), alpha) * (1 + fit.noise)
    sample = Sample(fit, target, effort.card * len(SEARCH.strengths), rng)
    families: dict[tuple, Effect] = {}
    for effect in effects:
        if effect.key not in {one.key for one in fit.model.effects}:
            families.setdefault(effect.key, effect)
    if not families:
        return []
    rows, directions = zip(*(_row(sample, each, need, rng, effort.card) for each in families.values()), strict=True)
    alike = np.array(directions) @ np.array(directions).T > REPORT.rivals
    names = [Named(name=row.name, feature=row.feature) for row in rows]
    rivals = [[name for j, name in enumerate(names) if j != i and alike[i, j]] for i in range(len(rows))]
    return [row.model_copy(update={"rivals": each}) for row, each in zip(rows, rivals, strict=True)]


def _row(
    sample: Sample, effect: Effect, need: float, rng: np.random.Generator, events: int
) -> tuple[Identifiable, NDArray[np.float64]]:
    """The row without rivals, and the direction (r,) of what the effect leaves after the fit; zero if that is noise."""
    strength, *shape = effect.parameters
    task = sample.fit.model.task
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
        return _identifiable(effect, task), np.zeros(target.rank)
    retained = float(np.clip(kept[i] / whole[i], 0, 1))
    noisy = kept[i] <= REPORT.shown * scatter[i] * np.sqrt(2 / target.rank)
    direction = np.zeros(target.rank) if noisy else free[i] / np.linalg.norm(free[i])
    if noisy or kept[i] < need:
        return _identifiable(effect, task, retained), direction
    i = int(np.argmax(kept >= need))
    if i == 0 or kept[i - 1] <= 0:  # the signal grows as the square of the strength
        size_needed = size[i] * np.sqrt(need / kept[i])
    else:
        size_needed = np.exp(np.interp(np.log(need), np.log(kept[i - 1 : i + 1]), np.log(size[i - 1 : i + 1])))
    shift = fit.follow(change[i] * size_needed / size[i])
    bias = fit.model.from_cube(np.clip(fit.point + shift, 0, 1)) - fit.params
    detectable = float(strength.null + np.sign(side - strength.null) * size_needed)
    theta_bias = dict(zip(task.parameter_names, bias.tolist(), strict=False))
    return _identifiable(effect, task, retained, detectable, theta_bias), direction


def _identifiable(
    effect: Effect,
    task: Task,
    retained: float | None = None,
    detectable: float | None = None,
    bias: dict[str, float] | None = None,
) -> Identifiable:
    """A row of the card without rivals."""
    name = named(effect.key, task.labels).model_dump()
    return Identifiable(**name, retained=retained, minimum_detectable=detectable, theta_bias=bias or {}, rivals=[])
