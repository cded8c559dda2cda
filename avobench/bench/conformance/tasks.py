"""The checks of a task. A statistical one blames a sound task with a probability below ALPHA."""

import itertools
import numbers
import pickle
from collections.abc import Iterator
from functools import cached_property, partial
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ks_2samp, norm, rankdata

from avobench.bench.conformance.promises import ALPHA, BrokenPromise, Round, expect, is_text, recordable, state_kept
from avobench.effects.ranges import ranges
from avobench.methods.contract import global_seed
from avobench.tasks import Box, Discriminator, Task
from avobench.tasks.checked import checked_events
from avobench.tasks.contract import NUM_TARGETS, Kind
from avobench.tasks.meter import Meter, metered
from avobench.tasks.missing import Recorded

NUM_ALONE = 1000
"""The number of events simulated one at a time, which cannot know of each other, at each of two theta."""
KINDS = ", ".join(get_args(Kind))
NUM_BATCHES = 5
"""The number of batches that alternate between the two theta: what is drawn once for a batch differs between them."""


def rounds(name: str, task: Task, meter: Meter) -> Iterator[Round]:
    plain, task = task, metered(task, meter)
    yield [
        ("says what it is, in a form that a record can hold", partial(recordable, "task", name, task)),
        ("names parameters, units, prior, support and features", partial(_described, task)),
    ]
    yield [
        (f"has {NUM_TARGETS} targets within its prior", partial(_targets, task)),
        ("says what its events determine of theta", partial(_identifiable, task)),
        ("simulates 1 and 1000 events of the promised shape and type", partial(_batch_sizes, task)),
    ]
    statistics = _Statistics(Recorded(task, _events(task, 1, 1)).task(task) if task.missing else task)
    yield [
        ("simulates every corner of its prior and its support", partial(_corners, task)),
        ("refuses theta outside its support", partial(_outside, plain)),
        ("leaves theta as it is", partial(_theta_unchanged, task)),
        ("repeats its events for a seed, whatever the global seeds", partial(_same_seed, task)),
        ("makes other events for another seed", partial(_other_seed, task)),
        ("leaves global state as it is", partial(_global_state, task)),
        ("makes features of the kinds that it states", partial(_kinds, task)),
        ("makes events that depend on theta", statistics.depends_on_theta),
        ("gives each row its own theta and randomness", statistics.own_theta_and_randomness),
        ("makes neighbouring rows independent", statistics.independent_rows),
        ("summarises events whatever their number and order", partial(_summary, task)),
        ("has a floor that more events do not raise", partial(_floor, task)),
        ("can be sent to a worker process", partial(_pickles, plain, meter)),
    ]
    if task.generates:
        yield [("detects what it generates, altered or not, as it simulates", partial(_generates, task))]


def _described(task: Task) -> None:
    for attribute in ("prior", "support"):
        box = getattr(task, attribute)
        expect(isinstance(box, Box), f"{attribute} must be a Box, got {box!r}")
    p = task.prior.dim
    for attribute in ("parameter_names", "parameter_units"):
        words = getattr(task, attribute)
        sound = isinstance(words, tuple) and len(words) == p and all(map(is_text, words))
        expect(sound, f"{attribute} must be {p} texts, one a parameter of the prior, got {words!r}")
    expect(len(set(task.parameter_names)) == p, f"parameter_names must differ, got {task.parameter_names}")
    expect(task.support.dim == p, f"the support has {task.support.dim} parameters, the prior {p}")
    inside = task.support.contains([task.prior.low, task.prior.high]).all()
    expect(inside, f"the support {task.support} must contain the prior {task.prior}")
    d = task.num_features
    expect(isinstance(d, numbers.Integral) and d >= 1, f"num_features must be a whole number from 1, got {d!r}")
    names, shape, axes = task.feature_names, task.event_shape, task.cyclic_axes
    expect(len(names) in (0, d) and len(set(names)) == len(names), f"feature_names must be {d} names, or none: {names}")
    expect(not shape or np.prod(shape) == d, f"event_shape {shape} does not hold {d} features")
    expect(set(axes) <= set(range(len(shape))), f"cyclic_axes {axes} are not axes of event_shape {shape}")
    kinds, units = task.feature_kinds, task.feature_units
    expect(len(kinds) in (0, d) and set(kinds) <= set(get_args(Kind)), f"feature_kinds must be {d} of {KINDS}: {kinds}")
    expect(not (kinds and shape), "feature_kinds are those of a plain list: cells of an image have none")
    expect(len(units) in (0, d) and all(map(is_text, units)), f"feature_units must be {d} texts, or none: {units}")
    expect(np.dtype(task.dtype).kind in "biuf", f"dtype must be a type of real numbers, got {task.dtype!r}")
    expect(isinstance(task.generates, str), f"generates must be a text, got {task.generates!r}")
    expect(isinstance(task.parts, tuple), f"parts must be a tuple, got {task.parts!r}")
    expect(isinstance(task.discriminator, Discriminator), f"discriminator must be one, got {task.discriminator!r}")


