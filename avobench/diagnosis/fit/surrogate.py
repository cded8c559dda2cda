"""The mean summary of a black-box simulator as a quadratic polynomial in its parameters, fitted to simulated events."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.target import Target, Vectors
from avobench.effects.bank import Bank, Session
from avobench.effects.model import Model, Source


@dataclass(frozen=True)
class Design:
    """Where parameters are drawn from: u = centre + axes t, with t in [-1, 1]^P, kept within the unit cube."""

    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    """(P, P), invertible."""

    @classmethod
    def box(cls, centre: NDArray[np.float64], half: NDArray[np.float64]) -> "Design":
        return cls(np.clip(centre, 0, 1), np.diag(half))

    def to_t(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., P) -> (..., P)"""
        return (u - self.centre) @ np.linalg.inv(self.axes).T

    def to_u(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., P) -> (..., P), within the unit cube."""
        return np.clip(self.centre + t @ self.axes.T, 0, 1)


@dataclass(frozen=True)
class Surrogate:
    """E[s] as a quadratic polynomial in a design's t, from a linear regression on simulated events."""

    design: Design
    coefficients: NDArray[np.float64]
    """(b, K)"""
    num_events: int
    inverse: NDArray[np.float64]
    """(b, b), of the normal equations: the covariance of the coefficients in units of that of one event."""
    bend: NDArray[np.float64]
    """(K,), at the centre, from events that are spread minus from those there: noise, unless E[s] is no quadratic."""
    bend_variance: float
    """The variance of `bend` by simulation, in units of that of one event."""

    def noiseless_q_at_centre(self, target: Target) -> tuple[float, float]:
        """Q at the centre of the design, without what simulation adds on average, and its standard error."""
        here = target.summary.linear(self.coefficients[:1])[0]
        return _without_noise(target, target.mean - here, float(self.inverse[0, 0]))

    def lack(self, target: Target) -> tuple[float, float]:
        """What the polynomial lacks at the centre, in Q, and its standard error: the test of response surfaces."""
        bend = target.summary.linear(np.stack([self.coefficients[0], self.bend]))[1]
        return _without_noise(target, bend, self.bend_variance)

    def bends(self, target: Target) -> bool:
        """True if E[s] is plainly no quadratic over the design."""
        lack, error = self.lack(target)
        return lack > max(FIT.clear * error, FIT.bent * self.noiseless_q_at_centre(target)[0])

    def residual(self, target: Target) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Simulated minus measured mean, whitened, as a polynomial in t: (r,), (P, r), and (P, P, r) for t_i t_j.

        The last is symmetric, so that it holds half of what a product of two different ones is multiplied by.
        """
        constant, slopes, products = np.split(
            target.whiten(target.summary.linear(self.coefficients)), [1, self.dim + 1]
        )
        bends = np.zeros((self.dim, self.dim, constant.shape[1]))
        i, j = np.triu_indices(self.dim)
        bends[i, j] += products / 2
        bends[j, i] += products / 2
        return constant[0] - target.whiten(target.mean), slopes, bends

    @property
    def dim(self) -> int:
        return len(self.design.centre)

    def at(self, u: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean summary at u (P,) and its derivative: (K,), (P, K)."""
        t = self.design.to_t(u)
        slope = np.linalg.inv(self.design.axes).T @ basis_slope(t).T @ self.coefficients
        return basis(t[None])[0] @ self.coefficients, slope

    def variance_at(self, u: NDArray[np.float64]) -> float:
        """Variance of `at` by simulation, in units of that of one event."""
        b = basis(self.design.to_t(u)[None])[0]
        return float(b @ self.inverse @ b)


def _without_noise(target: Target, difference: NDArray[np.float64], variance: float) -> tuple[float, float]:
    """Q of a difference (K,) of simulated means, without what their variance adds, and its standard error."""
    noise = target.num_events * variance
    q = float((target.whiten(difference) ** 2).sum())
    return q - noise * target.rank, float(np.sqrt(2 * target.rank * noise**2 + 4 * q * noise))


