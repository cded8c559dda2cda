"""Fits of theta and the effects together: begun at a start, continued, or carried over to another shape."""

from dataclasses import replace

import numpy as np

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import descend, refine
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.scan import scan
from avobench.diagnosis.fit.sharpening import sharpen
from avobench.diagnosis.search.ranking import cost, likely
from avobench.diagnosis.search.starts import ROUGH, Start
from avobench.diagnosis.summary.target import Target

AT_EDGE = 0.48
"""Distance from the middle of theta's range, of which the edge is at 0.5, beyond which a fit counts as driven there."""
STRONG = 10.0
"""Chi-squared per degree of freedom above which theta may be too far off for an effect to be seen from there."""
FURTHEST = 0.2
"""How far, in cube coordinates, theta follows an effect's strength within a first design: a fifth of the range, so that
the design stays inside the cube."""
FIRST_ROUNDS = 3
"""Of every fit of a candidate: enough to tell the promising ones."""
LAST_ROUNDS = 7
"""Of those that go on: with the first ones ten, as many as a fit of theta alone may take."""
AGAIN = 4
"""Rounds of a repetition with more events, which begins where the fit already stands."""
RESHAPED = 3
"""Other shapes of an effect to try beside a second one, best first: each costs a fit for every second effect."""


def joint(start: Start, known: KnownModel, target: Target, rng: np.random.Generator, num_events: int) -> Fit:
    """The first steps of a fit of theta and the effects' parameters together."""
    model = start.model
    last = model.dim - len(model.effects[-1].parameters)
    half = np.full(model.dim, 0.08)
    half[:last] = 0.02
    half[last] = max(start.near, 1e-4)
    design = known.design(start.point, half)
    shear = np.zeros_like(design.axes)
    shear[:last, last] = np.clip(start.along * half[last], -FURTHEST, FURTHEST)
    design = replace(design, axes=design.axes + shear)
    return descend(model, target, design, rng, num_events, FIRST_ROUNDS, known)


def continued(
    fit: Fit, known: KnownModel, target: Target, rng: np.random.Generator, num_events: int, effort: Effort
) -> Fit:
    """The same fit until it stands still.

    One that ends at an edge of theta's range, or far from the data, may have been led there by the effect that was
    missing: theta is then looked for anew.
    """
    p = fit.model.num_theta
    fit = sharpen(fit, target, rng, num_events, rounds=LAST_ROUNDS, known=known)
    if np.abs(fit.point[:p] - 0.5).max() < AT_EDGE and fit.noiseless_q < STRONG * fit.dof:
        return fit
    centre, near = scan(fit.model, target, rng, fixed=fit.point[p:], size=effort.scan)
    half = np.r_[np.maximum(near, 0.005), 0.3 * fit.model.reach(centre)[p:]]
    again = refine(fit.model, target, centre, half, rng, num_events=num_events, known=known)
    return min(fit, again, key=lambda f: f.noiseless_q)


def reshaped(
    pairs: list[Fit],
    known: KnownModel,
    others: tuple[Fit, ...],
    target: Target,
    rng: np.random.Generator,
    effort: Effort,
    q_without: float,
) -> list[tuple[Fit, KnownModel]]:
    """Fits of effects that differ in the last one, each with the one before in another shape if that leaves less.

    Without the last, that one took the shape that imitates it best. `others` are fits without the last, in other shapes
    of the one before; `known` is the model without the last, as is what is returned beside each fit.
    """
    best = [(pair, known) for pair in pairs]
    for alone in others[:RESHAPED]:
        reshaped_known = alone.known(target, int(effort.known * target.num_events), rng)
        for k, pair in enumerate(pairs):
            again = beside(pair, reshaped_known, alone, target, rng, effort, q_without)
            best[k] = min(best[k], (again, reshaped_known), key=lambda each: cost(each[0]))
    return best


def beside(
    pair: Fit,
    known: KnownModel,
    alone: Fit,
    target: Target,
    rng: np.random.Generator,
    effort: Effort,
    q_without: float,
) -> Fit:
    """The last effect of a pair added to another fit, whose model is `known`, from the values it has in the pair.

    With as many events as the pair where the two may be tied.
    """
    second, before = pair.model.effects[-1], alone.model
    model = before.plus(second)
    if pair.model.stretch:
        stretch = before.stretch or (1.0,) * len(before.effects)
        model = replace(model, stretch=(*stretch, pair.model.stretch[-1]))
    point = np.concatenate([alone.point, pair.point[-len(second.parameters) :]])
    start = Start(model, point, np.nan, ROUGH * model.strengths(point)[before.dim])
    few = min(pair.num_events, max(int(effort.again[0] * target.num_events), effort.least))
    fit = continued(joint(start, known, target, rng, effort.fit), known, target, rng, few, effort)
    if few < pair.num_events and likely(fit, pair, q_without):
        fit = sharpen(fit, target, rng, pair.num_events, AGAIN, known)
    return fit