def _targets(task: Task) -> None:
    targets = task.targets()
    expected = (NUM_TARGETS, task.prior.dim)
    expect(np.shape(targets) == expected, f"targets have shape {np.shape(targets)}, not {expected}")
    expect(bool(task.prior.contains(targets).all()), "a target lies outside the prior")
    expect(np.array_equal(targets, task.targets()), "targets are not the same when asked for again")


def _batch_sizes(task: Task) -> None:
    rng = np.random.default_rng(0)
    for n in (1, 1000):
        checked_events(task, task.prior.sample(n, rng), rng)


def _kinds(task: Task) -> None:
    """Check events over the prior: what is no count would end a diagnosis in an effect that takes it for one."""
    if task.event_shape:
        return
    x = task.simulate(task.prior.sample(1000, np.random.default_rng(0)), np.random.default_rng(1))
    for name, kind, span, values in zip(task.labels, task.kinds_of_features, ranges(task), x.T, strict=True):
        if kind == "count":
            wrong = values[(values < 0) | (values != np.rint(values))]
            expect(len(wrong) == 0, f"{name} is a count and was {wrong[:1]}; of another kind feature_kinds tells")
        else:
            expect(x.dtype.kind == "f", f"{name} is {kind}, so that the events must be of a type of real numbers")
        if kind == "angle":
            wrong = values[(values < span.low) | (values > span.high)]
            expect(len(wrong) == 0, f"{name} is an angle from {span.low:.4g} to {span.high:.4g} and was {wrong[:1]}")


def _identifiable(task: Task) -> None:
    p, theta = task.prior.dim, task.prior.sample(10, np.random.default_rng(0))
    values, scale = task.identifiable(theta), np.asarray(task.identifiable_scale)
    sound = isinstance(values, np.ndarray) and values.ndim == 2 and len(values) == 10 and 1 <= values.shape[1] <= p
    expect(sound, f"identifiable must make an array (10, k) of theta (10, {p}), k from 1 to {p}, got {values!r:.200}")
    itself = values.shape[1] < p or np.array_equal(values, theta)
    expect(itself, "identifiable must return theta itself where it returns as many numbers as theta has")
    sound = scale.shape == values.shape[1:] and bool((scale > 0).all())
    expect(sound, f"identifiable_scale must be {values.shape[1]} positive numbers, got {scale!r}")
    alone = np.concatenate([task.identifiable(row[None]) for row in theta])
    expect(np.allclose(values, alone), "identifiable gives a row another value where other rows are beside it")


def _generates(task: Task) -> None:
    theta, calls = task.prior.sample(30, np.random.default_rng(0)), []

    def alter(generated: Any, rows: slice) -> Any:
        calls.append((len(generated), rows))
        return generated

    simulated = task.simulate(theta, np.random.default_rng(1))
    altered = task.simulate(theta, np.random.default_rng(1), alter)
    expect(np.array_equal(simulated, altered), "events are others where `alter` changes nothing")
    sound = sum(n for n, _ in calls) == 30 and all(rows.stop - rows.start == n for n, rows in calls)
    expect(sound, f"`alter` is given {[n for n, _ in calls]} generated events for rows {[rows for _, rows in calls]}")
    pieces = list(task.generate(30, np.random.default_rng(1)))
    starts = np.cumsum([0, *(len(piece) for piece in pieces)])
    expect(starts[-1] == 30, f"generate made {starts[-1]} events where 30 were asked for")
    whole, parts = [], []
    for piece, start in zip(pieces, starts, strict=False):
        at, half = theta[start : start + len(piece)], len(piece) // 2
        whole.append(task.detect(piece, at))
        parts += [task.detect(piece.events(0, half), at[:half]), task.detect(piece.events(half, len(piece)), at[half:])]
    expect(np.array_equal(np.concatenate(whole), simulated), "detecting what was generated makes other events")
    expect(np.array_equal(np.concatenate(parts), simulated), "a part of what was generated is detected otherwise")


