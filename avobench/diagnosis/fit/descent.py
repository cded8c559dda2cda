"""A fit is found from a coarse scan, then from design to design, and made sharper by more events."""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from avobench.diagnosis.fit.fit import Fit, fit_at
from avobench.diagnosis.fit.surrogate import Design, ReferenceModel, Surrogate, quadratic, surrogate
from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.target import Target
from avobench.effects.bank import Given
from avobench.effects.model import Model


def refine(
    model: Model,
    target: Target,
    start: NDArray[np.float64],
    half: NDArray[np.float64] | float,
    rng: np.random.Generator,
    *,
    num_events: int,
    max_rounds: int = 10,
) -> Fit:
    """Fit from `start` (P,) in the unit cube, with designs that begin with half-width `half` and shrink.

    `num_events` are simulated for each.
    """
    design = Design.box(start, np.broadcast_to(half, model.dim).astype(float))
    return descend(model, target, design, rng, num_events, max_rounds)


def descend(
    model: Model,
    target: Target,
    design: Design,
    rng: np.random.Generator,
    num_events: int,
    max_rounds: int,
    reference: ReferenceModel | None = None,
    least: float | None = None,
) -> Fit:
    """Go from design to design, each around the minimum of the last one's surrogate, until it stands still.

    What a surrogate promises is not believed: with many coefficients it follows the data by chance. But where the last
    of `max_rounds` promises much, a few more see whether it is true. Where simulation at the end of a step is clearly
    worse than at its start, the step is taken back and tried in a narrower design. The start is then simulated anew: a
    value that was low by chance would keep every step away.

    Designs are as narrow as it takes for a quadratic to do. An effect with hard edges is none over a wide one. They are
    `least` wide in all directions, and in each round a third of that; by default as wide as the first one where that is
    widest, since little is known yet.
    """
    if model.dim == 0:  # nothing is free
        return fit_at(model, surrogate(model, target, design, num_events, rng), target, design.centre)
    best, lowest, q, error = None, None, np.inf, 0.0
    scale = float(np.abs(design.axes / model.reach(design.centre)[:, None]).max()) if least is None else least
    rounds, promises_much, narrow = 0, False, 1.0
    while rounds < max_rounds + (FIT.extra_rounds if promises_much else 0):
        rounds += 1
        inside = None if reference is None else reference.within(design)
        make = partial(surrogate if inside is None else reference.extended, model, target)
        wanted = inside or design
        s = quadratic(partial(make, num_events=num_events, rng=rng), wanted, target)
        narrow *= np.linalg.norm(s.design.axes) / np.linalg.norm(wanted.axes)
        here, its_error = s.noiseless_q_at_centre(target)
        if here > q + FIT.worse * np.hypot(error, its_error):
            scale /= FIT.shrink
            design = Design(best.point, best.next_design(scale).axes * narrow / FIT.shrink)
            q = np.inf
            continue
        best, q, error = fit_at(model, s, target, s.design.centre), here, its_error
        lowest = best if lowest is None else min(lowest, best, key=lambda fit: fit.noiseless_q + fit.noiseless_q_error)
        step = minimise(model, s, target)
        moved = np.abs(s.design.to_t(step.point)).max()
        design = step.next_design(scale if moved > 0.9 else scale / FIT.shrink)
        promises_much = step.noiseless_q < here - FIT.worse * its_error
        if moved < 0.3 and not promises_much and np.allclose(design.axes, step.next_design().axes):
            best = step
            break
        # A curved model is not known to be as sharp as its slope at a distance says.
        scale, narrow = (scale, min(narrow * FIT.shrink, 1.0)) if moved > 0.9 else (scale / FIT.shrink, narrow)
        design = Design(design.centre, design.axes * narrow)
    # The lowest of many values is low by chance; only a clear difference counts.
    return lowest if lowest.noiseless_q + lowest.noiseless_q_error < best.noiseless_q - best.noiseless_q_error else best


def minimise(model: Model, s: Surrogate, target: Target) -> Fit:
    """The point of the design where the surrogate comes closest to the target.

    The noise of the coefficients adds to the distance, the more the further from the centre. That is left in: where the
    slopes stand out of it, as `next_design` sees to, it hardly matters, and where they do not, nothing should move. Of
    a sample it is taken out: no step has other events than the one before, and between the nodes of a sample there is
    less noise than at them, so that the minimum would lie there.
    """
    axes, centre, p = s.design.axes, s.design.centre, model.dim
    here, slopes, bends = s.residual(target)

    def outside(t: NDArray[np.float64]) -> NDArray[np.float64]:
        u = centre + axes @ t
        return u - model.allowed(u)

    def residual(t: NDArray[np.float64]) -> NDArray[np.float64]:
        whitened = here + t @ (slopes + np.tensordot(t, bends, 1))
        return np.concatenate([whitened, np.sqrt(FIT.anchor) * t, FIT.wall * outside(t)])

    def slope(t: NDArray[np.float64]) -> NDArray[np.float64]:
        wall = FIT.wall * (outside(t) != 0)[:, None] * axes
        steps = slopes + 2 * np.tensordot(t, bends, 1)
        return np.concatenate([steps.T, np.sqrt(FIT.anchor) * np.eye(p), wall])

    t = least_squares(residual, np.zeros(p), slope, bounds=(-1, 1), method="dogbox", max_nfev=60).x
    if isinstance(model.events, Given):

        def distance(t: NDArray[np.float64]) -> float:
            noise = target.num_events * target.rank * s.variance_at(centre + axes @ t)
            return float((residual(t) ** 2).sum()) - noise

        minima = [minimize(distance, start, method="L-BFGS-B", bounds=[(-1, 1)] * p) for start in (t, np.zeros(p))]
        t = min(minima, key=lambda one: one.fun).x
    return fit_at(model, s, target, s.design.to_u(t))


