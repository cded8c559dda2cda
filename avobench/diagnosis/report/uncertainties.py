"""Values of a fitted model with uncertainties that cover the other shapes which the data allow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.descent import settled
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Combination, EffectValue, FoundEffect, Named, Probable, ProbableModel, Value
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.settings import FIT, REPORT
from avobench.diagnosis.summary.target import Target


@dataclass(frozen=True)
class Move:
    """Another effect, or another shape of it, that the data allow, and where theta would be with it."""

    theta: NDArray[np.float64]
    """The shift of theta, in units of its range, along what the data determine of it: (p,)."""
    worse: float
    """The least by which chi-squared is worse."""
    covariance: NDArray[np.float64]
    """The covariance of theta there, along the same: (p, p)."""


def ambiguity(
    last: Fit, chosen: Fit, rivals: list[Fit], target: Target, rng: np.random.Generator, num_events: int
) -> list[Move]:
    """What theta would be with other shapes of the chosen effects, or with other effects: `rivals`.

    Those that move it furthest are fitted once more with `num_events`. Only what the data determine of theta counts, by
    the final fit `last`. How far theta moves is measured in events of the chosen model, since a straight line between
    two values may mean nothing where they are not determined.
    """
    p, seed, model = last.model.num_theta, int(rng.integers(2**63)), chosen.model
    determined = _determined(last)[1]

    def settle(fit: Fit) -> Fit:
        return settled(fit, target, rng, num_events, (1, 3))

    def worse(fit: Fit, than: Fit) -> float:
        shapes = shape_parameters(fit) - shape_parameters(than)
        return max(
            fit.noiseless_q + shapes - than.noiseless_q - np.hypot(fit.noiseless_q_error, than.noiseless_q_error), 0.0
        )

    def mean(fit: Fit) -> NDArray[np.float64]:
        params, n = np.concatenate([fit.params[:p], chosen.params[p:]]), REPORT.compared * target.num_events
        x = model.simulate(np.tile(params, (min(n, REPORT.compared_events), 1)), np.random.default_rng(seed))
        return target.whiten(target.summary.mean(x)[0])

    def back(fit: Fit) -> NDArray[np.float64]:
        return determined @ np.linalg.pinv(fit.jacobian[:, :p] @ determined)

    rivals = [fit for fit in rivals if worse(fit, chosen) < REPORT.allowed]
    if not rivals:
        return []
    here, along = mean(chosen), back(chosen)
    far = [np.abs(along @ (mean(fit) - here)).max() for fit in rivals]
    best = settle(chosen)
    here, along, moves = mean(best), back(best), []
    for k in np.argsort(far)[::-1][: REPORT.refitted]:
        fit = settle(rivals[k])
        if (by := worse(fit, best)) < REPORT.allowed:
            there = along @ fit.jacobian[:, :p]
            moves.append(Move(along @ (mean(fit) - here), by, there @ fit.point_covariance[:p, :p] @ there.T))
    return moves


def shape_parameters(fit: Fit) -> int:
    """The number of parameters that the effects of a fit have beside their strengths."""
    return sum(len(effect.parameters) - 1 + effect.choices for effect in fit.model.effects)


def covering(std: NDArray[np.float64], directions: NDArray[np.float64], moves: Sequence[Move]) -> NDArray[np.float64]:
    """Standard errors (k,) of theta along directions (p, k), such that twice as much covers what the data allow.

    The envelope of the parabolas of all shapes (P. D. Dauncey et al., JINST 10 (2015) P04015); that of the chosen one
    has the errors `std` (k,).
    """
    half = [2 * std]
    for move in moves:
        spread = np.einsum("ik,ij,jk->k", directions, move.covariance, directions)
        spread = np.sqrt(np.minimum(spread, (directions**2).sum(axis=0) / 12))  # no more than the range alone gives
        half.append(np.abs(move.theta @ directions) + spread * np.sqrt(REPORT.allowed - move.worse))
    return np.max(half, axis=0) / 2


@dataclass(frozen=True)
class QuotedFit:
    """A fit with the uncertainties that are quoted of it, larger where the model does not describe the events."""

    fit: Fit
    moves: Sequence[Move] = ()
    """The shifts of theta with other effects or shapes that the data allow."""

    @property
    def scale(self) -> float:
        """The factor on all errors, above 1 where the model does not describe the events."""
        return float(np.sqrt(max(1.0, self.fit.q / max(self.fit.dof, 1))))

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard errors (P,) with the shapes that were fitted."""
        return self.fit.std * self.scale

    @property
    def _width(self) -> NDArray[np.float64]:
        """The range of theta (p,)."""
        model = self.fit.model
        return (model.high - model.low)[: model.num_theta]

    @property
    def theta(self) -> dict[str, Value]:
        """The parameters of the task, with errors that cover the other shapes that the data allow."""
        p, fit = self.fit.model.num_theta, self.fit
        std = covering(self.std[:p], np.diag(self._width), self.moves)
        values, std = fit.model.task.quoted(fit.params[:p], std)
        return {
            name: Value(value=float(values[i]), std=float(std[i]))
            for i, name in enumerate(fit.model.task.parameter_names)
        }

    @property
    def identified(self) -> list[Combination]:
        """The combinations of theta that the data determine, best known first; uncorrelated with each other.

        Eigenvectors of the covariance of theta, the parameters of the effects being free, in units of theta's range. A
        combination counts whose error is less than a fifth of what the range alone would give.
        """
        p, model, width = self.fit.model.num_theta, self.fit.model, self._width
        variances, directions = _determined(self.fit)
        std = covering(self.scale * np.sqrt(variances), directions, self.moves)
        return [
            Combination(
                coefficients=dict(zip(model.task.parameter_names, map(float, direction / width), strict=True)),
                value=float(direction / width @ self.fit.params[:p]),
                std=float(error),
            )
            for error, direction in zip(std, directions.T, strict=True)
        ]

    def effect(self, k: int, posterior: Posterior, names: tuple[str, ...]) -> FoundEffect:
        """The k-th effect of the model, with its parameters; `names` are those of the features."""
        model, std = self.fit.model, self.std
        effect, at = model.effects[k], model.columns(k).start
        parameters = {
            p.name: EffectValue(
                value=float(self.fit.params[i]),
                std=None if p.known else float(std[i]),
                null=p.null,
                unit=model.units[i],
            )
            for i, p in enumerate(effect.parameters, at)
        }
        return FoundEffect(
            **named(effect.key, names).model_dump(),
            shape=effect.shape,
            parameters=parameters,
            tied_with=[named(key, names) for key in posterior.rivals(k)],
            probability=posterior.included[effect.key],
        )


def _determined(fit: Fit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The directions of theta in the unit cube that the data determine, with the variance along each: (k,), (p, k)."""
    p = fit.model.num_theta
    variances, directions = np.linalg.eigh(fit.point_covariance[:p, :p])
    determined = variances < 1 / FIT.identified**2 / 12
    return variances[determined], directions[:, determined]


def named(key: tuple, names: tuple[str, ...]) -> Named:
    """An effect by its key, its feature by its name."""
    name, feature = key
    return Named(name=name, feature=names[feature] if isinstance(feature, int) else feature)


def probabilities(posterior: Posterior, names: tuple[str, ...]) -> list[Probable]:
    """The probability of every effect that was considered to be in the model; most probable first."""
    return [
        Probable(**named(key, names).model_dump(), probability=min(share, 1.0))
        for key, share in posterior.included.items()
    ]


def models(posterior: Posterior, names: tuple[str, ...]) -> list[ProbableModel]:
    """The smallest set of models that is credible, should it be one of the catalogue."""
    return [
        ProbableModel(
            effects=[named(key, names) for key in sorted(each, key=str)], probability=posterior.probability[each]
        )
        for each in posterior.credible
    ]
