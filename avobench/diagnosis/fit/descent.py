"""How a fit is found: from design to design, each around the minimum of the last one's surrogate."""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from avobench.diagnosis.fit.fit import Fit, fit_at
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.surrogate import SHRINK, Design, Surrogate, quadratic, surrogate
from avobench.diagnosis.summary.target import Target
from avobench.effects.model import Model

WORSE = 2.0
"""Standard errors by which the end of a step must be worse than its start, to be given up."""
MORE_ROUNDS = 2
"""Of a descent that would end at a promise."""
ANCHOR = 0.1
"""What moving to the edge of the design costs in Q: it keeps parameters still that the data say nothing about."""
WALL = 1e4
"""Slope of the penalty that keeps a fit within the unit cube, in standard errors."""


def refine(
    model: Model,
    target: Target,
    start: NDArray[np.float64],
    half: NDArray[np.float64] | float,
    rng: np.random.Generator,
    *,
    num_events: int,
    max_rounds: int = 10,
    known: KnownModel | None = None,
) -> Fit:
    """Fit from `start` (P,) in the unit cube, with designs that begin with half-width `half` and shrink.

    `num_events` are simulated for each. `known` is the model without its last effect, if that is known well.
    """
    half = np.broadcast_to(half, model.dim).astype(float)
    design = Design.box(start, half) if known is None else known.design(start, half)
    return descend(model, target, design, rng, num_events, max_rounds, known)


def descend(
    model: Model,
    target: Target,
    design: Design,
    rng: np.random.Generator,
    num_events: int,
    max_rounds: int,
    known: KnownModel | None = None,
) -> Fit:
    """Go from design to design, each around the minimum of the last one's surrogate, until it stands still.

    What a surrogate promises is not believed: with many coefficients it follows the data by chance. But where the last
    of `max_rounds` promises much, MORE_ROUNDS at most see whether it is true. Where simulation at the end of a step is
    clearly worse than at its start, the step is taken back and tried in a narrower design. The start is then simulated
    anew: a value that was low by chance would keep every step away.

    Designs are as narrow as it takes for a quadratic to do. An effect with hard edges is none over a wide one.
    """
    best, lowest, q, error = None, None, np.inf, 0.0
    scale = float(np.abs(design.axes / model.reach(design.centre)[:, None]).max())
    rounds, promises_much, narrow = 0, False, 1.0
    while rounds < max_rounds + (MORE_ROUNDS if promises_much else 0):
        rounds += 1
        inside = None if known is None else known.within(design)
        make = partial(surrogate if inside is None else known.extended, model, target)
        wanted = inside or design
        s = quadratic(partial(make, num_events=num_events, rng=rng), wanted, target)
        narrow *= np.linalg.norm(s.design.axes) / np.linalg.norm(wanted.axes)
        here, its_error = s.noiseless_q_at_centre(target)
        if here > q + WORSE * np.hypot(error, its_error):
            scale /= SHRINK
            design = Design(best.point, best.next_design(scale).axes * narrow / SHRINK)
            q = np.inf
            continue
        best, q, error = fit_at(model, s, target, s.design.centre), here, its_error
        lowest = best if lowest is None else min(lowest, best, key=lambda fit: fit.noiseless_q + fit.noiseless_q_error)
        step = minimise(model, s, target)
        moved = np.abs(s.design.to_t(step.point)).max()
        design = step.next_design(scale if moved > 0.9 else scale / SHRINK)
        promises_much = step.noiseless_q < here - WORSE * its_error
        if moved < 0.3 and not promises_much and np.allclose(design.axes, step.next_design().axes):
            best = step
            break
        # A curved model is not known to be as sharp as its slope at a distance says.
        scale, narrow = (scale, min(narrow * SHRINK, 1.0)) if moved > 0.9 else (scale / SHRINK, narrow)
        design = Design(design.centre, design.axes * narrow)
    # The lowest of many values is low by chance; only a clear difference counts.
    return lowest if lowest.noiseless_q + lowest.noiseless_q_error < best.noiseless_q - best.noiseless_q_error else best


def minimise(model: Model, s: Surrogate, target: Target) -> Fit:
    """The point of the design where the surrogate comes closest to the target.

    The noise of the coefficients adds to the distance, the more the further from the centre. That is left in: where the
    slopes stand out of it, as `next_design` sees to, it hardly matters, and where they do not, nothing should move.
    """
    terms, wanted = target.whiten(s.coefficients), target.whiten(target.mean)
    axes, centre, p = s.design.axes, s.design.centre, model.dim

    def outside(t: NDArray[np.float64]) -> NDArray[np.float64]:
        u = centre + axes @ t
        return u - np.clip(u, 0, 1)

    bends = np.zeros((p, p, terms.shape[1]))  # of the products of t, half for each order of the two factors
    i, j = np.triu_indices(p)
    bends[i, j] += terms[p + 1 :] / 2
    bends[j, i] += terms[p + 1 :] / 2

    def residual(t: NDArray[np.float64]) -> NDArray[np.float64]:
        left = terms[0] - wanted + t @ (terms[1 : p + 1] + np.tensordot(t, bends, 1))
        return np.concatenate([left, np.sqrt(ANCHOR) * t, WALL * outside(t)])

    def slope(t: NDArray[np.float64]) -> NDArray[np.float64]:
        wall = WALL * (outside(t) != 0)[:, None] * axes
        steps = terms[1 : p + 1] + 2 * np.tensordot(t, bends, 1)
        return np.concatenate([steps.T, np.sqrt(ANCHOR) * np.eye(p), wall])

    t = least_squares(residual, np.zeros(p), slope, bounds=(-1, 1), method="dogbox", max_nfev=60).x
    return fit_at(model, s, target, s.design.to_u(t))