def basis(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """1, t_i, and all products t_i t_j: (n, P) -> (n, 1 + P + P (P + 1) / 2)."""
    n, p = t.shape
    rows = np.empty(((p + 1) * (p + 2) // 2, n))
    rows[0], rows[1 : p + 1] = 1, t.T
    at = p + 1
    for i in range(p):
        np.multiply(rows[1 + i], rows[1 + i : p + 1], out=rows[at : at + p - i])
        at += p - i
    return rows.T


def basis_slope(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivative of `basis` at one point: (P,) -> (b, P)."""
    p = len(t)
    i, j = np.triu_indices(p)
    products = np.eye(p)[i] * t[j][:, None] + np.eye(p)[j] * t[i][:, None]
    return np.concatenate([np.zeros((1, p)), np.eye(p), products])


def surrogate(model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator) -> Surrogate:
    """The mean vector over a design, by all means that a source of events allows.

    Of events of a bank the last effect is known from what it does to each, so that only what it changes adds to the
    noise; see `ReferenceModel`.
    """
    if isinstance(model.events, Bank) and not model.effects:
        return from_bank(model, vectors, design, num_events, rng)
    if not (isinstance(model.events, Bank) and model.newest_acts_last):
        return from_events(model, vectors, design, num_events, rng)
    before = model.minus(len(model.effects) - 1)
    p = before.dim
    extent = np.maximum(np.abs(design.axes[:p]).sum(axis=1), 1e-6)
    reference = surrogate(before, vectors, Design.box(design.centre[:p], extent), num_events, rng)
    return ReferenceModel(before, reference).extended(model, vectors, design, num_events, rng)


def from_events(model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator) -> Surrogate:
    """The mean vector over a design, from events of which half lie at its centre and half are spread over it.

    Each spread event has a twin at the centre, simulated from the same seed. Where a simulator makes much the same of
    the same seed, the differences of twins tell the slopes with little noise; where it does not, a plain regression
    does. Places and events come from two streams, so that from one seed all models get the same events.
    """
    places, happenings = rng.spawn(2)
    source = model.source()
    pairs, k = max(num_events // 2, 1), (model.dim + 1) * (model.dim + 2) // 2
    normal, at_centre, spread, unlike = np.zeros((k, k)), 0.0, 0.0, 0.0
    remaining = pairs
    while remaining > 0:
        n = min(remaining, model.at_once)
        u = design.to_u(places.uniform(-1, 1, (n, model.dim)))
        b = basis(design.to_t(u))
        seed = int(happenings.integers(2**63))
        twins = model.simulate(model.from_cube(np.tile(design.centre, (n, 1))), np.random.default_rng(seed), source)
        x = model.simulate(model.from_cube(u), np.random.default_rng(seed), source)
        normal += b.T @ b
        at_centre = at_centre + vectors.moments(twins, b)
        spread = spread + vectors.moments(x, b)
        unlike += n / pairs * float(vectors.moved(twins[: FIT.compared_twins], x[: FIT.compared_twins]).mean())
        remaining -= n
    alone, again = np.linalg.pinv(normal, rcond=1e-12, hermitian=True), repeats(source)
    if unlike < 1:
        bend, bend_variance = alone[0] @ (spread - at_centre), unlike * alone[0, 0]
        inverse = np.zeros((k, k))
        inverse[0, 0] = 1 / pairs
        slopes = np.linalg.pinv(normal[1:, 1:], rcond=1e-12, hermitian=True)
        inverse[1:, 1:] = unlike * slopes
        coefficients = np.vstack([at_centre[0] / pairs, slopes @ (spread - at_centre)[1:]])
    else:
        constant = np.eye(k)[0]  # the basis at the centre
        inverse = np.linalg.pinv(normal + pairs * np.outer(constant, constant), rcond=1e-12, hermitian=True)
        coefficients = inverse @ (spread + np.outer(constant, at_centre[0]))
        bend, bend_variance = alone[0] @ spread - at_centre[0] / pairs, alone[0, 0] + 1 / pairs
    return Surrogate(design, coefficients, num_events, again * inverse, bend, again * bend_variance)


def from_bank(model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator) -> Surrogate:
    """The mean vector of a model without effects over a design, from a bank: half of the places lie at the centre.

    All events of a node, whoever asked for them, stand for those that the places near it have: they cost nothing, and
    tell more. Between few nodes the mean is taken as linear, see `Bank`; over many the polynomial is that of the nodes.
    """
    bank, k, pairs = model.events, (model.dim + 1) * (model.dim + 2) // 2, max(num_events // 2, 1)
    normal, taken = np.zeros((k, k)), {}
    sums: dict[bytes, NDArray[np.float64]] = {}
    remaining = pairs
    while remaining > 0:
        n = min(remaining, model.at_once)
        u = np.concatenate([design.to_u(rng.uniform(-1, 1, (n, model.dim))), np.tile(design.centre, (n, 1))])
        terms = np.zeros((2 * n, k + 1))  # of spread places, and their number at the centre
        terms[:n, :k], terms[n:, k] = basis(design.to_t(u[:n])), 1
        normal += terms[:n, :k].T @ terms[:n, :k]
        keys, which, _ = bank.draw(model.from_cube(u), rng, taken)
        there = np.zeros((len(keys), k + 1))
        np.add.at(there, which, terms)
        for key, more in zip(keys, there, strict=True):
            sums[key] = sums.get(key, 0) + more
        remaining -= n
    theta, x, node = bank.handed(list(sums))
    size, at_nodes, one = np.bincount(node)[:, None], basis(design.to_t(model.to_cube(theta))), np.eye(k)[0]
    weights, of_nodes = np.array(list(sums.values())) / size, (at_nodes * size).T @ at_nodes
    inverse = np.linalg.pinv(normal + pairs * np.outer(one, one), rcond=1e-12, hermitian=True)
    coefficients = weights[:, :k] @ inverse + np.outer(weights[:, k], inverse[0])
    bend = weights[:, :k] @ np.linalg.pinv(normal, rcond=1e-12, hermitian=True)[0] - weights[:, k] / pairs
    if np.linalg.eigvalsh(of_nodes / len(x))[0] > FIT.spanned * np.linalg.eigvalsh(normal / pairs)[0]:
        coefficients = at_nodes @ np.linalg.inv(of_nodes)
    weights, moments = np.hstack([coefficients, bend[:, None]]), 0.0
    for at in range(0, len(x), model.at_once):
        some = slice(at, at + model.at_once)
        moments = moments + vectors.moments(x[some], weights[node[some]])
    scatter = weights.T @ (weights * size) / bank.worth
    return Surrogate(design, moments[:k], len(x), scatter[:k, :k], moments[k], float(scatter[k, k]))


def quadratic(make: Callable[[Design], Surrogate], design: Design, target: Target) -> Surrogate:
    """The surrogate over a design, or over a narrower one where that is plainly no quadratic, and this one more so."""
    s = make(design)
    for _ in range(FIT.narrower):
        if not s.bends(target):
            break
        narrower = make(Design(s.design.centre, s.design.axes / FIT.shrink))
        if narrower.lack(target)[0] > FIT.falls * s.lack(target)[0]:
            break  # it is noise, or a jump
        s = narrower
    return s


@dataclass(frozen=True)
class ReferenceModel:
    """A fitted model with a precise surrogate around it, to which an effect is to be added.

    What the effect changes is seen event by event: only those that it changes add to the noise.
    """

    model: Model
    surrogate: Surrogate

    def design(self, start: NDArray[np.float64], half: NDArray[np.float64]) -> Design:
        """A design for the larger model from `start` (P,): a box of half-widths `half` (P,), or what of it is known."""
        p, region = self.model.dim, self.surrogate.design
        if p == 0 or np.abs(region.to_t(start[:p])).max() >= 1 - FIT.first_share:
            return Design.box(start, half)
        axes = np.diag(half).astype(float)
        lengths = np.abs(region.axes / half[:p, None]).max(axis=0)
        axes[:p, :p] = region.axes * np.minimum(FIT.first_share, 1 / lengths)
        return Design(np.clip(start, 0, 1), axes)

    def within(self, design: Design) -> Design | None:
        """The design, narrowed to where this model is known; None where that leaves next to nothing."""
        p, region = self.model.dim, self.surrogate.design
        if p == 0:
            return design
        room = 1 + FIT.beyond - np.abs(region.to_t(design.centre[:p]))
        extent = np.abs(np.linalg.inv(region.axes) @ design.axes[:p]) * len(design.axes)
        factor = np.minimum((room[:, None] / np.maximum(extent, 1e-12)).min(axis=0), 1)
        return Design(design.centre, design.axes * factor) if factor.min() > FIT.least_room else None

    def extended(
        self, model: Model, vectors: Vectors, design: Design, num_events: int, rng: np.random.Generator
    ) -> Surrogate:
        """The surrogate of `model`, which is this one with one more effect; half of the events at the centre.

        An effect that changes most events is better seen without this one, from twins of one seed.
        """
        p, k = self.model.dim, (model.dim + 1) * (model.dim + 2) // 2
        normal, change, unlike = np.zeros((k, k)), 0.0, 0.0
        num_centre, change_there = 0, 0.0
        remaining, source = num_events, self.model.source()
        while remaining > 0:
            n = min(remaining, model.at_once)
            u = design.to_u(rng.uniform(-1, 1, (n, model.dim)))
            u[: n // 2] = design.centre
            b = basis(design.to_t(u))
            x, y = with_and_without(self.model, model, model.from_cube(u), rng, source)
            some = slice(None, None, max(n // FIT.compared_twins, 1))
            moved = float(vectors.moved(x[some], y[some]).mean())
            if remaining == num_events and moved > 1:
                return from_events(model, vectors, design, num_events, rng)
            unlike += n / num_events * moved
            normal += b.T @ b
            hit = (x != y).any(axis=1)
            change = change + vectors.moments(y[hit], b[hit]) - vectors.moments(x[hit], b[hit])
            there = hit[: n // 2].nonzero()[0]
            one = np.ones((len(there), 1))
            change_there = change_there + (vectors.moments(y[there], one) - vectors.moments(x[there], one))[0]
            num_centre += n // 2
            remaining -= n
        inverse = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
        # The known polynomial in the coordinates of this design, by its values at as many points as it has terms.
        t = np.random.default_rng(0).uniform(-1, 1, (2 * k, model.dim))
        there = basis(self.surrogate.design.to_t((design.centre + t @ design.axes.T)[:, :p]))
        translate = np.linalg.lstsq(basis(t), there, rcond=None)[0]
        coefficients = inverse @ change + translate @ self.surrogate.coefficients
        unlike *= repeats(source)
        noise = unlike * inverse + translate @ self.surrogate.inverse @ translate.T
        constant = np.eye(k)[0]
        alone = np.linalg.pinv(normal - num_centre * np.outer(constant, constant), rcond=1e-12, hermitian=True)
        bend = alone[0] @ (change - np.outer(constant, change_there)) - change_there / num_centre
        return Surrogate(design, coefficients, num_events, noise, bend, unlike * (alone[0, 0] + 1 / num_centre))


def repeats(source: Source) -> float:
    """How often a source handed out each event, on average."""
    return source.repeats if isinstance(source, Session) else 1.0


def with_and_without(
    before: Model, model: Model, params: NDArray[np.float64], rng: np.random.Generator, source: Source
) -> tuple[NDArray, NDArray]:
    """Events of a model `before`, and the same with one more effect: params (n, P) of the latter -> (n, d) twice.

    The same as far as the effect asks the simulator for them first, at the parameters that it was given, or, where
    others act after it, as one seed makes them the same. Both come from `source`.
    """
    p = before.dim
    theta, phi = params[:, :p], params[:, p:]
    if not model.newest_acts_last:
        seed = int(rng.integers(2**63))
        unchanged = before.simulate(theta, np.random.default_rng(seed), copy(source))
        return unchanged, model.simulate(params, np.random.default_rng(seed), source)
    first: list[NDArray] = []

    def simulate(params: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = before.simulate(params, rng, source)
        if not first and np.array_equal(params, theta):
            first.append(x.copy())
        return x

    changed = model.effects[-1].apply(simulate, theta, phi, rng)
    return (first[0] if first else before.simulate(theta, rng, source)), changed