def sharpen(
    fit: Fit,
    target: Target,
    rng: np.random.Generator,
    num_events: int,
    rounds: int = FIT.sharpenings,
    reference: ReferenceModel | None = None,
    least: float | None = None,
) -> Fit:
    """Repeat a fit with many events in small designs around it; `least` as in `descend`."""
    num_events = fit.afforded(num_events)
    design = fit.next_design(ratio=max(num_events / fit.num_events, 1))
    return descend(fit.model, target, design, rng, num_events, rounds, reference, least)


def settled(fit: Fit, target: Target, rng: np.random.Generator, num_events: int, ratios: tuple[float, ...]) -> Fit:
    """Repeat a fit with one step from many events, and more until it is plain which directions the data identify.

    The degrees of freedom that a fit takes up, and the errors of its parameters, depend on it. A step to the edge
    of a design, or one that promises much, only says where to look next: slopes at an edge are hardly known, and a
    promise may be none. Designs are as wide as it takes for slopes to stand out of the noise of simulation, but for
    effects, whose edges are sharp. Where it stays open, the slopes are those of the last fit that knew them, if one
    did. It uses no `ReferenceModel`: a polynomial over so wide a design is not exact enough where the data say
    nearly nothing.
    """
    if fit.model.dim == 0:
        return descend(fit.model, target, fit.design, rng, num_events, 1)
    centre, best, tried = fit.point, None, [fit]
    most = 0.0 if fit.model.effects else FIT.settled
    for ratio in ratios:
        more = int(ratio * num_events)
        axes = fit.next_design(ratio=max(more / fit.num_events, 1), most=most).axes
        make = partial(surrogate, fit.model, target, num_events=more, rng=rng)
        s = quadratic(make, Design(centre, axes), target)
        here, step = fit_at(fit.model, s, target, s.design.centre), minimise(fit.model, s, target)
        at_edge = np.abs(s.design.to_t(step.point)).max() > FIT.inside
        believed = not at_edge and step.noiseless_q > here.noiseless_q - FIT.worse * here.noiseless_q_error
        fit, centre = step if believed else here, step.point
        tried.append(fit)
        if best is None or not best.clearly_below(fit):
            best = fit
        wide = np.linalg.norm(axes) > FIT.shrink * np.linalg.norm(fit.next_design(most=most).axes)
        if believed and not best.undecided and (not wide or fit.model.effects):
            break
    plain = [one for one in tried if not one.undecided]
    return best.with_slopes_of(plain[-1]) if best.undecided and plain else best


def scan(
    model: Model,
    target: Target,
    rng: np.random.Generator,
    *,
    fixed: NDArray[np.float64] | None = None,
    around: NDArray[np.float64] | None = None,
    half: NDArray[np.float64] | float = FIT.searched,
    size: tuple[int, int] = (200, 300),
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A point (P,) of the unit cube near the best, and how near in each coordinate that was searched, from three
    searches, each around the last best.

    `fixed` are values of the last coordinates, which are then not searched; the others near `around`, if that is
    given, and else everywhere. `size` is the number of points of a search and of events at each. As far as points lie
    that are not clearly worse than the best, it may be off.
    """
    points, events = size
    fixed = np.empty(0) if fixed is None else fixed
    p = model.dim - len(fixed)
    if p == 0:
        return fixed, np.empty(0)

    def distances(u: NDArray[np.float64], events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        params = model.from_cube(np.hstack([u, np.tile(fixed, (len(u), 1))]))
        means = target.summary.mean(model.simulate(np.repeat(params, events, axis=0), rng), len(u))
        q, noise = (target.whiten(target.mean - means) ** 2).sum(axis=1), target.num_events / events
        return q, np.sqrt(2 * target.rank * noise**2 + 4 * q * noise)

    centre, half = (np.full(p, 0.5), np.full(p, 0.5)) if around is None else (around, np.full(p, half))
    for _ in range(3):
        u = rng.uniform(np.maximum(centre - half, 0), np.minimum(centre + half, 1), (points, p))
        u = model.allowed(np.hstack([u, np.tile(fixed, (points, 1))]))[:, :p]
        q, error = distances(u, max(events // FIT.hopeless_events, 1))
        u = u[q - q.min() <= FIT.clear * error]
        q, error = distances(u, events)
        centre, alike = u[q.argmin()], u[q - q.min() <= error]
        half = np.maximum(half * 3 * points ** (-1 / p), np.abs(alike - centre).max(axis=0))
    return np.concatenate([centre, fixed]), half


def seen_at(
    model: Model, point: NDArray[np.float64], target: Target, rng: np.random.Generator, num_events: int
) -> tuple[NDArray[np.float64], float]:
    """The whitened residual (r,) of a model that is simulated at a point (P,) of the unit cube, and its noiseless Q."""
    x = model.simulate(np.tile(model.from_cube(point), (num_events, 1)), rng)
    residual = target.whiten(target.mean - target.summary.mean(x)[0])
    return residual, float(residual @ residual) - target.num_events / num_events * target.rank
