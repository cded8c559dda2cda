"""Shapes of images: hits in the cells of a cylindrical detector, in rows along its axis and columns around it."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.spatial.transform import Rotation
from scipy.special import betainc, expit, gammaincc, ndtr, ndtri

from avobench.challenge.shape import Place
from shapes.primitives import Library, either, log, run_time

if TYPE_CHECKING:
    from avobench.tasks.alignment import Particles

Hits = NDArray[np.bool_]
"""Images, (n, rows, columns)."""
Chart = NDArray[np.float64]
"""A number for each cell, (rows, columns)."""

IMAGES = Library("images")

CHIP = 8
"""A readout chip has so many cells along each side, a quarter of the tracker's 32."""
BESIDE = np.array([[1, -1, 0, 0], [0, 0, 1, -1]])
"""The steps in rows and in columns to the four neighbours of a cell."""


def away(at: Place, row: float, column: float) -> tuple[Chart, Chart]:
    """How many rows (rows, 1) and columns (columns,), which are cyclic, each cell is away from that at two shares."""
    rows, columns = at.task.event_shape
    across = (np.arange(columns) - int(column * columns) + columns // 2) % columns - columns // 2
    return np.arange(rows)[:, None] - int(row * rows), across


def distance(at: Place, by: SimpleNamespace) -> Chart:
    """The distance of each cell from that at the shares `by.row` and `by.column` of the image, in cells."""
    return np.hypot(*away(at, by.row, by.column))


def scratch(at: Place, by: SimpleNamespace, angle: float, length: float) -> tuple[Hits, Chart]:
    """The cells on a straight line about that at `by.row` and `by.column`, and how far along it each one is."""
    up, across = away(at, by.row, by.column)
    along = np.cos(angle) * across + np.sin(angle) * up
    beyond = np.maximum(np.abs(along) - length / 2, 0)
    return np.hypot(np.cos(angle) * up - np.sin(angle) * across, beyond) < 0.71, along


def eta(at: Place) -> Chart:
    """The middle of each row, (rows, 1), where the ends of the detector are at -1 and 1."""
    rows = at.task.event_shape[0]
    return ((2 * np.arange(rows) + 1) / rows - 1)[:, None]


def cells(at: Place, number: float, pattern: float) -> NDArray[np.int64]:
    """Distinct random cells in a number that is rounded down, always the same for the same pattern."""
    return np.random.default_rng(int(pattern)).choice(at.task.num_features, int(number), replace=False)


def patch(at: Place, number: float, pattern: float) -> NDArray[np.int64]:
    """The first cells that a random walk over the image visits, always the same for the same pattern."""
    rng, shape = np.random.default_rng(int(pattern)), at.task.event_shape
    row, column = rng.integers(shape)
    visited = {(row, column)}
    while len(visited) < number:
        up, across = BESIDE[:, rng.integers(4)]
        row, column = np.clip(row + up, 0, shape[0] - 1), (column + across) % shape[1]
        visited.add((row, column))
    return np.array([row * shape[1] + column for row, column in sorted(visited)])


def chart(at: Place, which: NDArray[np.int64]) -> Hits:
    """The image in which these cells are set: (rows, columns)."""
    return np.isin(np.arange(at.task.num_features), which).reshape(at.task.event_shape)


def fires(x: Hits, chance: NDArray[np.float64] | float, rng: np.random.Generator) -> Hits:
    """Images like x in which each cell is hit with its chance."""
    return rng.random(x.shape, dtype=np.float32) < chance


def firing(x: Hits, which: NDArray[np.int64], chance: NDArray[np.float64], rng: np.random.Generator) -> Hits:
    """Images like x in which these k cells alone are hit, each with its chance (k,) or (n, k)."""
    hits = np.zeros_like(x)
    hits[:, *np.divmod(which, x.shape[2])] = rng.random((len(x), len(which))) < chance
    return hits


def strays(x: Hits, mean: NDArray[np.float64] | float, rng: np.random.Generator) -> NDArray[np.int64]:
    """Hits of random cells, a Poisson number in each image: their event, row and column (3, m)."""
    event = np.repeat(np.arange(len(x)), rng.poisson(mean, len(x)))
    return np.stack([event, *(rng.integers(size, size=len(event)) for size in x.shape[1:])])


def marked(x: Hits, hits: NDArray[np.int64], up: int = 0, across: int = 0) -> Hits:
    """Images like x with hits (3, m), as `strays` gives them, moved by some cells. Those beyond either end are lost."""
    event, row, column = hits[:, (hits[1] + up >= 0) & (hits[1] + up < x.shape[1])]
    images = np.zeros_like(x)
    images[event, row + up, (column + across) % x.shape[2]] = True
    return images


def number(x: Hits) -> NDArray[np.int64]:
    """The number of hits of each image, (n,)."""
    return x.sum(axis=(1, 2))


def usual(at: Place) -> float:
    """The mean number of hits of an image, at least one."""
    return max(float(at.mean.sum()), 1.0)


def load(x: Hits, at: Place) -> NDArray[np.float64]:
    """The number of hits of each image over the usual one, (n, 1, 1)."""
    return number(x)[:, None, None] / usual(at)


def per_image(x: Hits, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A value of each image, for all of its cells: (n,) -> (n, 1, 1)."""
    return values.reshape(len(x), 1, 1)


def counted(at: Place, of: Callable[[Hits], NDArray]) -> NDArray:
    """What a trigger counts in the events without the effect, (m,)."""
    return of(at.read(at.reference))


def further(n: int, mean: NDArray[np.float64] | float, rng: np.random.Generator) -> NDArray[np.int64]:
    """A Poisson number of further collisions in each of n events: the event of each, (m,)."""
    return np.repeat(np.arange(n), rng.poisson(mean, n))


def direction(turns: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """The unit vector across the beam at an azimuth, in turns: (...) -> (..., 2)."""
    return np.stack([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)], axis=-1)


def moved(particles: "Particles", across: NDArray[np.float64]) -> "Particles":
    """The particles of events that happen beside the beam axis: across (n, 2) [mm]."""
    position = particles.position.copy()
    position[:2] += np.repeat(across, np.diff(particles.offsets), axis=0).T
    return replace(particles, position=position)


def turned(
    particles: "Particles", angle: NDArray[np.float64], turns: float, vertex: NDArray[np.float64] | None = None
) -> "Particles":
    """The particles of events turned about an axis across the beam, at an azimuth in turns: angle (n,) [rad].

    The axis passes through the interaction point, or through the detector's centre if the vertex (n,) [mm] along the
    beam is given.
    """
    per_event = np.diff(particles.offsets)
    turn = Rotation.from_rotvec(np.repeat(angle, per_event)[:, None] * [*direction(turns), 0])
    shift = np.zeros_like(particles.position)
    shift[2] = 0 if vertex is None else np.repeat(vertex, per_event)
    position = turn.apply((particles.position + shift).T).T - shift
    return replace(particles, position=position, momentum=turn.apply(particles.momentum.T).T)


@IMAGES.mask("dead_cells", stage=4, strength=(2, 80), residual=(0, 0.3), pattern=(0, 2**31))
def dead_patch(at, by):
    """A patch of neighbouring cells of irregular shape answers seldom or not at all."""
    return np.where(chart(at, patch(at, round(by.strength), by.pattern)), by.residual, 1)


@IMAGES.thin("dead_cells", stage=4, strength=(0.02, 1), columns=(1, 4), first=(0, 1))
def silent_link(x, at, by, rng):
    """A readout link drops out in a share of the events, and its whole neighbouring columns then say nothing."""
    dropped = per_image(x, rng.random(len(x)) < by.strength)
    return ~(dropped & (away(at, 0, by.first)[1] % x.shape[2] < int(by.columns)))


@IMAGES.mask("dead_cells", strength=(0.5, 32), row=(0.35, 0.65), column=(0, 1), angle=(0, np.pi), fade=(0, 0.6))
def scratched_sensor(at, by):
    """A scratch or crack runs straight across the sensor, and the cells on it are dead, most of all in its middle."""
    on, along = scratch(at, by, by.angle, by.strength)
    return np.where(on, np.minimum(by.fade * np.abs(along) / max(by.strength / 2, 0.5), 1), 1)


@IMAGES.thin("dead_cells", strength=(1, 100), cold=(0.3, 1), pattern=(0, 1e6))
def cracked_bonds(x, at, by, rng):
    """Cells break here and there, most where particles are frequent, and are dead in the cold part of the run."""
    often, order = at.mean + 1e-3, np.random.default_rng(int(by.pattern))
    broken = order.choice(len(often), round(by.strength), replace=False, p=often / often.sum())
    return ~(per_image(x, run_time(len(x)) < by.cold) & chart(at, broken))


@IMAGES.mask("dead_cells", strength=(0.3, 5), row=(0.35, 0.65), column=(0, 1), stretch=(0.7, 2), edge=(0.01, 0.35))
def burnt_spot(at, by):
    """All cells of an oval patch are dead, where the beam has hit the sensor or its bonds have come off."""
    up, across = away(at, by.row, by.column)
    return expit((np.hypot(up, across / by.stretch) - by.strength) / by.edge)


@IMAGES.mask("dead_cells", strength=(0.025, 0.16), row=(0.3, 0.7), column=(0, 1), pattern=(0, 1e6))
def peeling_bonds(at, by):
    """Bonds have come off around one point, nearly all beside it and ever fewer away from it."""
    rows, columns = at.task.event_shape
    up, across = away(at, by.row, by.column)
    kept = np.random.default_rng(int(by.pattern)).random((rows, columns))
    return kept >= np.exp(-((up / rows) ** 2 + (across / columns) ** 2) / by.strength**2)


@IMAGES.mask("dead_cells", strength=(0.15, 7), column=(0, 1), upper=either(1, 1), right=either(1, 1))
def torn_corner(at, by):
    """A chip tears off from its corner at the seam of two modules, and the front of the tear has a loose contact."""
    steps = [d if side > 0 else -1 - d for d, side in zip(away(at, 0.5, by.column), (by.upper, by.right), strict=True)]
    beyond = sum(np.where(step >= 0, step, np.inf) for step in steps)
    return 1 - np.clip(by.strength - beyond, 0, 1)


@IMAGES.mask("dead_cells", strength=(0.5, 4), pattern=(0, 1e6))
def delamination(at, by):
    """Bonds tear off in a quarter circle about one corner of each chip, of a radius that differs between chips."""
    pattern, shape = np.random.default_rng(int(by.pattern)), at.task.event_shape
    row, column = np.indices(shape)
    chip = row // CHIP, column // CHIP
    chips = -(-np.array(shape) // CHIP)
    radius, corner = by.strength * pattern.lognormal(0, 0.5, chips), CHIP * pattern.integers(2, size=(2, *chips))
    return np.hypot(row % CHIP + 0.5 - corner[0][chip], column % CHIP + 0.5 - corner[1][chip]) > radius[chip]


@IMAGES.thin("dead_cells", strength=(0.001, 0.25), row=(0.3, 0.7), column=(0, 1), opposite=(0, 0.5))
def dead_board(x, at, by, rng):
    """A rectangle of cells is dead, and that on the opposite side fails with it in a share of the events."""
    side, (rows, columns) = np.sqrt(by.strength), at.task.event_shape
    near = np.abs((np.arange(rows) + 0.5) / rows - by.row)[:, None] < max(side, 1 / rows) / 2
    turn = (np.arange(columns) / columns - by.column) % 1
    fails = per_image(x, rng.random(len(x)) < by.opposite)
    return ~(near & ((turn < side) | fails & ((turn + 0.5) % 1 < side)))


@IMAGES.thin("dead_cells", strength=(0.006, 0.3), pattern=(0, 1e6))
def upset_masks(x, at, by, rng):
    """Radiation flips bits that mask cells, always the same ones, and the later an event is, the more are missing."""
    share = (cells(at, at.task.num_features, by.pattern) + 0.5) / at.task.num_features
    upset = -np.log1p(-share).reshape(at.task.event_shape) / by.strength
    return per_image(x, rng.random(len(x))) < upset


@IMAGES.add("noisy_cells", strength=(0.002, 0.3), cells=(2, 16), spread=(0.2, 1.2), pattern=(0, 2**31))
def hot_cells(x, at, by, rng):
    """A few damaged cells fire without a particle, at rates that spread over orders of magnitude."""
    leakage = np.random.default_rng(int(by.pattern)).standard_normal(int(by.cells))
    return firing(x, cells(at, by.cells, by.pattern), by.strength * np.exp(by.spread * leakage), rng)


@IMAGES.add("noisy_cells", strength=(0.002, 0.06), rate=(0.02, 0.15), pattern=(0, 1e6))
def leaky_cells(x, at, by, rng):
    """A share of the cells fires by itself, always the same ones, a few of them often and most of them seldom."""
    leaky = cells(at, max(1, by.strength * at.task.num_features), by.pattern)
    return firing(x, leaky, by.rate * 0.05 ** (np.arange(len(leaky)) / len(leaky)), rng)


@IMAGES.add("noisy_cells", strength=(0.003, 0.9), cells=(7, 13), slope=(0.5, 2.5), pattern=(0, 1e6))
def leakage_currents(x, at, by, rng):
    """Some cells leak so much current that they fire by themselves, one worst of all and the others less by rank."""
    return firing(x, cells(at, by.cells, by.pattern), by.strength / np.arange(1, int(by.cells) + 1) ** by.slope, rng)


@IMAGES.add("noisy_cells", strength=(0.003, 0.3), cells=(3, 15), together=(0.3, 0.9), pattern=(0, 2**31))
def noisy_chip(x, at, by, rng):
    """Neighbouring cells of one chip fire on their own, many of them in the same events."""
    noisy = rng.random((len(x), 1)) < by.strength
    return firing(x, patch(at, int(by.cells), by.pattern), noisy * by.together, rng)


@IMAGES.add("noisy_cells", strength=(0.0005, 0.012), cells=(3, 20), duty=(0.2, 0.7), pattern=(0, 1e6))
def blinking_cells(x, at, by, rng):
    """Some cells blink, as they fire in spells of the run alone, each at a rate of its own."""
    which = cells(at, by.cells, by.pattern)
    spells = np.repeat(rng.random((len(x) // 50 + 1, len(which))) < by.duty, 50, axis=0)[: len(x)]
    return firing(x, which, spells * by.strength / by.duty * np.linspace(0.5, 1.5, len(which)), rng)


@IMAGES.add("noisy_cells", strength=(0.01, 0.6), cells=(1, 10), stretch=log(1, 30), pattern=(0, 2**31))
def telegraph_cells(x, at, by, rng):
    """Cells on a defect that catches a charge fire in all events of a stretch, and then are quiet again."""
    which, stretch = cells(at, by.cells, by.pattern), round(by.stretch)
    fired = rng.random((len(x) // stretch + 1, len(which))) < by.strength
    return firing(x, which, np.repeat(fired, stretch, axis=0)[: len(x)], rng)


@IMAGES.add("noisy_cells", strength=(0.0006, 0.9), row=(0.05, 0.95), column=(0, 1), reach=(0.5, 2.5))
def hot_cluster(x, at, by, rng):
    """Cells around a warm or glowing spot fire without a particle, the nearer to it the more often."""
    return fires(x, by.strength * np.exp(-distance(at, by) / by.reach), rng)


@IMAGES.add("noisy_cells", strength=(0.003, 0.7), row=(0.125, 0.85), column=(0, 1))
def pinhole_light(x, at, by, rng):
    """Light enters by a pinhole, and cells below it fire less with the fourth power of the cosine of its angle."""
    far = distance(at, by)
    pulses = np.where(far < 1.8, by.strength / (1 + (far / 0.7) ** 2) ** 2, 0)
    return fires(x, -np.expm1(-pulses), rng)


@IMAGES.add("noisy_cells", strength=(0.001, 0.6), row=(0.3, 0.7), column=(0, 1), reach=(0.5, 1.5))
def discharge(x, at, by, rng):
    """Now and then there is a discharge at a defect, and cells about it fire together, the nearer the more likely."""
    far, flash = distance(at, by), per_image(x, rng.random(len(x)) < by.strength)
    return flash & fires(x, np.where(far < 4 * by.reach, np.exp(-far / by.reach), 0), rng)


@IMAGES.add("noisy_cells", strength=(0.0005, 0.1), row=(0.1, 0.9), column=(0, 1), slope=either(0.3, 1.5))
def noisy_scratch(x, at, by, rng):
    """A scratch runs across the sensor, and the cells along it draw current and fire now and then."""
    return fires(x, by.strength * scratch(at, by, np.arctan(by.slope), x.shape[2] / 4)[0], rng)


@IMAGES.mask("inefficiency", strength=(0.003, 0.3), unevenness=(0, 0.7), waves=(1, 4), oblique=(0, 2), phase=(0, 1))
def uneven_efficiency(at, by):
    """Hits are lost everywhere, in some parts of the detector more than in others, like a wave around the beam."""
    rows, columns = (np.arange(size) / size for size in at.task.event_shape)
    turns = int(by.waves) * columns + int(by.oblique) * rows[:, None] + by.phase
    return 1 - by.strength * (1 + by.unevenness * np.cos(2 * np.pi * turns))


@IMAGES.mask("inefficiency", strength=(0.02, 0.95), power=(0.5, 2))
def forward_damage(at, by):
    """Sensors close to the beam have suffered most from radiation, and miss ever more hits towards either end."""
    return 1 - by.strength * np.abs(eta(at)) ** by.power


@IMAGES.thin("inefficiency", strength=(0.008, 0.12), slant=(0.5, 2))
def sinking_bias(x, at, by, rng):
    """The bias sinks during the run, so that hits are lost ever more often, most at the ends of the detector."""
    return 1 - by.strength * per_image(x, run_time(len(x))) * (1 + by.slant * np.abs(eta(at))) / (1 + by.slant)


@IMAGES.thin("inefficiency", stage=4, strength=(0.003, 0.3), evenness=(1, 10))
def bad_timing(x, at, by, rng):
    """Hits are lost that come too late for the readout, nearly none in most events and many in a few."""
    return 1 - per_image(x, rng.beta(by.evenness * by.strength, by.evenness * (1 - by.strength), len(x)))


@IMAGES.thin("inefficiency", strength=(0.01, 0.35))
def clock_phase(x, at, by, rng):
    """Late signals are not latched, and the clock's phase, which differs between events, decides how many are late."""
    return 1 - 2 * by.strength * per_image(x, rng.random(len(x)))


@IMAGES.thin("inefficiency", strength=(0.008, 0.6))
def clock_edge(x, at, by, rng):
    """Events close to the edge of the readout clock miss a part of their hits, anything from a few to nearly all."""
    return np.minimum(per_image(x, rng.random(len(x))) / by.strength, 1)


@IMAGES.thin("inefficiency", strength=(0.005, 0.35), refills=(1, 8))
def oxygen_leak(x, at, by, rng):
    """Oxygen leaks into the gas and swallows hits, ever more of them until the gas is changed."""
    return 1 - 2 * by.strength * (per_image(x, np.arange(len(x))) / max(len(x), 1) * by.refills % 1)


@IMAGES.thin("inefficiency", strength=(0.006, 0.8))
def supply_ripple(x, at, by, rng):
    """The high voltage ripples with the mains, and hits are missed in events that come while it is low."""
    return 1 - by.strength * np.sin(np.pi * per_image(x, rng.random(len(x)))) ** 2


@IMAGES.thin("inefficiency", strength=(0.005, 0.7), weather=(0.1, 0.8))
def air_pressure(x, at, by, rng):
    """The gain of the gas changes with the weather, and exponential avalanches below the threshold are missed."""
    return np.exp(-by.strength * np.exp(by.weather * per_image(x, rng.standard_normal(len(x)))))


@IMAGES.thin("inefficiency", strength=(0.002, 0.5), power=(1, 3))
def crowded_readout(x, at, by, rng):
    """All hits share one data link, which drops a larger part of them the more there are."""
    return np.exp(-by.strength * load(x, at) ** by.power)


@IMAGES.thin("inefficiency", strength=(0.003, 0.8))
def busy_readout(x, at, by, rng):
    """Each hit keeps the readout busy for a moment, so that a larger share is missed the more hits there are."""
    return 1 / (1 + by.strength * load(x, at))


@IMAGES.thin("inefficiency", strength=(0.01, 0.8))
def busy_link(x, at, by, rng):
    """All cells of a row share one link, so that a hit is the more often lost the more others the row has."""
    return (1 - by.strength) ** np.maximum(x.sum(axis=2, keepdims=True) - 1, 0)


@IMAGES.thin("inefficiency", strength=(0.005, 0.35), size=(2, 9))
def lost_packets(x, at, by, rng):
    """Hits leave the detector in packets of neighbouring cells of a row, and some packets are lost."""
    packet = np.arange(x.shape[2]) // int(by.size)
    return (rng.random((*x.shape[:2], packet[-1] + 1)) >= by.strength)[:, :, packet]


@IMAGES.particles("inefficiency", strength=(0.03, 1), width=(0.1, 0.4))
def soft_particles(particles, theta, time, by, rng):
    """Particles of low momentum leave no hit, with an erf turn-on in momentum."""
    momentum = np.linalg.norm(particles.momentum, axis=0)
    return particles.only(rng.random(len(momentum)) < ndtr((momentum / by.strength - 1) / by.width))


@IMAGES.add("random_noise", strength=(0.02, 5), burst=(0, 1.3), pairs=(0, 0.5))
def noise_clusters(x, at, by, rng):
    """False hits appear anywhere, some of them in pairs, in a number that varies widely between events."""
    level = rng.lognormal(-(by.burst**2) / 2, by.burst, len(x))
    hits = strays(x, by.strength * level, rng)
    paired = hits[:, rng.random(hits.shape[1]) < by.pairs]
    return marked(x, hits) | marked(x, paired, across=1)


@IMAGES.add("random_noise", strength=(0.03, 50))
def light_bursts(x, at, by, rng):
    """Stray light or radio pick-up makes cells fire anywhere, hardly any in most events and many in some."""
    return marked(x, strays(x, by.strength * rng.exponential(size=len(x)), rng))


@IMAGES.add("random_noise", strength=(0.02, 3), gradient=either(0.1, 0.7))
def graded_noise(x, at, by, rng):
    """False hits appear at random places, more of them towards one end of the detector."""
    return fires(x, by.strength / at.task.num_features * (1 + by.gradient * eta(at)), rng)


@IMAGES.add("random_noise", strength=(0.004, 0.12), power=(1, 4), spill=(0, 1))
def beam_halo(x, at, by, rng):
    """Particles of the beam's halo leave extra hits, more often towards both ends of the detector."""
    where = 0.2 + np.abs(eta(at)) ** by.power
    when = 1 + by.spill * np.cos(2 * np.pi * 7 * per_image(x, run_time(len(x))))
    return fires(x, by.strength * when * where / where.sum() / x.shape[2], rng)


@IMAGES.add("random_noise", strength=(0.0015, 0.02), size=(4, 20))
def noise_bursts(x, at, by, rng):
    """Now and then the whole sensor is noisy at once, with a burst of extra hits anywhere, of any size."""
    burst = rng.standard_exponential(len(x)) * (rng.random(len(x)) < by.strength)
    return fires(x, np.minimum(by.size / at.task.num_features * per_image(x, burst), 0.5), rng)


@IMAGES.add("random_noise", strength=(0.004, 0.5), swing=(0.2, 1.2))
def warm_hall(x, at, by, rng):
    """Cells fire from thermal noise, which rises and falls exponentially with the temperature of day and night."""
    hour = rng.uniform(0, 2 * np.pi, len(x))
    return marked(x, strays(x, by.strength * usual(at) * np.exp(by.swing * np.cos(hour)), rng))


@IMAGES.add("random_noise", strength=(0.004, 3), sway=(0.05, 0.4))
def common_mode(x, at, by, rng):
    """Gaussian noise takes cells over their threshold, and the baseline of all cells moves up and down together."""
    threshold = ndtri(by.strength / at.task.num_features)
    return fires(x, ndtr(threshold + by.sway * per_image(x, rng.standard_normal(len(x)))), rng)


@IMAGES.add("random_noise", strength=(0.02, 2.5), shared=(0.1, 0.7))
def radioactivity(x, at, by, rng):
    """Traces of radioactive elements fire random cells, and often some of the four cells beside them."""
    hits = strays(x, by.strength, rng)
    images = marked(x, hits)
    for up, across in BESIDE.T:
        images |= marked(x, hits[:, rng.random(hits.shape[1]) < by.shared], up, across)
    return images


@IMAGES.add("random_noise", strength=(0.003, 3), goes_on=(0.05, 0.7))
def stray_electrons(x, at, by, rng):
    """Stray electrons or crosstalk fire random cells and go on from each to one of its neighbours, perhaps again."""
    hits = strays(x, by.strength, rng)
    trails = marked(x, hits)
    while hits.size:
        hits = hits[:, (rng.random(hits.shape[1]) < by.goes_on) & (hits[1] >= 0) & (hits[1] < x.shape[1])]
        hits[1:] += BESIDE[:, rng.integers(4, size=hits.shape[1])]
        trails |= marked(x, hits)
    return trails


@IMAGES.pile("pile_up", strength=(0.002, 0.6), spread=(0, 0.24))
def bunch_crossing(theta, at, by, rng):
    """Further collisions, Poisson in number and spread along the beam, leave their tracks in the same image."""
    event = further(len(theta), by.strength, rng)
    jitter = by.spread * at.task.prior.width * rng.standard_normal((len(event), theta.shape[1]))
    return event, theta[event] + jitter, 1


@IMAGES.pile("pile_up", stage=2, strength=(0.005, 0.5), in_time=(0.3, 0.9), bunch=(0.04, 0.2))
def out_of_time(theta, at, by, rng):
    """Collisions of other bunches, Poisson in number, leave a part of their hits in the same image."""
    event = further(len(theta), by.strength, rng)
    jitter = by.bunch * at.task.prior.width * rng.standard_normal((len(event), theta.shape[1]))
    return event, theta[event] + jitter, by.in_time


@IMAGES.pile("pile_up", strength=(0.003, 0.4), apart=(0, 0.4))
def second_collision(theta, at, by, rng):
    """In a share of the events a second collision, perhaps elsewhere along the beam, is read as the same image."""
    event = np.flatnonzero(rng.random(len(theta)) < by.strength)
    jitter = by.apart * at.task.prior.width * rng.standard_normal((len(event), theta.shape[1]))
    return event, theta[event] + jitter, 1


@IMAGES.pile("pile_up", strength=(0.005, 0.9), left=(0.4, 1))
def late_pulses(theta, at, by, rng):
    """In a share of the events a part of the cells of an earlier collision is still above threshold."""
    event = np.flatnonzero(rng.random(len(theta)) < by.strength)
    return event, theta[event], by.left


@IMAGES.pile("pile_up", strength=(0.003, 0.8))
def afterglow(theta, at, by, rng):
    """Hits of an earlier collision fade exponentially, and the time since then is exponential too."""
    left = np.exp(-rng.standard_exponential(len(theta)) / by.strength)
    event = np.flatnonzero(left > 1e-3)
    return event, theta[event], left[event]


@IMAGES.pile("pile_up", strength=(0.004, 0.5), evenness=log(0.5, 5))
def uneven_bunches(theta, at, by, rng):
    """Bunches hold unequal charges, and in the rich ones further collisions happen at once."""
    event = further(len(theta), by.strength * rng.gamma(by.evenness, 1 / by.evenness, len(theta)), rng)
    return event, theta[event], 1


@IMAGES.add("pile_up", strength=(0.004, 0.1), part=(0.4, 1))
def late_remnant(x, at, by, rng):
    """Hits of the event before are still in the buffer in some events, and a part of them is read again."""
    again = per_image(x, rng.random(len(x)) < by.strength)
    return again & np.roll(x, 1, axis=0) & fires(x, by.part, rng)


@IMAGES.overlay("pile_up", stage=4, strength=(0.005, 0.4), slip=(0, 12))
def unwound_film(x, other, at, by, rng):
    """The film was not always wound on, and two events are on one picture, beside each other as far as it slipped."""
    double = per_image(x, rng.random(len(x)) < by.strength)
    return x | double & np.roll(other, round(by.slip), axis=2)


@IMAGES.keep("threshold", strength=(0.004, 0.6), noise=(0.02, 0.5))
def summed_trigger(x, at, by, rng):
    """The readout starts when the noisy sum of all cells passes a threshold, so that images of few hits are lost."""
    usually = counted(at, number)
    return ndtr((number(x) + 0.5 - np.quantile(usually, by.strength)) / (by.noise * max(usually.std(), 1)))


@IMAGES.keep("threshold", strength=(0.01, 0.4), width=(0.05, 0.3), middle=(0.3, 0.8))
def central_trigger(x, at, by, rng):
    """The trigger looks at the middle of the detector only, and may miss an event that has few hits there."""
    within = slice(*(round((1 + side * by.middle) / 2 * x.shape[1]) for side in (-1, 1)))
    usually = counted(at, lambda images: number(images[:, within]))
    return expit((number(x[:, within]) + 0.5 - np.quantile(usually, by.strength)) / (by.width * usually.std()))


@IMAGES.keep("threshold", strength=(0.04, 0.8), fall=(0.15, 0.4))
def quiet_events_vetoed(x, at, by, rng):
    """The trigger needs many hits, each of which it may miss, so that quiet events are often not recorded."""
    return 1 - by.strength * np.exp(-((number(x) / (2 * by.fall * usual(at))) ** 2))


@IMAGES.keep("threshold", strength=(0.05, 0.9), top=(0.1, 0.35), barrel=(0.5, 0.8))
def unsettled_threshold(x, at, by, rng):
    """The least number of central hits that starts the readout was changed in steps, and was once too high."""
    within = np.abs(eta(at)[:, 0]) < by.barrel
    highest = max(np.quantile(counted(at, lambda images: number(images[:, within])), by.top), 1)
    return 1 - by.strength * np.ceil(4 * np.clip(1 - number(x[:, within]) / highest, 0, 1)) / 4


@IMAGES.keep("threshold", strength=(0.07, 0.6))
def self_triggered(x, at, by, rng):
    """The trigger sees only some cells and wants two hits among them, which images of few hits often lack."""
    share, n = min(1 / (by.strength * usual(at)), 0.9), number(x)
    return 1 - (1 - share) ** n - n * share * (1 - share) ** np.maximum(n - 1, 0)


@IMAGES.keep("threshold", strength=(0.01, 0.4), drift=(0.05, 0.25))
def drifting_level(x, at, by, rng):
    """The level that the sum of all cells must pass drifts evenly between two values, and quiet events fall below."""
    level = np.quantile(counted(at, number), by.strength)
    return np.clip((number(x) - level) / (2 * by.drift * usual(at)) + 0.5, 0, 1)


@IMAGES.keep("threshold", strength=(0.1, 1))
def analogue_sum(x, at, by, rng):
    """The sum of the hits' pulse heights, which are exponential as those of avalanches, must pass a threshold."""
    return np.where(number(x) > 0, gammaincc(np.maximum(number(x), 1), by.strength * usual(at)), 0)


@IMAGES.keep("threshold", strength=(0.003, 0.5), report=(0.8, 0.98))
def column_majority(x, at, by, rng):
    """The readout starts when enough columns report a hit, and now and then a report is missed."""
    struck = lambda images: images.any(axis=1).sum(axis=1)  # noqa: E731
    needed = max(by.report * np.quantile(counted(at, struck), by.strength), 1)
    spare = struck(x) - needed + 1
    return np.where(spare > 0, betainc(needed, np.maximum(spare, 1e-9), by.report), 0)


@IMAGES.keep("threshold", strength=(0.01, 0.6), side=(2, 6))
def sector_majority(x, at, by, rng):
    """The detector is divided into square sectors, and the readout starts only if enough of them have a hit."""

    def struck(images):
        starts = (np.arange(0, size, int(by.side)) for size in images.shape[1:])
        for axis, start in enumerate(starts, start=1):
            images = np.logical_or.reduceat(images, start, axis=axis)
        return number(images)

    return struck(x) > np.quantile(counted(at, struck), by.strength)


@IMAGES.keep("threshold", strength=(0.5, 6), sharpness=(2, 6))
def opposite_sectors(x, at, by, rng):
    """The trigger wants enough hits in both of two opposite halves of the detector."""
    halves = np.stack([number(half) for half in np.split(x, 2, axis=2)])
    return (-np.expm1(-((halves / by.strength) ** by.sharpness))).prod(axis=0)


@IMAGES.thin("threshold", stage=3, strength=(0.01, 1), pairs=(0, 0.5))
def cluster_cleaning(x, at, by, rng):
    """A hit with no other one beside it is often dropped as noise, and a hit with one neighbour sometimes."""
    near = convolve1d(convolve1d(x.astype(np.uint8), [1, 1, 1], 1, mode="constant"), [1, 1, 1], 2, mode="wrap")
    return 1 - by.strength * ((near == 1) + by.pairs * (near == 2))


@IMAGES.mask("gain", strength=(0.02, 1), line=(0.3, 0.7), along=either(1, 1), neighbour=(0, 0.5))
def weak_line(at, by):
    """The driver of one row or column has too low a gain, so that a part of the hits on it is missed."""
    off = away(at, by.line, by.line)[0 if by.along > 0 else 1]
    return np.broadcast_to(1 - by.strength * ((off == 0) + by.neighbour * (off == -1)), at.task.event_shape)


@IMAGES.mask("gain", strength=(0.05, 1), row=(0.35, 0.65), feed=(0, 1), thickness=(1, 4), power=(0.5, 1))
def ring_supply(at, by):
    """Cells of a ring are fed one after another around it, and those towards its end miss more of their hits."""
    up, across = away(at, by.row, by.feed)
    loss = by.strength * (across / len(across) % 1) ** by.power
    return np.where((up >= 0) & (up < int(by.thickness)), 1 - loss, 1)


@IMAGES.mask("gain", strength=either(0.03, 5, log=True), column=(0, 1))
def resistive_column(at, by):
    """Signals of one column fade on their way to the amplifier at one end, so that the farthest hits are lost most."""
    way = (1 + np.sign(by.strength) * eta(at)) / 2
    return np.where(away(at, 0, by.column)[1] == 0, np.exp(-abs(by.strength) * way), 1)


@IMAGES.add("gain", stage=2, strength=(0.005, 0.6), row=(0.38, 0.65))
def hot_amplifier(x, at, by, rng):
    """One row has too high a gain, and charge that spreads to the next cells of the row is taken for their hits."""
    spreads = (np.roll(x, 1, axis=2) & fires(x, by.strength, rng)) | (
        np.roll(x, -1, axis=2) & fires(x, by.strength, rng)
    )
    return spreads & (away(at, by.row, 0)[0] == 0)


@IMAGES.add("gain", stage=2, strength=(0.004, 0.7), row=(0.38, 0.65))
def shared_charge(x, at, by, rng):
    """One row has too high a gain, and charge that spills over from the rows beside it makes its cells fire too."""
    spills = (np.roll(x, 1, axis=1) & fires(x, by.strength, rng)) | (
        np.roll(x, -1, axis=1) & fires(x, by.strength, rng)
    )
    return spills & (away(at, by.row, 0)[0] == 0)


@IMAGES.thin("gain", strength=(0.01, 1.5), row=(0.38, 0.65))
def sagging_supply(x, at, by, rng):
    """One row hangs on a weak supply, and loses a larger part of its hits the more of its cells are hit."""
    others = np.maximum(x.sum(axis=2, keepdims=True) - 1, 0)
    return np.where(away(at, by.row, 0)[0] == 0, 1 / (1 + by.strength * others), 1)


@IMAGES.add("gain", strength=(0.002, 0.3), column=(0, 1), bunching=(0.2, 0.9))
def clock_feedthrough(x, at, by, rng):
    """The readout's clock couples into one column and half as much into the next, where cells fire at once."""
    coupled = per_image(x, rng.random(len(x)) >= by.bunching)
    across = away(at, 0, by.column)[1]
    return coupled & fires(x, by.strength / (1 - by.bunching) * ((across == 0) + 0.5 * (across == 1)), rng)


@IMAGES.particles("transverse_offset", strength=(0.01, 1), azimuth=(0, 1), wander=(0, 0.5))
def wandering_beam(particles, theta, time, by, rng):
    """The beams collide beside the axis of the detector, at a place that wanders from event to event."""
    wander = by.wander * rng.standard_normal((len(theta), 2))
    return moved(particles, by.strength * (direction(by.azimuth) + wander))


@IMAGES.particles("transverse_offset", strength=(0.04, 0.6), azimuth=(0, 1), power=(0.4, 2))
def drifting_beam(particles, theta, time, by, rng):
    """The beam drifts sideways in one direction, from the axis in the beginning to off it in the end."""
    return moved(particles, by.strength * time[:, None] ** by.power * direction(by.azimuth))


@IMAGES.particles("transverse_offset", strength=(0.02, 0.3), azimuth=(0, 1), turn=(0.02, 0.2), inner=(0.1, 0.6))
def two_orbits(particles, theta, time, by, rng):
    """Fills on two orbits follow each other, both off the axis on the same side and one further out."""
    second = np.floor(time * 12) % 2 > 0
    size = by.strength * np.where(second, by.inner, 1)
    return moved(particles, size[:, None] * direction(by.azimuth + by.turn * second))


@IMAGES.particles("axial_tilt", strength=(0.003, 0.3), azimuth=(0, 1), rock=(0, 1), cycles=log(5, 80))
def rocking_frame(particles, theta, time, by, rng):
    """The detector is tilted about its centre, and its frame may rock about that position."""
    tilt = by.strength * (1 + by.rock * np.sin(2 * np.pi * by.cycles * time))
    return turned(particles, tilt, by.azimuth, theta[:, 0])


@IMAGES.particles("axial_tilt", strength=(0.015, 0.25), azimuth=(0, 1), settle=(0.1, 0.6))
def settling_support(particles, theta, time, by, rng):
    """One foot of the support gives way, fast and then ever slower, and the detector leans more and more."""
    return turned(particles, by.strength * -np.expm1(-time / by.settle), by.azimuth, theta[:, 0])


@IMAGES.particles("axial_tilt", strength=(0.02, 0.5), azimuth=(0, 1), divergence=(0, 0.5))
def tilted_beams(particles, theta, time, by, rng):
    """The beams meet where they should, but at an angle to the axis of the detector, by more or less."""
    angle = by.strength * (1 + by.divergence * rng.standard_normal(len(theta)))
    return turned(particles, angle, by.azimuth)


@IMAGES.spread("spread", strength=(0.04, 0.2))
def long_bunch(theta, at, by, rng):
    """Bunches are long, and where in them two particles meet differs between events."""
    return theta + by.strength * at.task.prior.width * np.sqrt(6) * rng.triangular(-1, 0, 1, theta.shape)


@IMAGES.spread("mixture", strength=(0.03, 0.4), apart=either(0.3, 0.7))
def satellite_bunch(theta, at, by, rng):
    """A share of the collisions takes place between satellite bunches, a fixed distance away along the beam."""
    return theta + by.apart * at.task.prior.width * (rng.random(theta.shape) < by.strength)
