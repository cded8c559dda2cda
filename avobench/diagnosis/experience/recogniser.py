"""Which family measured events look like, told by networks that were trained on random examples of all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, softmax

from avobench.diagnosis.settings import RECOGNITION as R
from avobench.effects import Effect
from avobench.tasks import Task


def portrait(x: NDArray, simulated: NDArray, counts: bool) -> NDArray[np.float64]:
    """What is to be seen of measured events x (n, d) beside simulated ones (m, d): (f,), the same f for any d > 1.

    Of one feature all its marks; of several those of the one that differs most, the mean of all, and how they go
    together.
    """
    rng = np.random.default_rng(0)
    each = [_feature(x[:, j], simulated[:, j], counts, rng) for j in range(x.shape[1])]
    if len(each) == 1:
        return each[0][0]
    marks, by = np.array([marks for marks, _ in each]), np.array([by for _, by in each])
    first, second = np.argsort(-by)[:2]
    strangeness = np.log1p(np.maximum([by[first], by[second], by.min()], 0))
    mean = np.log1p(np.maximum(by, 0)).mean()
    return np.r_[marks[first], marks.mean(axis=0), strangeness, mean, _together(x, simulated, rng)]


def _feature(
    x: NDArray, simulated: NDArray, counts: bool, rng: np.random.Generator
) -> tuple[NDArray[np.float64], float]:
    """Marks of one feature (n,) beside the simulated one (m,), and how strange its bins are."""
    n, m = len(x), len(simulated)
    x, simulated = x.astype(float), simulated.astype(float)
    at = _place(x, simulated, rng)
    pulls, ratios = _compared(np.histogram(at, R.bin_shares)[0], n * np.diff(R.bin_shares), n / m)
    low, high = np.quantile(simulated, [0.001, 0.999])
    high = max(high, low + 1e-9)
    step = (high - low) / 40
    middle = np.linspace(low, high, R.equal_bins + 1)
    edges = np.r_[-np.inf, low - 3 * step, low - step, middle, high + step, high + 3 * step, np.inf]
    expected = np.histogram(simulated, edges)[0] * n / m
    equal, equal_ratios = _compared(np.histogram(x, edges)[0], expected, n / m)
    mean, std = simulated.mean(), simulated.std() or 1.0
    z, usual = (x - mean) / std, (simulated - mean) / std
    near = np.clip(z, -R.most_deviation, R.most_deviation)
    moments = [
        near.mean(),
        np.log(near.std() + 1e-3),
        np.clip((near**3).mean(), -50, 50),
        np.log1p((near**4).mean()),
        np.clip((usual**3).mean(), -50, 50),
        np.log1p((usual**4).mean()),
        np.clip(mean / std, -R.most_deviation, R.most_deviation),
    ]
    quantiles = np.clip(
        np.quantile(z, R.quantiles) - np.quantile(usual, R.quantiles), -R.most_deviation, R.most_deviation
    )
    kind_marks = _of_counts(x, simulated, rng) if counts else _of_reals(x, simulated, at, (low, high))
    marks = np.r_[pulls, ratios, equal, equal_ratios, moments, quantiles, np.log(n), kind_marks]
    return np.nan_to_num(marks, posinf=50, neginf=-50), _excess(pulls) + _excess(equal)


def _of_counts(x: NDArray[np.float64], simulated: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Marks that counts alone have: zeros, remainders of division, values that stand out beside their neighbours."""
    n, m = len(x), len(simulated)
    mean, std = simulated.mean(), simulated.std() or 1.0
    x, simulated = np.clip(x, 0, 1e6).astype(int), np.clip(simulated, 0, 1e6).astype(int)
    top = min(max(int(np.quantile(x, 0.9999)), int(simulated.max()), R.steps[-1]) + 2, 100_000)
    number, expected = (np.bincount(np.minimum(each, top), minlength=top + 1) for each in (x, simulated))
    expected = expected * n / m
    beside = x + rng.integers(-R.steps[-1], R.steps[-1] + 1, n)
    remainders = [
        np.abs(np.bincount(x % k, minlength=k) - np.bincount(beside % k, minlength=k)).max() / np.sqrt(n)
        for k in R.steps
    ]
    neighbours = [np.convolve(each, [0.5, 0, 0.5], "same") + 1 for each in (number, expected)]
    there = expected * neighbours[0] / neighbours[1]
    spikes = (number - there) / np.sqrt(number + there + R.added_variance)
    scale, zeros, usual_zeros = max(mean, 0.3), (x == 0).mean(), (simulated == 0).mean()
    return np.array(
        [
            np.log(max(mean, 0.05)),
            np.log(std + 0.05),
            zeros,
            usual_zeros,
            np.log(zeros + 1e-4) - np.log(usual_zeros + 1e-4),
            np.log1p(x.max() / scale),
            *remainders,
            spikes.max(),
            spikes.min(),
            spikes.argmax() / scale,
            spikes.argmin() / scale,
            np.log(x.var() / max(x.mean(), 1e-3) + 1e-3),
            np.log(simulated.var() / max(mean, 1e-3) + 1e-3),
        ]
    )


