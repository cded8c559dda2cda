"""The checks of an effect, on every task of ours where it applies. A sound one is blamed with a chance below ALPHA."""

import pickle
from collections.abc import Iterator
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2_contingency

from avobench.bench.conformance.promises import ALPHA, Round, expect, is_text, state_kept
from avobench.bench.plugins import registry
from avobench.effects.catalogue import of_domain
from avobench.effects.contract import Effect, Parameter
from avobench.effects.site import Site
from avobench.methods.contract import global_seed
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

NUM_EVENTS = 4000
"""The events of a statistical check: a tenth of the events too many in one bin of ten is then seen."""
TASKS = {"counts": ("poisson",), "continuous": ("carl", "avobench.tasks.decays:DECAYS"), "images": ("alignment",)}
"""Tasks for each domain of the catalogue: the first for all, another for effects that do not apply to that."""


def subjects(name: str) -> list[tuple[Task, Effect]]:
    """The effect `name` on a task of ours of each domain, its first entry in the catalogue; of a family each class.

    A user's effect is tried on all tasks on which it runs, without those whose events it makes into others if there are
    more. Raises UsageError if there is no such effect.
    """
    candidates = []
    families = [] if ":" in name else registry.effect_families(name)
    for kind, specs in TASKS.items():
        tasks = [registry.build("task", spec, {}) for spec in specs]
        if ":" in name:
            effect = registry.effect(name)
            candidates.append((tasks[0], effect, _made(tasks[0], effect)))
            continue
        for family in (family for family in of_domain(kind) if family in families):
            entries = ((task, entry) for task in tasks for entry in family.entries(Site(task)))
            candidates += [(task, entry, np.dtype(task.dtype)) for task, entry in islice(entries, 1)]
    candidates = [(task, effect) for task, effect, made in candidates if made == np.dtype(task.dtype)] or [
        (task, effect) for task, effect, made in candidates if made is not None
    ]
    if not candidates:
        raise UsageError(f"effect '{name}' runs on no task of ours")
    return candidates


def _made(task: Task, effect: Effect) -> np.dtype | None:
    """The type of the events that a user's effect makes of those of the task at its null value; None for no events."""
    try:
        x = effect.apply(task.simulate, _thetas(task, 10), _phi(effect, 10, null=True), np.random.default_rng(0))
    except Exception:  # whatever it raises says that it is for other events
        return None
    return x.dtype if isinstance(x, np.ndarray) and x.shape == (10, task.num_features) else None


def rounds(name: str, pairs: list[tuple[Task, Effect]]) -> Iterator[Round]:
    yield [(f"says what it is ({task.name})", partial(_described, effect)) for task, effect in pairs]
    trials = [(f"{task.name}{', ' + s.shape if s.shape else ''}", task, s) for task, e in pairs for s in e.shapes()]
    yield [
        *((f"makes events within its bounds ({on})", partial(_bounds, task, effect)) for on, task, effect in trials),
        *((f"changes nothing at its null value ({on})", partial(_null, task, effect)) for on, task, effect in trials),
        *((f"gives each row its own parameters ({on})", partial(_rows, task, effect)) for on, task, effect in trials),
        *((f"draws from its generator only ({on})", partial(_seeds, task, effect)) for on, task, effect in trials),
        *((f"can be sent to a worker process ({on})", partial(_pickles, effect)) for on, task, effect in trials),
    ]


def _described(effect: Effect) -> None:
    for attribute in ("name", "sentence", "source"):
        expect(is_text(getattr(effect, attribute)), f"{attribute} must be text, got {getattr(effect, attribute)!r}")
    for shape in effect.shapes():
        expect(shape.stage in range(6), f"the stage must be a whole number from 0 to 5, got {shape.stage!r}")
        expect(shape.key == effect.key, f"the shape {shape.shape} has another name or feature: {shape.key}")
        p = shape.parameters
        expect(isinstance(p, tuple) and len(p) > 0 and all(isinstance(q, Parameter) for q in p), "parameters: no tuple")
        expect(p[0].null is not None, f"the strength {p[0].name} has no null value")


def _thetas(task: Task, n: int) -> NDArray[np.float64]:
    return np.tile(task.prior.center + 0.25 * task.prior.width, (n, 1))