def _corners(task: Task) -> None:
    rng = np.random.default_rng(0)
    for box in (task.prior, task.support):
        for corner in itertools.islice(itertools.product(*zip(box.low, box.high, strict=True)), 64):
            checked_events(task, np.tile(corner, (10, 1)), rng)


def _outside(task: Task) -> None:
    for theta in (task.support.low - 0.01 * task.support.width, task.support.high + 0.01 * task.support.width):
        try:
            task.simulate(theta[None], np.random.default_rng(0))
        except ValueError:
            continue
        raise BrokenPromise(f"made an event at theta = {theta.tolist()}, where ValueError is due")


def _theta_unchanged(task: Task) -> None:
    theta = task.prior.sample(100, np.random.default_rng(0))
    before = theta.copy()
    task.simulate(theta, np.random.default_rng(0))
    expect(np.array_equal(theta, before), "simulate changed the array of parameters that it was given")


def _events(task: Task, seed: int, elsewhere: int) -> NDArray:
    """1000 events across the prior, with another seed of every global generator."""
    with global_seed(np.random.default_rng(elsewhere)):
        return task.simulate(task.prior.sample(1000, np.random.default_rng(0)), np.random.default_rng(seed))


def _same_seed(task: Task) -> None:
    events = _events(task, 1, 1)
    again, elsewhere = (np.array_equal(events, _events(task, 1, seed), equal_nan=True) for seed in (1, 2))
    expect(again, "two generators of one seed give different events")
    expect(elsewhere, "the events depend on the seed of a global generator")


def _other_seed(task: Task) -> None:
    same = np.array_equal(_events(task, 1, 1), _events(task, 2, 2), equal_nan=True)
    expect(not same, "generators of different seeds give the same events: is the generator ignored?")


def _global_state(task: Task) -> None:
    with state_kept(by="simulate or summary"):
        task.summary(task.simulate(task.prior.sample(1000, np.random.default_rng(0)), np.random.default_rng(1)))


