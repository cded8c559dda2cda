"""A fit made sharper: more events in small designs around it, until it is plain what the data identify."""

from functools import partial

import numpy as np

from avobench.diagnosis.fit.descent import WORSE, descend, minimise
from avobench.diagnosis.fit.fit import Fit, fit_at
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.surrogate import Design, quadratic, surrogate
from avobench.diagnosis.summary.target import Target

SHARPENINGS = 4
"""Rounds of a sharpening, at most."""
INSIDE = 0.9
"""Of a design: a minimum further out may lie beyond it."""


def sharpen(
    fit: Fit,
    target: Target,
    rng: np.random.Generator,
    num_events: int,
    rounds: int = SHARPENINGS,
    known: KnownModel | None = None,
) -> Fit:
    """The same fit with many events in small designs around it."""
    num_events = fit.afforded(num_events)
    design = fit.next_design(ratio=max(num_events / fit.num_events, 1))
    return descend(fit.model, target, design, rng, num_events, rounds, known)


def settled(fit: Fit, target: Target, rng: np.random.Generator, num_events: int, ratios: tuple[float, ...]) -> Fit:
    """The same fit with one more step from many events, and more until it is plain which directions the data identify.

    The degrees of freedom that a fit takes up, and the errors that are quoted, hang on that. A step to the edge of its
    design, or one that promises much, only says where to look next: slopes at an edge are hardly known, and a promise
    may be none. It uses no `KnownModel`: a polynomial over so wide a design is not exact enough where the data say
    nearly nothing.
    """
    centre, best = fit.point, None
    for ratio in ratios:
        more = int(ratio * num_events)
        axes = fit.next_design(ratio=more / fit.num_events).axes
        make = partial(surrogate, fit.model, target, num_events=more, rng=rng)
        s = quadratic(make, Design(centre, axes), target)
        here, step = fit_at(fit.model, s, target, s.design.centre), minimise(fit.model, s, target)
        at_edge = np.abs(s.design.to_t(step.point)).max() > INSIDE
        believed = not at_edge and step.noiseless_q > here.noiseless_q - WORSE * here.noiseless_q_error
        fit, centre = step if believed else here, step.point
        if best is None or fit.noiseless_q < best.noiseless_q + WORSE * np.hypot(
            fit.noiseless_q_error, best.noiseless_q_error
        ):
            best = fit
        if believed and not best.undecided:
            break
    return best