def _phi(effect: Effect, n: int, *, null: bool = False) -> NDArray[np.float64]:
    """Parameters spread over all bounds, the corners first: (n, q)."""
    low, high = np.array([[p.low, p.high] for p in effect.parameters]).T
    phi = np.random.default_rng(1).uniform(low, high, (n, len(low)))
    phi[0], phi[1 % n] = low, high
    if null and effect.parameters[0].null is not None:  # a strength without one is blamed for that
        phi[:, 0] = effect.parameters[0].null
    return phi


def _events(task: Task, effect: Effect, theta: NDArray, phi: NDArray, seed: int) -> NDArray:
    x = effect.apply(task.simulate, theta, phi, np.random.default_rng(seed))
    expected = (len(theta), task.num_features)
    got = f"shape {x.shape}" if isinstance(x, np.ndarray) else type(x).__name__
    expect(isinstance(x, np.ndarray) and x.shape == expected, f"returned {got} where an array {expected} was due")
    expect(x.dtype == np.dtype(task.dtype), f"returned {x.dtype} where {np.dtype(task.dtype)} was due")
    expect(bool(np.isfinite(x).all()), "returned NaN or infinity")
    return x


def _bounds(task: Task, effect: Effect) -> None:
    theta, phi = _thetas(task, 300), _phi(effect, 300)
    before = theta.copy(), phi.copy()
    _events(task, effect, theta, phi, 0)
    expect(np.array_equal(theta, before[0]) and np.array_equal(phi, before[1]), "changes the parameters it is given")


def _same(x: NDArray, y: NDArray) -> float:
    """A p-value for two sets of events to come from one distribution, by bins of their features."""
    least = 1.0
    features = [(x > 0).sum(axis=1), x.sum(axis=1)] if x.shape[1] > 20 else x.T
    others = [(y > 0).sum(axis=1), y.sum(axis=1)] if y.shape[1] > 20 else y.T
    for a, b in zip(features, others, strict=True):
        edges = np.unique(np.quantile(a, np.linspace(0, 1, 12)[1:-1]))
        counts = np.stack([np.bincount(np.searchsorted(edges, v), minlength=len(edges) + 1) for v in (a, b)])
        counts = counts[:, counts.sum(axis=0) > 10]
        if counts.shape[1] > 1:
            least = min(least, chi2_contingency(counts).pvalue * len(features))
    return least


def _null(task: Task, effect: Effect) -> None:
    n = NUM_EVENTS // 4 if task.event_shape else NUM_EVENTS
    theta = _thetas(task, n)
    with_null = _events(task, effect, theta, _phi(effect, n, null=True), 0)
    p = _same(with_null, task.simulate(theta, np.random.default_rng(1)))
    expect(p > ALPHA, f"its events at the null value differ from the simulator's (p = {p:.1g})")


def _rows(task: Task, effect: Effect) -> None:
    """Rows at the null value must not feel that other rows are not."""
    n = NUM_EVENTS // 4 if task.event_shape else NUM_EVENTS
    theta, phi = _thetas(task, n), _phi(effect, n)
    for first in (0, 1):
        quiet, mixed = np.arange(n) % 2 == first, phi.copy()
        mixed[quiet, 0] = effect.parameters[0].null
        x = _events(task, effect, theta, mixed, 2)
        p = _same(x[quiet], task.simulate(theta[quiet], np.random.default_rng(3)))
        expect(p > ALPHA, f"rows at the null value change when others are not (p = {p:.1g})")


def _seeds(task: Task, effect: Effect) -> None:
    theta, phi = _thetas(task, 200), _phi(effect, 200)
    with state_kept("apply"):
        first = _events(task, effect, theta, phi, 4)
    with global_seed(np.random.default_rng(5)):
        again = _events(task, effect, theta, phi, 4)
    expect(np.array_equal(first, again), "does not repeat its events for a seed")
    expect(not np.array_equal(first, _events(task, effect, theta, phi, 6)), "makes the same events for another seed")


def _pickles(effect: Effect) -> None:
    expect(pickle.loads(pickle.dumps(effect)).key == effect.key, "is another effect after pickling")