def _p_value(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Kolmogorov and Smirnov's, least over the features, times their number (Bonferroni): (n, d), (m, d) -> number."""
    return float(ks_2samp(a, b, method="asymp").pvalue.min() * a.shape[1])


class _Statistics:
    """Checks of the distribution of events, at two theta where it differs clearly."""

    def __init__(self, task: Task) -> None:
        self._task = task

    def depends_on_theta(self) -> None:
        rng = np.random.default_rng(1)
        first, second = (self._features(self._simulate(theta, 1000, rng)) for theta in self._theta)
        expect(_p_value(first, second) < 1e-3, "1000 events at each of eight theta in the prior look alike")

    def own_theta_and_randomness(self) -> None:
        """Compares batches that alternate between two theta with events that were made one a call."""
        rng = np.random.default_rng(2)
        size = NUM_ALONE // NUM_BATCHES
        batches = [self._task.simulate(np.tile(self._theta, (size, 1)), rng) for _ in range(NUM_BATCHES)]
        for row, theta in enumerate(self._theta):
            alone = self._features(np.concatenate([self._simulate(theta, 1, rng) for _ in range(NUM_ALONE)]))
            mixed = [self._features(x[row::2]) for x in batches]
            # All together show a wrong theta, each by itself a random number that all of its rows share.
            p = min(_p_value(x, alone) for x in (np.concatenate(mixed), *mixed))
            expect(
                p * 2 * (NUM_BATCHES + 1) > ALPHA,
                f"at theta = {theta.tolist()}, events of a batch that mixes two theta are not distributed as events "
                "made one a call: does a row use the theta of another, or a random number drawn once for the batch?",
            )

    def independent_rows(self) -> None:
        n = 2000
        ranks = rankdata(self._features(self._simulate(self._theta[0], n, np.random.default_rng(3))), axis=0)
        # A feature that is nearly always the same has too few exceptions for its correlation to be Gaussian.
        ranks = ranks[:, ranks.var(axis=0) > n**2 / 12 / 4]
        z = (ranks - ranks.mean(axis=0)) / ranks.std(axis=0)
        for lag in (1, n // 2):
            correlation = (z[lag:] * z[:-lag]).mean(axis=0)
            p = 2 * norm.sf(np.abs(correlation) * np.sqrt(n - lag)) * 2 * z.shape[1]
            expect(bool((p > ALPHA).all()), f"rows i and i + {lag} of a batch of {n} are correlated")

    def _simulate(self, theta: NDArray[np.float64], n: int, rng: np.random.Generator) -> NDArray:
        return self._task.simulate(np.tile(theta, (n, 1)), rng)

    @property
    def _theta(self) -> NDArray[np.float64]:
        """The two theta: (2, p)."""
        return self._contrast[0]

    def _features(self, x: NDArray) -> NDArray[np.float64]:
        """The features, and last the combination of them and their squares that tells the two theta apart.

        Where events are images, it sees what no single pixel shows. (n, d) -> (n, d + 1).
        """
        _, center, direction = self._contrast
        return np.column_stack([x, _moments(x, center) @ direction])

    @cached_property
    def _contrast(self) -> tuple[NDArray[np.float64], ...]:
        """The two of eight theta in the prior whose first and second moments differ most.

        With them (2, p), the mean event (d,) and the direction (2 d,) in the space of moments in which they differ.
        """
        prior, rng = self._task.prior, np.random.default_rng(0)
        theta = np.vstack([prior.low, prior.center, prior.high, self._task.targets()[:5]])
        x = np.stack([self._simulate(candidate, 500, rng) for candidate in theta])
        center = x.mean(axis=(0, 1))
        moments = _moments(x, center)
        mean, variance = moments.mean(axis=1), moments.var(axis=1).mean(axis=0)
        gap = mean[:, None] - mean
        direction = np.divide(gap, variance, out=np.zeros_like(gap), where=variance > 0)
        pair = np.unravel_index((gap * direction).sum(axis=-1).argmax(), gap.shape[:2])
        return theta[list(pair)], center, direction[pair]


def _moments(x: NDArray, center: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., d) -> (..., 2 d)."""
    return np.concatenate([x - center, (x - center) ** 2], axis=-1)


def _summary(task: Task) -> None:
    rng = np.random.default_rng(0)
    x = task.simulate(np.tile(task.prior.center, (1000, 1)), rng)
    x.setflags(write=False)
    summary = task.summary(x)
    sound = isinstance(summary, np.ndarray) and summary.ndim == 1 and summary.size and summary.dtype.kind == "f"
    expect(bool(sound), f"a summary must be an array (k,) of floats, got {summary!r:.200}")
    for some in (x, x[:128], x[:10]):
        values = np.asarray(task.summary(some))
        same = values.shape == summary.shape
        expect(same, f"{len(some)} events have a summary {values.shape}, {len(x)} have {summary.shape}")
        expect(bool(np.isfinite(values).all()), f"the summary of {len(some)} events is not finite")
    permuted = task.summary(rng.permutation(x))
    expect(np.allclose(summary, permuted, rtol=1e-6, atol=1e-9), "the summary depends on the order of the events")


def _floor(task: Task) -> None:
    shares = task.floor_shares
    sound = len(shares) in (0, task.prior.dim) and (not shares or (min(shares) >= 0 and np.isclose(sum(shares), 1)))
    expect(bool(sound), f"floor_shares must be one a parameter and sum to 1, or none, got {shares}")
    for theta in task.targets():
        few = task.floor(theta, 1000, 1000)
        more = {
            "more observations": task.floor(theta, 100_000, 1000),
            "more simulations": task.floor(theta, 1000, 100_000),
            "the likelihood": task.floor(theta, 1000, None),
        }
        for floor in (few, *more.values()):
            sound = isinstance(floor, numbers.Real) and not np.isinf(floor) and not floor <= 0
            expect(sound, f"the floor at theta = {theta.tolist()} must be a positive number, or NaN, got {floor!r}")
        for what, floor in more.items():
            expect(
                not floor > few * (1 + 1e-9),
                f"at theta = {theta.tolist()}, {what} raised the floor from {few:g} to {floor:g}",
            )


def _pickles(task: Task, meter: Meter) -> None:
    events = _events(metered(task, meter), 1, 1)  # first, so that what it keeps of them is pickled too
    copy = metered(pickle.loads(pickle.dumps(task)), meter)
    same = np.array_equal(events, _events(copy, 1, 1), equal_nan=True)
    expect(same, "a pickled copy makes other events from the same seed")
