"""Where fits of an effect begin: at what looked best in screening, or searched with theta."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.scan import scan
from avobench.diagnosis.search.screening import Look, Sample
from avobench.effects.model import Model

ABSORBED = 0.3
"""Share of an effect's signal below which theta hides it, so that it is also looked for where it is strong. Chosen
by trial."""
NEAR = np.array([0.05, 0.1])
"""Strengths, as shares of the range, at which it is found out whether theta hides an effect: weak, but above noise."""
FAR = np.linspace(0.1, 1, 10)
"""Strengths, as shares of the range, at which an effect that theta hides is looked for: the rest of the range."""
MODES = 2
"""Places at which a fit begins that were found in this way, at most, to either side."""
COARSE = 10
"""Points of theta a parameter, in each search for it beside a strength; the last strength's theta is not far."""
FOLLOWED = 2
"""Linear steps of theta that follow such a search."""
ROUGH = 0.5
"""How far a strength from a grid may be off, as a share of it: the steps of STRENGTHS are factors of three to five."""
GUESSED = 0.003
"""How far a strength that is read off the data may be off, as a share of it: an edge, known to about one event."""


@dataclass(frozen=True)
class Start:
    """Where to begin a fit: a shape, its cube coordinates with theta, and the Q that screening expects there."""

    model: Model
    point: NDArray[np.float64]
    expected: float
    near: float
    """How far the strength may be off, in cube coordinates."""
    along: NDArray[np.float64] | float = 0.0
    """How the fit's parameters move, in cube coordinates (P,), with that of the strength."""


def starts_of(fit: Fit, look: Look) -> list[Start]:
    """The best one or two points of a look at an effect, to add it to a fitted model there."""
    model, strength, points = fit.model.plus(look.effect), look.effect.parameters[0], look.points
    expected, gain = look.expected(fit)
    order = np.argsort(expected)
    chosen = [order[0]]
    if points.shape[1] > 1:
        far = [i for i in order if np.abs(points[i, 1:] - points[order[0], 1:]).max() > 1e-12]
        chosen += far[:1]
    starts = []
    for i in chosen:
        phi = points[i].copy()
        phi[0] = strength.null + max(gain[i], 0.05) * (phi[0] - strength.null)
        shift = fit.follow(fit.residual - gain[i] * look.change[i])
        theta = np.clip(fit.point + np.clip(shift, -0.1, 0.1), 0, 1)
        point = np.concatenate([theta, model.to_cube(np.concatenate([fit.params, phi]))[fit.model.dim :]])
        step = (points[i, 0] - strength.null) / (strength.high - strength.low)
        along = -fit.follow(look.change[i]) / step
        off = GUESSED if look.guessed else ROUGH
        noiseless = float(expected[i]) - fit.noise * fit.dof  # as is that of the fit
        starts.append(Start(model, point, noiseless, off * model.strengths(point)[fit.model.dim], along))
    return starts


def hidden(sample: Sample, start: Start, rng: np.random.Generator, effort: Effort) -> list[Start]:
    """Starts at large strengths, to either side, of an effect whose small strength theta hides; else none.

    Theta is searched for at each of a row of strengths, near where it was at the one before; where it then fits better
    than beside it, a fit may begin.
    """
    fit, target, effect = sample.fit, sample.target, start.model.effects[-1]
    strength, p = effect.parameters[0], fit.model.dim
    of_theta, _ = np.linalg.qr(fit.jacobian[:, : fit.model.num_theta])
    free, shape = fit.projector(), start.model.from_cube(start.point)[p + 1 :]
    starts = []
    for side in [side for side in (strength.high, strength.low) if side != strength.null]:
        near, points = (
            np.array([[strength.null + share * (side - strength.null), *shape] for share in shares])
            for shares in (NEAR, FAR)
        )
        change, scatter = sample.changes(effect, near, effort.screen // 4, rng)
        moves = (change - change @ of_theta @ of_theta.T, change)
        kept, whole = ((each**2).sum(axis=1) - scatter for each in moves)
        seen = whole > 3 * scatter * np.sqrt(2 / target.rank)
        if not (seen & (kept < ABSORBED * whole)).any():
            continue
        row, size, theta = [], (min(COARSE**p, effort.scan[0] // 4), effort.scan[1]), fit.point
        for values in points:
            phi = start.model.to_cube(np.concatenate([fit.params, values]))[p:]
            point, _ = scan(start.model, target, rng, fixed=phi, around=theta, size=size)
            for _ in range(FOLLOWED):
                x = start.model.simulate(np.tile(start.model.from_cube(point), (effort.fit // FOLLOWED, 1)), rng)
                left = target.whiten(target.mean - target.summary.mean(x)[0])
                theta = point[:p] = np.clip(point[:p] + np.clip(fit.follow(left), -0.1, 0.1), 0, 1)
            noise = target.num_events / len(x) * target.rank
            row.append((point, float(((left @ free) ** 2).sum()) - noise))
        places, expected = np.array([point for point, _ in row]), np.array([value for _, value in row])
        along = np.gradient(places[:, :p], places[:, p], axis=0)
        between = np.abs(np.diff(places[:, p])).mean()
        beside = np.minimum(np.r_[np.inf, expected[:-1]], np.r_[expected[1:], np.inf])
        lowest = [i for i in np.argsort(expected) if expected[i] < beside[i]]
        starts += [Start(start.model, places[i], expected[i], between, along[i]) for i in lowest[:MODES]]
    return starts
