"""A model that is well known around a fit, to which an effect is to be added."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.surrogate import COMPARED, Design, Surrogate, basis, surrogate
from avobench.diagnosis.summary.target import Vectors
from avobench.effects.model import Model

BEYOND = 0.25
"""Share of where the model is known by which a design may reach beyond that: a quadratic goes on being one a little."""
NEAR = 0.5
"""Share of where the model is known that a larger model's first design takes up, so that its next ones stay within."""
LEAST_ROOM = 0.05
"""Share of a design that must lie within: narrowed to less, it would see no slope."""


@dataclass(frozen=True)
class KnownModel:
    """A model that is well known around a fit, to which an effect is to be added.

    What the effect changes is seen event by event: only those that it changes add to the noise.
    """

    model: Model
    surrogate: Surrogate

    def design(self, start: NDArray[np.float64], half: NDArray[np.float64]) -> Design:
        """A design for the larger model from `start` (P,): a box of half-widths `half` (P,), or what of it is known."""
        p, known = self.model.dim, self.surrogate.design
        inside = np.abs(known.to_t(start[:p])).max() < 1 - NEAR
        if not inside:
            return Design.box(start, half)
        axes = np.diag(half).astype(float)
        lengths = np.abs(known.axes / half[:p, None]).max(axis=0)
        axes[:p, :p] = known.axes * np.minimum(NEAR, 1 / lengths)
        return Design(np.clip(start, 0, 1), axes)

    def within(self, design: Design) -> Design | None:
        """The design, narrowed to where this model is known; None where that leaves next to nothing."""
        p, known = self.model.dim, self.surrogate.design
        room = 1 + BEYOND - np.abs(known.to_t(design.centre[:p]))
        extent = np.abs(np.linalg.inv(known.axes) @ design.axes[:p]) * len(design.axes)
        factor = np.minimum((room[:, None] / np.maximum(extent, 1e-12)).min(axis=0), 1)
        return Design(design.centre, design.axes * factor) if factor.min() > LEAST_ROOM else None

    def extended(
        self, model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator
    ) -> Surrogate:
        """The surrogate of `model`, which is this one with one more effect; half of the events at the centre.

        An effect that changes most events is better seen without this one, from twins of one seed.
        """
        p, k = self.model.dim, (model.dim + 1) * (model.dim + 2) // 2
        normal, change, unlike = np.zeros((k, k)), 0.0, 0.0
        num_centre, change_there = 0, 0.0
        left = num_events
        while left > 0:
            n = min(left, model.at_once)
            u = design.to_u(rng.uniform(-1, 1, (n, model.dim)))
            u[: n // 2] = design.centre
            b = basis(design.to_t(u))
            x, y = with_and_without(self.model, model, model.from_cube(u), rng)
            some = slice(None, None, max(n // COMPARED, 1))
            moved = float(vectors.moved(x[some], y[some]).mean())
            if left == num_events and moved > 1:
                return surrogate(model, vectors, design, num_events, rng)
            unlike += n / num_events * moved
            normal += b.T @ b
            hit = (x != y).any(axis=1)
            change = change + vectors.moments(y[hit], b[hit]) - vectors.moments(x[hit], b[hit])
            there = hit[: n // 2].nonzero()[0]
            one = np.ones((len(there), 1))
            change_there = change_there + (vectors.moments(y[there], one) - vectors.moments(x[there], one))[0]
            num_centre += n // 2
            left -= n
        inverse = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
        # The known polynomial in the coordinates of this design, by its values at as many points as it has terms.
        t = np.random.default_rng(0).uniform(-1, 1, (2 * k, model.dim))
        there = basis(self.surrogate.design.to_t((design.centre + t @ design.axes.T)[:, :p]))
        translate = np.linalg.lstsq(basis(t), there, rcond=None)[0]
        coefficients = inverse @ change + translate @ self.surrogate.coefficients
        noise = unlike * inverse + translate @ self.surrogate.inverse @ translate.T
        constant = np.eye(k)[0]
        alone = np.linalg.pinv(normal - num_centre * np.outer(constant, constant), rcond=1e-12, hermitian=True)
        bend = alone[0] @ (change - np.outer(constant, change_there)) - change_there / num_centre
        return Surrogate(design, coefficients, num_events, noise, bend, unlike * (alone[0, 0] + 1 / num_centre))


def with_and_without(
    before: Model, model: Model, params: NDArray[np.float64], rng: np.random.Generator
) -> tuple[NDArray, NDArray]:
    """Events of a model `before`, and the same with one more effect: params (n, P) of the latter -> (n, d) twice.

    The same as far as the effect asks the simulator for them first, at the parameters that it was given, or, where
    others act after it, as one seed makes them the same.
    """
    p = before.dim
    theta, phi = params[:, :p], params[:, p:]
    if not model.newest_acts_last:
        seed = int(rng.integers(2**63))
        unchanged = before.simulate(theta, np.random.default_rng(seed))
        return unchanged, model.simulate(params, np.random.default_rng(seed))
    first: list[NDArray] = []

    def simulate(params: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = before.simulate(params, rng)
        if not first and np.array_equal(params, theta):
            first.append(x.copy())
        return x

    changed = model.effects[-1].apply(simulate, theta, phi, rng)
    return (first[0] if first else before.simulate(theta, rng)), changed
