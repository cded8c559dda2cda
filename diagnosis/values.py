"""What is quoted of a fitted model: values, and errors that cover the other shapes which the data allow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effects import Effect
from avobench.diagnosis.fit import IDENTIFIED, Fit, Target
from avobench.diagnosis.rank import Ranked, shape_parameters
from avobench.diagnosis.schema import Combination, EffectValue, FoundEffect, Named, Value
from avobench.tasks import Task

ALLOWED = 4.0
"""Chi-squared above the best up to which another shape is allowed: two standard errors."""
MOVED_EVENTS = 50_000
"""From which it is taken how far another theta is away."""


@dataclass(frozen=True)
class Move:
    """Another effect, or another shape of it, that the data allow, and where theta would be with it."""

    theta: NDArray[np.float64]
    """How far theta moves, in units of its range, along what the data determine of it: (p,)."""
    worse: float
    """By how much chi-squared is worse."""


def ambiguity(last: Fit, chosen: Ranked, ties: list[Ranked], target: Target, rng: np.random.Generator) -> list[Move]:
    """What theta would be with another shape of the chosen effect, or one that is tied with it.

    `last` is the final fit, in whose model the other theta is compared with the chosen one, since a straight line
    between the two may mean nothing where theta is not determined.
    """
    p, seed = last.model.num_theta, int(rng.integers(2**63))
    information = last.information[0][:p, :p] * (1 + last.noise)

    def corrected(fit: Fit) -> float:
        return fit.gap + shape_parameters(fit.model.effects[-1])

    def mean(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        params = np.concatenate([theta, last.params[p:]])
        x = last.model.simulate(np.tile(params, (MOVED_EVENTS, 1)), np.random.default_rng(seed))
        return target.summary.mean(x)[0]

    rivals = [*chosen.others, *(fit for tie in ties for fit in (tie.fit, *tie.others))]
    allowed = [fit for fit in rivals if corrected(fit) < corrected(chosen.fit) + ALLOWED]
    here = mean(chosen.fit.params[:p])
    changes = [target.whiten(mean(fit.params[:p]) - here) for fit in allowed]
    back = np.linalg.pinv(information, rcond=1e-9, hermitian=True) @ last.jacobian[:, :p].T
    return [
        Move(back @ change, max(corrected(fit) - corrected(chosen.fit), 0.0))
        for fit, change in zip(allowed, changes, strict=True)
    ]


def covering(std: NDArray[np.float64], shifts: NDArray[np.float64], moves: Sequence[Move]) -> NDArray[np.float64]:
    """Standard errors (k,) of values, such that twice as much covers every shape that the data allow.

    The envelope of the parabolas of all shapes (P. D. Dauncey et al., JINST 10 (2015) P04015), each as wide as that
    of the chosen shape, `std` (k,), and `shifts` (moves, k) away.
    """
    half = [np.abs(shift) + std * np.sqrt(ALLOWED - move.worse) for shift, move in zip(shifts, moves, strict=True)]
    return np.max([2 * std, *half], axis=0) / 2


def scale(fit: Fit) -> float:
    """By what errors are larger where the model does not describe the events."""
    return float(np.sqrt(max(1.0, fit.q / max(fit.dof, 1))))


def scaled_std(fit: Fit) -> NDArray[np.float64]:
    """Standard errors (P,), larger where the model does not describe the events."""
    return fit.std * scale(fit)


def theta_values(fit: Fit, moves: Sequence[Move] = ()) -> dict[str, Value]:
    p = fit.model.num_theta
    width = (fit.model.high - fit.model.low)[:p]
    std = covering(scaled_std(fit)[:p], np.array([width * move.theta for move in moves]), moves)
    return {
        name: Value(value=float(fit.params[i]), std=float(std[i]))
        for i, name in enumerate(fit.model.task.parameter_names)
    }


def identified(fit: Fit, moves: Sequence[Move] = ()) -> list[Combination]:
    """The combinations of theta that the data determine, best known first; uncorrelated with each other.

    Eigenvectors of the covariance of theta, the parameters of the effects being free, in units of theta's range. A
    combination counts whose error is less than a fifth of what the range alone would give.
    """
    p, model = fit.model.num_theta, fit.model
    width = (model.high - model.low)[:p]
    variances, directions = np.linalg.eigh(fit.unit_covariance[:p, :p])
    known = variances < 1 / IDENTIFIED**2 / 12
    variances, directions = variances[known], directions[:, known]
    std = scale(fit) * np.sqrt(variances)
    std = covering(std, np.array([move.theta @ directions for move in moves]), moves)
    return [
        Combination(
            coefficients=dict(zip(model.task.parameter_names, map(float, direction / width), strict=True)),
            value=float(direction / width @ fit.params[:p]),
            std=float(error),
        )
        for error, direction in zip(std, directions.T, strict=True)
    ]


def feature_names(task: Task) -> tuple[str, ...]:
    """(d,)"""
    return task.feature_names or tuple(f"x{j + 1}" for j in range(task.num_features))


def named(effect: Effect, names: tuple[str, ...]) -> Named:
    feature = effect.feature
    return Named(name=effect.name, feature=names[feature] if isinstance(feature, int) else feature)


def found_effect(fit: Fit, k: int, ties: list[Ranked], names: tuple[str, ...]) -> FoundEffect:
    """The k-th effect of a fitted model."""
    effect = fit.model.effects[k]
    start = fit.model.num_theta + sum(len(e.parameters) for e in fit.model.effects[:k])
    std = scaled_std(fit)
    parameters = {
        p.name: EffectValue(value=float(fit.params[start + i]), std=float(std[start + i]), null=p.null, unit=p.unit)
        for i, p in enumerate(effect.parameters)
    }
    return FoundEffect(
        **named(effect, names).model_dump(), parameters=parameters, tied_with=[named(t.effect, names) for t in ties]
    )