def _of_reals(
    x: NDArray[np.float64], simulated: NDArray[np.float64], at: NDArray[np.float64], span: tuple[float, float]
) -> NDArray[np.float64]:
    """Marks that real numbers alone have: values that repeat, steps and gaps, and what lies at the ends."""
    n, m = len(x), len(simulated)
    values, times = np.unique(x, return_counts=True)
    usual, usual_times = np.unique(simulated, return_counts=True)
    bins = min(R.fine_bins, max(n // 25, 8))
    fine = np.histogram(at, np.linspace(0, 1, bins + 1))[0] / (n / bins)
    steps = np.diff(fine) * np.sqrt(n / bins / 2)
    gap = np.diff(np.r_[0, np.sort(at), 1]).max() * n
    ends = np.histogram(simulated, R.fine_bins, (simulated.min(), simulated.max()))[0][[0, -1]] / (m / R.fine_bins)
    often = (values[times.argmax()] - span[0]) / (span[1] - span[0]) if times.max() > 5 else 0.5
    return np.array(
        [
            len(values) / n,
            np.log(times.max()),
            np.log1p((times > 5).sum()),
            len(usual) / m,
            np.log(usual_times.max()),
            often,
            steps.max(),
            steps.min(),
            steps.argmax() / bins,
            steps.argmin() / bins,
            *np.log1p(fine[[0, -1]]),
            np.log(gap),
            *np.log1p(ends),
        ]
    )


def _together(x: NDArray, simulated: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
    """Marks of how features (n, d) go together, beside simulated ones (m, d), as normal scores: the largest of each."""
    n, d = x.shape
    z, usual = (
        np.stack([_scores(each[:, j], simulated[:, j], rng) for j in range(d)], axis=1) for each in (x, simulated)
    )
    upper, off = np.triu_indices(d, 1), ~np.eye(d, dtype=bool)
    a, b = ((each - each.mean(axis=0)) / each.std(axis=0) for each in (z, usual))
    linear = np.sqrt(n) * (a.T @ a / n - b.T @ b / len(b))[upper]
    bent = np.sqrt(n / 2) * np.clip(a.T @ (a**2 - 1) / n - b.T @ (b**2 - 1) / len(b), -5, 5)[off]
    spreads = (a**2 - 1).T @ (a**2 - 1) / n - (b**2 - 1).T @ (b**2 - 1) / len(b)
    spread = np.sqrt(n) / 2 * np.clip(spreads, -R.most_deviation, R.most_deviation)[upper]
    cells = np.array([_cells(z[:, [i, j]], usual[:, [i, j]]) for i, j in combinations(range(d), 2)])
    far = [((np.abs(each) > 3).sum(axis=1) >= k).mean() for k in (1, 2, 3) for each in (z, usual)]
    tops = [_top(each) for each in (linear, bent, spread, cells)]
    return np.r_[*tops, np.log(np.array(far) + 1e-4), d]


def _cells(z: NDArray[np.float64], usual: NDArray[np.float64]) -> float:
    """The excess of chi-squared of two features (n, 2), each cut at its quarters, over what (m, 2) let expect."""
    ratio, tables = len(z) / len(usual), []
    for each in (z, usual):
        rows, columns = (np.searchsorted(np.quantile(side, R.quarters), side) for side in each.T)
        tables.append(np.bincount(4 * rows + columns, minlength=16))
    number, expected = tables[0], tables[1] * ratio
    return float(((number - expected) ** 2 / (expected * (1 + ratio) + R.added_variance)).sum() - 9)


def _top(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The three largest without sign, 0 where there are fewer, the mean, and the largest with its sign: (5,)."""
    size = np.abs(values)
    largest = np.sort(np.r_[size, 0, 0])[::-1][:3]
    return np.r_[largest, size.mean(), values[size.argmax()]]


def _place(x: NDArray, simulated: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
    """The share of simulated values (m,) below each measured one (n,), at random among equal ones."""
    ordered = np.sort(simulated)
    below, not_above = (np.searchsorted(ordered, x, side) for side in ("left", "right"))
    return (below + rng.random(len(x)) * (not_above - below)) / len(ordered)


def _scores(x: NDArray, simulated: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
    """The places of measured values as quantiles of a standard normal distribution: (n,)."""
    least = 0.5 / len(simulated)
    return ndtri(np.clip(_place(x, simulated, rng), least, 1 - least))


def _compared(
    number: NDArray, expected: NDArray[np.float64], ratio: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pulls of bins (k,), and logarithms of their ratios; measured events are `ratio` times the simulated ones."""
    pulls = (number - expected) / np.sqrt(expected * (1 + ratio) + R.added_variance)
    return np.clip(pulls, -R.most_pull, R.most_pull), np.log((number + 1) / (expected + 1))


def _excess(pulls: NDArray[np.float64]) -> float:
    """The excess of the square of pulls (k,), in standard deviations."""
    return float((pulls @ pulls - len(pulls)) / np.sqrt(2 * len(pulls)))


OUTSIDE = "outside"
"""What the networks call an effect that is in no family of the catalogue."""

Kind = Literal["count", "real", "reals"]
"""The kind of events that there is experience with: one count, one real number, or several."""

Layer = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Weights (a, b) and biases (b,)."""


@dataclass(frozen=True)
class Recogniser:
    """Networks with rectified units, whose probabilities are averaged."""

    families: tuple[str, ...]
    """(k,)"""
    networks: tuple[tuple[Layer, ...], ...]

    def probabilities(self, marks: NDArray[np.float64]) -> dict[str, float]:
        """The probability of each family, by a portrait (f,)."""
        shares = [softmax(forward(layers, compressed(marks))) for layers in self.networks]
        return dict(zip(self.families, np.mean(shares, axis=0).tolist(), strict=True))

    @classmethod
    @cache
    def of(cls, kind: Kind) -> "Recogniser":
        """The one that is installed."""
        with files(__package__).joinpath(f"{kind}.npz").open("rb") as file, np.load(file) as stored:
            names = tuple(stored["families"].tolist())
            sizes = stored["layers"].tolist()
            layers = [tuple(stored[f"{part}{k}"].astype(float) for part in "wb") for k in range(sum(sizes))]
        ends = np.cumsum(sizes)
        return cls(names, tuple(tuple(layers[end - size : end]) for end, size in zip(ends, sizes, strict=True)))


def compressed(marks: NDArray[np.float64]) -> NDArray[np.float64]:
    """A portrait, or several, on the scale of networks: logarithms beyond 1, of either sign."""
    return np.sign(marks) * np.log1p(np.abs(marks))


def forward(layers: Sequence[Layer], inputs: NDArray[np.float64]) -> NDArray[np.float64]:
    """The outputs (k,) of a network for inputs (f,)."""
    *hidden, (weights, biases) = layers
    for w, b in hidden:
        inputs = np.maximum(inputs @ w + b, 0)
    return inputs @ weights + biases


def kind_of(task: Task) -> Kind | None:
    """What the events of a task are; None where there is no experience with such."""
    kinds = set(task.kinds_of_features)
    if task.event_shape or ("count" in kinds and task.num_features > 1):
        return None
    return "count" if "count" in kinds else "real" if task.num_features == 1 else "reals"


def resemblance(
    task: Task, effects: Sequence[Effect], x: NDArray, simulated: Callable[[int], NDArray] | None
) -> dict[str, float]:
    """Logarithm of how much measured events (n, d) look like each family of `effects`, and like what is OUTSIDE.

    They are seen beside events that `simulated` makes, so many of them: (m, d). A family that the networks have not
    learnt is like the average of the others. All are alike without `simulated`, or without experience of such events.
    """
    names, kind = [*dict.fromkeys(effect.name for effect in effects), OUTSIDE], kind_of(task)
    known: dict[str, float] = {}
    if kind is not None and simulated is not None:
        seen = x[: R.portrait_events]
        beside = simulated(R.simulated * len(seen))
        if kind != "count" or beside.mean() >= R.least_count:
            known = Recogniser.of(kind).probabilities(portrait(seen, beside, kind == "count"))
    learnt = [name for name in names if name in known]
    total = sum(known[name] for name in learnt)
    share = {name: known[name] / total if name in learnt else 1 / len(learnt or names) for name in names}
    return {name: float(np.log(each + R.floor)) for name, each in share.items()}
