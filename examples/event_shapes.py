"""Event shapes and particle spectra of e+e- events, from the particles that are given, such as the charged ones.

Definitions: ALEPH, Phys. Rept. 294 (1998) 1. Everything is computed for many events of one multiplicity k at once, from
momenta (g, k, 3) and energies (g, k) in GeV.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

AT_ONCE = 2_000_000
"""Numbers in the largest array, which bounds memory: (events, pairs of particles, particles)."""

Array = NDArray[np.float64]


def thrust(p: Array) -> tuple[Array, Array]:
    """Thrust (g,), max_n sum |p n| / sum |p|, and its axis (g, 3).

    Exact: sum |p n| is largest where n is along the sum of the momenta with the signs that one plane through two of
    them gives to the others (Yamamoto, Z. Phys. C 18, 1983).
    """
    i, j = np.triu_indices(p.shape[1], 1)
    normal = np.cross(p[:, i], p[:, j])
    height = normal @ p.transpose(0, 2, 1)
    size = np.linalg.norm(normal, axis=2)[:, :, None] * np.linalg.norm(p, axis=2)[:, None]
    within = np.abs(height) <= 1e-9 * size  # of several particles in one plane it is a line in it that takes sides
    side = np.where(within, np.cross(normal, p[:, i]) @ p.transpose(0, 2, 1), height)
    side = np.sign(side)
    pairs = np.arange(len(i))
    side[:, pairs, i] = side[:, pairs, j] = 0
    others = side @ p
    best = longest(np.concatenate([others + a * p[:, i] + p[:, j] * b for a in (1, -1) for b in (1, -1)], axis=1))
    length, axis = summed(p, best)
    return length / np.linalg.norm(p, axis=2).sum(axis=1), axis


def thrust_major(p: Array, axis: Array) -> tuple[Array, Array]:
    """The largest sum |p n| / sum |p| (g,) of the n at a right angle to the thrust axis (g, 3), and that n (g, 3)."""
    across = p - (p @ axis[:, :, None]) * axis[:, None]
    side = np.sign(np.cross(axis[:, None], across) @ across.transpose(0, 2, 1))
    each = np.arange(p.shape[1])
    side[:, each, each] = 0
    others = side @ across
    length, n = summed(across, longest(np.concatenate([others + across, others - across], axis=1)))
    return length / np.linalg.norm(p, axis=2).sum(axis=1), n


def longest(vectors: Array) -> Array:
    """The longest of the vectors (g, c, 3) of each event: (g, 3)."""
    return vectors[np.arange(len(vectors)), (vectors**2).sum(axis=2).argmax(axis=1)]


def summed(p: Array, start: Array) -> tuple[Array, Array]:
    """sum |p n| (g,) and the axis n (g, 3), along the sum of p with signs as seen from the start (g, 3)."""
    for _ in range(2):  # gives a sign to those that lay in the plane, such as all of an event along one line
        start = (np.sign(p @ start[:, :, None]) * p).sum(axis=1)
    length = np.linalg.norm(start, axis=1)
    axis = np.where(length[:, None] > 0, start, [1.0, 0, 0])  # where nothing lies across the thrust axis any does
    return length, axis / np.linalg.norm(axis, axis=1)[:, None]


def momentum_tensor(p: Array, power: int) -> tuple[Array, Array]:
    """Eigenvalues (g, 3), the largest first, of sum |p|^(power - 2) p p / sum |p|^power; axes (g, 3, 3), in columns.

    A power of 2 is the tensor of sphericity and aplanarity, 1 the linear one of the C parameter.
    """
    size = np.linalg.norm(p, axis=2)
    tensor = np.einsum("gk,gki,gkj->gij", size ** (power - 2), p, p) / (size**power).sum(axis=1)[:, None, None]
    values, axes = np.linalg.eigh(tensor)
    return values[:, ::-1], axes[:, :, ::-1]


def heavy_jet_mass(p: Array, energy: Array, axis: Array) -> Array:
    """The larger squared mass of the two hemispheres of the thrust axis, over the squared visible energy: (g,)."""
    ahead = (p @ axis[:, :, None])[:, :, 0] > 0
    masses = [
        np.where(h, energy, 0).sum(axis=1) ** 2 - (np.where(h[:, :, None], p, 0).sum(axis=1) ** 2).sum(axis=1)
        for h in (ahead, ~ahead)
    ]
    return np.maximum(*masses) / energy.sum(axis=1) ** 2


def durham_y3(p: Array, energy: Array) -> Array:
    """The resolution at which three jets become two, by the Durham algorithm in the E scheme: (g,). 0 of two particles.

    y = 2 min(E_i^2, E_j^2) (1 - cos) / E_visible^2 (Catani et al., Phys. Lett. B 269, 1991).
    """
    g, k, _ = p.shape
    p, e, rows = p.copy(), energy.copy(), np.arange(g)
    size = np.linalg.norm(p, axis=2)
    cosine = p @ p.transpose(0, 2, 1) / (size[:, :, None] * size[:, None])
    y = 2 * np.minimum(e[:, :, None], e[:, None]) ** 2 * (1 - cosine)
    y[:, np.arange(k), np.arange(k)] = np.inf
    highest = np.zeros(g)
    for _ in range(k - 2):
        closest = y.reshape(g, -1).argmin(axis=1)
        i, j = np.divmod(closest, k)
        highest = np.maximum(highest, y[rows, i, j])
        p[rows, i] += p[rows, j]
        e[rows, i] += e[rows, j]
        gone = np.isinf(y[rows, i])  # itself, and those that were joined before
        gone[rows, j] = True
        size[rows, i] = np.linalg.norm(p[rows, i], axis=1)
        cosine_i = np.einsum("gkx,gx->gk", p, p[rows, i]) / (size * size[rows, i][:, None])
        new = np.where(gone, np.inf, 2 * np.minimum(e, e[rows, i][:, None]) ** 2 * (1 - cosine_i))
        y[rows, i], y[rows, :, i] = new, new
        y[rows, j] = y[rows, :, j] = np.inf
    return highest / energy.sum(axis=1) ** 2


def rapidity(p: Array, energy: Array, axis: Array) -> Array:
    """Rapidity along an axis (g, 3), absolute, each particle with the energy (g, k) that its own mass gives: (g, k)."""
    return np.arctanh(np.abs(p @ axis[:, :, None])[:, :, 0] / energy)


def observables(p: Array, mass: Array, beam: float) -> dict[str, Array]:
    """Everything that the tables are of, for events of one multiplicity: p (g, k, 3), mass (g, k), beam momentum [GeV].

    One number per event (g,), or one per particle (g, k).
    """
    size = np.linalg.norm(p, axis=2)
    energy = np.sqrt(size**2 + mass**2)
    t, axis = thrust(p)
    major, second = thrust_major(p, axis)
    minor = np.abs(p @ np.cross(axis, second)[:, :, None])[:, :, 0].sum(axis=1) / size.sum(axis=1)
    quadratic, axes = momentum_tensor(p, 2)
    linear, _ = momentum_tensor(p, 1)
    with np.errstate(divide="ignore"):  # two particles are no three jets, and -ln 0 is infinite: in no bin
        resolution, along = -np.log(durham_y3(p, energy)), rapidity(p, energy, axis)
    return {
        "sphericity": 1.5 * (quadratic[:, 1] + quadratic[:, 2]),
        "aplanarity": 1.5 * quadratic[:, 2],
        "one_minus_thrust": 1 - t,
        "thrust_minor": minor,
        "oblateness": major - minor,
        "two_jet_resolution": resolution,
        "heavy_jet_mass": heavy_jet_mass(p, energy, axis),
        "c_parameter": 3 * (linear[:, 0] * linear[:, 1] + linear[:, 1] * linear[:, 2] + linear[:, 2] * linear[:, 0]),
        "scaled_momentum": size / beam,
        "log_scaled_momentum": -np.log(size / beam),
        "rapidity_thrust": along,
        "pt_in": np.abs(p @ axes[:, :, 1, None])[:, :, 0],
        "pt_out": np.abs(p @ axes[:, :, 2, None])[:, :, 0],
    }


def reduced(
    count: NDArray[np.integer], momentum: NDArray, mass: NDArray, beam: float, of: Callable = observables
) -> dict[str, Array]:
    """The same for events of any multiplicity from two on: count (n,), momentum (m, 3), mass (m,), event after event.

    One number per event (n,), or one per particle (m,), in the order of the events.
    """
    starts, found = np.concatenate([[0], np.cumsum(count)])[:-1], {}
    for k in np.unique(count):
        rows = np.flatnonzero(count == k)
        for some in np.array_split(rows, -(-len(rows) * k**3 // AT_ONCE)):
            where = starts[some][:, None] + np.arange(k)
            for name, value in of(momentum[where].astype(float), mass[where].astype(float), beam).items():
                place, length = (some, len(count)) if value.ndim == 1 else (where, len(mass))
                found.setdefault(name, np.empty(length))[place] = value
    return found
