"""Random simulators: textbook distributions of a count, or of one to six features, that random parameters move."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.experience.recogniser import Kind
from avobench.tasks import Box, Task
from paper.grammar.functions import log_uniform

Array = NDArray[np.float64]
Rng = np.random.Generator
Sampler = Callable[[Array, Rng], Array]
"""Values (n,) from what forms their distribution, (n,) in [0, 1]."""


def _two_normals(form: Array, rng: Rng) -> Array:
    """Two normal populations, of which the form is the share of the first."""
    n = len(form)
    return np.where(rng.random(n) < 0.1 + 0.8 * form, rng.normal(-1, 0.4, n), rng.normal(1, 0.7, n))


def _peak(form: Array, rng: Rng) -> Array:
    """A peak on an even background, of which the form is the share of the peak."""
    n = len(form)
    return np.where(rng.random(n) < 0.1 + 0.7 * form, rng.normal(0.2, 0.06, n), rng.uniform(-1, 1, n))


def _window(form: Array, rng: Rng) -> Array:
    """An exponential on [0, 1], of which the form is the slope of the logarithm, from -3 to 3."""
    slope = 6 * (form - 0.5) + 1e-6
    return np.log1p(rng.random(len(form)) * np.expm1(slope)) / slope


def _polar(form: Array, rng: Rng) -> Array:
    """The cosine of an angle, of density 1 + x^2 + 8/3 a x, of which the form is a, from -0.7 to 0.7."""
    u = rng.uniform(-4, 4, len(form))
    root = np.sqrt(u**2 + 4)
    x = np.cbrt((u + root) / 2) + np.cbrt((u - root) / 2)
    return np.where(rng.random(len(u)) < 0.5 + 4 / 3 * 1.4 * (form - 0.5) * x / (1 + x**2), x, -x)


ANYWHERE, POSITIVE, BOUNDED = ("location", "scale", "form"), ("scale", "form"), ("form",)
"""What parameters may move of a distribution: one that has no zero, one above zero, and one with ends."""

REALS: dict[str, tuple[tuple[str, ...], Sampler]] = {
    "normal": (ANYWHERE[:2], lambda form, rng: rng.standard_normal(len(form))),
    "student": (ANYWHERE, lambda form, rng: rng.standard_t(3 + 20 * form)),
    "gumbel": (ANYWHERE[:2], lambda form, rng: rng.gumbel(size=len(form))),
    "two normals": (ANYWHERE, _two_normals),
    "skewed": (ANYWHERE, lambda form, rng: np.log(rng.gamma(0.5 + 5 * form))),
    "peak": (BOUNDED, _peak),
    "exponential": (POSITIVE[:1], lambda form, rng: rng.standard_exponential(len(form))),
    "gamma": (POSITIVE, lambda form, rng: rng.gamma(0.8 + 6 * form)),
    "lognormal": (POSITIVE, lambda form, rng: rng.lognormal(0, 0.15 + 0.85 * form)),
    "weibull": (POSITIVE, lambda form, rng: rng.weibull(0.9 + 3 * form)),
    "pareto": (POSITIVE, lambda form, rng: 1 + rng.pareto(2.5 + 6 * form)),
    "uniform": (POSITIVE[:1], lambda form, rng: rng.random(len(form))),
    "beta": (BOUNDED, lambda form, rng: rng.beta(0.8 + 4 * form, 4.8 - 4 * form)),
    "window": (BOUNDED, _window),
    "polar": (BOUNDED, _polar),
    "von mises": (BOUNDED, lambda form, rng: rng.vonmises(0, 0.1 + 3 * form)),
}
"""By name: what parameters may move, and values of scale 1."""

COUNTS: dict[str, tuple[bool, Callable[[Array, Array, Rng], NDArray[np.int64]]]] = {
    "poisson": (False, lambda mean, form, rng: rng.poisson(mean)),
    "geometric": (False, lambda mean, form, rng: rng.geometric(1 / (1 + mean)) - 1),
    "binomial": (
        True,
        lambda mean, form, rng: rng.binomial(np.ceil(mean / (0.2 + 0.7 * form)).astype(int), 0.2 + 0.7 * form),
    ),
    "negative binomial": (True, lambda mean, form, rng: rng.poisson(mean * rng.gamma(1 + 9 * form) / (1 + 9 * form))),
    "two rates": (True, lambda mean, form, rng: rng.poisson(mean * np.where(rng.random(len(mean)) < form, 0.5, 1.4))),
    "rounded gamma": (
        True,
        lambda mean, form, rng: np.rint(mean * rng.gamma(1 + 9 * form) / (1 + 9 * form)).astype(int),
    ),
}
"""By name: whether they have a form, and counts from their mean and form."""
MEANS = (0.5, 150)
"""Of counts, log-uniform."""
FORM = (0.1, 0.9)
"""Of a distribution whose form a parameter moves, by the prior; the support is [0, 1]."""
MOVES = {"location": 1.5, "scale": 0.6, "form": 0.4}
"""How far a parameter goes to either side by the prior: in scales, in the logarithm of a scale or mean, in the form."""
STEPPED = 0.15
"""Chance that a real number comes in steps, from a hundredth of a scale on."""


def simulator(kind: Kind, rng: Rng) -> Task:
    """A random simulator with events of this kind. Its name is that of its distributions, joined by commas."""
    return _of_count(rng) if kind == "count" else _of_reals(1 if kind == "real" else rng.integers(2, 7), rng)


def _of_count(rng: Rng) -> Task:
    name = str(rng.choice(list(COUNTS)))
    formed, drawn = COUNTS[name]
    level, form = np.log(log_uniform(*MEANS, rng)), rng.uniform(*FORM)
    both = formed and rng.random() < 0.6

    def simulate(theta: Array, rng: Rng) -> NDArray:
        forms = theta[:, 1] + 0.5 if both else np.full(len(theta), form)
        return drawn(np.exp(level + theta[:, 0]), forms, rng)[:, None]

    return task(name, ["scale", "form"] if both else ["scale"], simulate, 1, counts=True)


def _of_reals(d: int, rng: Rng) -> Task:
    """Each feature has a distribution, may depend on an earlier one if it may be anywhere, be warped, or in steps."""
    names = rng.choice(list(REALS), d)
    movable = [(what, j) for j, name in enumerate(names) for what in REALS[name][0] if name != "uniform" or d > 1]
    movable = movable or [("scale", 0)]
    moved = [movable[k] for k in rng.permutation(len(movable))[: rng.integers(1, 4)]]
    forms, unit = rng.uniform(*FORM, d), 10 ** rng.uniform(-3, 3, d)
    zero = np.where([ANYWHERE[0] in REALS[name][0] for name in names], rng.choice([0, 0, 3, 10], d), 0)
    power = np.where(rng.random(d) < 0.25, np.exp(rng.uniform(-0.7, 0.7, d)), 1)
    grain = np.where(rng.random(d) < STEPPED, np.exp(rng.uniform(np.log(0.01), np.log(0.3), d)), 0)
    source = [rng.integers(-1, j) if j and rng.random() < 0.7 else -1 for j in range(d)]
    coupling, on_scale = rng.uniform(-1.5, 1.5, d), rng.random(d) < 0.3

    def simulate(theta: Array, rng: Rng) -> NDArray:
        at = {each: theta[:, k] for k, each in enumerate(moved)}
        n, x = len(theta), np.empty((len(theta), d))
        for j, name in enumerate(names):
            here, sampler = REALS[name]
            value = sampler(forms[j] + at.get(("form", j), np.zeros(n)) * (1 - abs(2 * forms[j] - 1)), rng)
            if source[j] >= 0 and here[0] == "location":
                other = np.tanh(x[:, source[j]] / 2)
                value = value * np.exp(coupling[j] * other) if on_scale[j] else value + coupling[j] * other
            value = value * np.exp(at.get(("scale", j), 0)) + at.get(("location", j), 0) + zero[j]
            value = np.sign(value) * np.abs(value) ** power[j]
            x[:, j] = grain[j] * np.rint(value / grain[j]) if grain[j] else value
        return x * unit

    return task(",".join(names), [what for what, _ in moved], simulate, d)


def task(
    name: str, moved: list[str], simulate: Callable[[Array, Rng], NDArray], d: int, *, counts: bool = False
) -> Task:
    """A task of which only the events matter, with a parameter for each of what is `moved`."""

    class Random(Task):
        def simulate(self, theta: Array, rng: Rng) -> NDArray:
            return simulate(theta, rng)

        def summary(self, x: NDArray) -> Array:
            return x.mean(axis=0)

        def floor(self, theta: Array, num_observations: int, num_simulations: int | None) -> float:
            return 1.0

    reach = np.array([MOVES[what] for what in moved])
    Random.name, Random.num_features, Random.dtype = name, d, np.int64 if counts else np.float64
    Random.prior, Random.support = Box(tuple(-reach), tuple(reach)), Box(tuple(-1.25 * reach), tuple(1.25 * reach))
    Random.parameter_names = tuple(f"p{k}" for k in range(len(moved)))
    Random.parameter_units, Random.source = ("1",) * len(moved), "textbook distributions"
    Random.__abstractmethods__ = frozenset()
    return Random()
