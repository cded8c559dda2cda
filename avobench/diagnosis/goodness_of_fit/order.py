"""Are events exchangeable? Tests of the order in which they came: drift, change point, season and clustering.

If they are, any order of the same events is as probable as the one that was measured, whatever the simulator. Of each
feature the ranks are tested, so that no tail matters; given the ranks, all null distributions here are known.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.stats import chi2, kstwobign, norm, pearson3, rankdata

from avobench.diagnosis.schema import Disorder
from avobench.diagnosis.settings import ORDER
from avobench.effects.catalogue import domain
from avobench.tasks import Task

Along = Literal["index", "time"]


@dataclass(frozen=True)
class Series:
    """A number for each event, or for each interval of time, in order."""

    feature: str | None
    of: Literal["level", "spread", "rate"]
    values: NDArray[np.float64]
    """(n,)"""
    at: NDArray[np.float64]
    """Position of each, ascending, 0 at the first and 1 at the last at most: (n,)."""
    unit: str
    """The unit of the values."""


@dataclass(frozen=True)
class Look:
    """What one test of a series says."""

    kind: Literal["drift", "change point", "season", "clustering"]
    p_value: float
    gain: float
    """About the negative logarithm of p, which tells apart what is too small for a number."""
    at: float | None = None
    """The position of a change, the period of a season, or the lag of a clustering, in events."""
    shape: NDArray[np.float64] | None = None
    """What is there if it is true, but for factors (n, k)."""
    size: float = 0.0
    """The size where there is no shape, and its unit."""
    unit: str = "correlation"


def order(
    features: dict[str | None, NDArray],
    position: NDArray[np.float64],
    along: Along,
    alpha: float,
    rng: np.random.Generator,
) -> list[Disorder]:
    """What contradicts that events are exchangeable, at level `alpha` for all tests together; the surest first.

    `features` are numbers of each event (n,), `position` its index or its time (n,), in any order. Along the time, how
    often events come is a series as well. Events of one time, as where times are rounded, are put into a random order.
    """
    gaps = np.diff(np.unique(position))
    spread = position + rng.uniform(0, gaps.min(), len(position)) if along == "time" else position.astype(float)
    rows = np.argsort(spread)
    start, span = float(spread[rows[0]]), float(spread[rows[-1]] - spread[rows[0]])
    at = (spread[rows] - start) / span
    looks = 4 * (2 * len(features) + (along == "time")) + (along == "time")
    findings: list[tuple[Look, Series]] = []
    for name, values in features.items():
        level = Series(name, "level", clipped(values[rows]), at, "its own unit")
        in_level, residuals = findings_of(level, scores(values[rows]), alpha / looks)
        findings += [(look, level) for look in in_level]
        width = np.abs(residuals - np.median(residuals))
        told_apart = abs(scores(width) @ scores(residuals)) < ORDER.same_ranks * len(residuals)
        if told_apart and all(look.kind != "clustering" for look in in_level):
            spreads = Series(name, "spread", width / max(width.mean(), 1e-300), at, "of its mean")
            findings += [(look, spreads) for look in findings_of(spreads, scores(width), alpha / looks)[0]]
    if along == "time":
        counts = np.histogram(at, max(min(len(at) // ORDER.in_interval, ORDER.most_bins), 2), (0, 1))[0].astype(float)
        middle = (np.arange(len(counts)) + 0.5) / len(counts)
        rate = Series(None, "rate", counts / counts.mean(), middle, "of the mean rate")
        findings += [(look, rate) for look in findings_of(rate, scores(counts), alpha / looks)[0]]
        if (look := bursts(counts)).p_value < alpha / looks:
            findings.append((look, rate))
    findings.sort(key=lambda each: (each[0].p_value, -each[0].gain))
    return [disorder(look, series, along, start, span, looks) for look, series in findings]


def exchangeability(
    task: Task, x: NDArray, position: NDArray[np.float64], along: Along, alpha: float, seed: int
) -> list[Disorder]:
    """What contradicts that events x (N, d) of a task at these positions (N,) are exchangeable.

    The random numbers are its own, so that all else of a diagnosis is as without it.
    """
    features = projections(x, () if x.shape[1] == 1 and domain(task) == "counts" else task.labels, task.event_shape)
    return order(features, position, along, alpha, np.random.default_rng([seed, 1]))


def projections(x: NDArray, names: tuple[str, ...], image: tuple[int, ...]) -> dict[str | None, NDArray]:
    """What is followed of events x (N, d): each feature, named or not; of images their hits and where these are."""
    if not image:
        return dict(zip(names, x.T, strict=True)) if names else {None: x[:, 0]}
    hits = (x > 0).sum(axis=1)
    row, column = np.divmod(np.arange(x.shape[1]), int(np.prod(image[1:])))
    projected: dict[str | None, NDArray] = {"hits": hits}
    for name, place in (("row", row), ("column", column)):
        mean = (x > 0) @ place / np.maximum(hits, 1)
        projected[name] = np.where(hits > 0, mean, np.median(mean[hits > 0]) if hits.any() else 0)
    return projected


def scores(values: NDArray) -> NDArray[np.float64]:
    """Ranks of values (n,), of mean 0 and variance 1; all 0 where values are alike."""
    ranks = rankdata(values)
    ranks -= ranks.mean()
    return ranks / max(ranks.std(), 1e-12)


def clipped(values: NDArray) -> NDArray[np.float64]:
    """Values (n,) without their tails, of which few events would decide how large something is."""
    return np.clip(values.astype(float), *np.quantile(values, [ORDER.clipped, 1 - ORDER.clipped]))


def findings_of(series: Series, score: NDArray[np.float64], level: float) -> tuple[list[Look], NDArray[np.float64]]:
    """What is in a series at this level, and its values without it (n,): the surest first, then what is in the rest.

    A drift looks a little like a change point, and every other pair is alike too: what one explains does not count for
    another. Each kind is told once. After a clustering nothing is looked for, since events then depend on each other.
    """
    findings: list[Look] = []
    values = series.values
    while True:
        kinds = {look.kind for look in findings}
        looks = drift(score), change_point(score, series.at), season(score, series.at), clustering(score)
        untold = [look for look in looks if look.kind not in kinds]
        best = min(untold, key=lambda look: (look.p_value, -look.gain), default=None)
        if best is None or best.p_value >= level or not score.any():
            return findings, values
        findings.append(best)
        if best.shape is None:
            return findings, values
        values, score = without(values, best.shape), without(score, best.shape)
        score /= max(score.std(), 1e-12)


# Each test is of scores s (n,) of mean 0 and variance 1, at positions (n,) where it needs them.


def drift(s: NDArray[np.float64]) -> Look:
    """A monotonic change: Spearman's rank correlation with the order, whose variance is 1 / (n - 1)."""
    n = len(s)
    line = np.linspace(-0.5, 0.5, n)
    z = float(s @ line / np.linalg.norm(line) / np.sqrt(n) * np.sqrt(n - 1))
    return Look("drift", float(2 * norm.sf(abs(z))), z**2 / 2, shape=line[:, None])


def change_point(s: NDArray[np.float64], at: NDArray[np.float64]) -> Look:
    """A step: the largest cumulated sum, as that of a Brownian bridge (A. N. Pettitt, Appl. Statist. 28 (1979) 126)."""
    path = np.abs(np.cumsum(s)) / np.sqrt(len(s))
    k = int(path[:-1].argmax())
    after = (np.arange(len(s)) > k).astype(float)
    return Look("change point", float(kstwobign.sf(path[k])), 2 * path[k] ** 2, float(at[k + 1]), after[:, None])


def season(s: NDArray[np.float64], at: NDArray[np.float64]) -> Look:
    """The highest of a periodogram that allows for uneven positions (J. D. Scargle, Astrophys. J. 263 (1982) 835).

    At each frequency the cosine and sine sums are compared with their covariance over all orders of the scores, which
    makes the power exponential. The p-value is a bound, for all frequencies up to that of two mean distances; they are
    half a cycle apart, so that no season falls between them.
    """
    n = len(s)
    bins = min(n, ORDER.most_bins)
    cell = np.minimum((at * (bins - 1) + 0.5).astype(int), bins - 1)
    k = np.arange(2 * ORDER.least_cycles, bins)  # half a cycle each
    sums = np.fft.rfft(np.bincount(cell, s, bins), 2 * bins)[k]
    window = np.fft.rfft(np.bincount(cell, minlength=bins) / n, 2 * bins)
    once = window[k]
    twice = np.where(2 * k <= bins, window[np.minimum(2 * k, bins)], window[np.clip(2 * bins - 2 * k, 0, bins)].conj())
    # Sums of s cos and s sin over the order, and their covariance if s comes in any order.
    a, b = sums.real, -sums.imag
    vaa = n * ((1 + twice.real) / 2 - once.real**2)
    vbb = n * ((1 - twice.real) / 2 - once.imag**2)
    vab = n * (-twice.imag / 2 + once.real * once.imag)
    det = vaa * vbb - vab**2
    fine = det > 1e-3 * n**2 / 4  # at others the positions leave no room for both a cosine and a sine
    power = np.where(fine, (a**2 * vbb - 2 * a * b * vab + b**2 * vaa) / np.where(fine, 2 * det, 1), 0.0)
    best = int(power.argmax())

    def waves(cycles: float) -> NDArray[np.float64]:
        phase = 2 * np.pi * cycles * at
        return np.column_stack([np.cos(phase), np.sin(phase)])

    def residual_sum(cycles: float) -> float:
        return float((without(s, waves(cycles)) ** 2).sum())

    around = k[best] / 2 * (bins / (bins - 1) if bins > 1 else 1)
    p = float(min(-np.expm1(len(k) * np.log1p(-np.exp(-power[best]))), 1.0)) if power[best] > 0 else 1.0
    if p > 1e-3:  # too little for a period to be worth more care
        return Look("season", p, float(power[best]), 1 / around, waves(around))
    cycles = float(minimize_scalar(residual_sum, bounds=(around - 0.5, around + 0.5), method="bounded").x)
    return Look("season", p, float(power[best] - np.log(len(k))), 1 / cycles, waves(cycles))


def clustering(s: NDArray[np.float64]) -> Look:
    """Events that are close to each other are alike: the largest autocorrelation.

    A sum of products of independent scores has a third moment, which matters where few events differ from all others.
    """
    n = len(s)
    skew = float((np.abs(s) ** 3).mean() ** 2 / np.sqrt(n))
    lags = [lag for lag in ORDER.lags if lag < n // 4]
    z = [float(s[lag:] @ s[:-lag]) / np.sqrt(n - lag) for lag in lags]
    best = int(np.argmax(z))
    p = float(min(len(lags) * pearson3.sf(z[best], skew), 1.0))
    return Look("clustering", p, max(z[best], 0) ** 2 / 2, lags[best], size=z[best] / np.sqrt(n - lags[best]))


def bursts(counts: NDArray[np.float64]) -> Look:
    """Events that come together: counts (n,) of neighbouring intervals differ by more than those of a Poisson process.

    Of the events in two neighbours, each has one half; a rate that changes slowly does not matter.
    """
    pairs = counts[: len(counts) // 2 * 2].reshape(-1, 2)
    pairs = pairs[pairs.sum(axis=1) > 0]
    q = float((np.diff(pairs, axis=1)[:, 0] ** 2 / pairs.sum(axis=1)).sum())
    p, z = float(chi2.sf(q, len(pairs))), (q - len(pairs)) / np.sqrt(2 * len(pairs))
    return Look("clustering", p, max(z, 0) ** 2 / 2, 1, None, q / len(pairs) - 1, "of the mean count")


def without(values: NDArray[np.float64], shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (n,) less their mean and the best multiple of a shape (n, k)."""
    return values - values.mean() - (shape - shape.mean(axis=0)) @ factors(values, shape)


def factors(values: NDArray[np.float64], shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """The factors (k,) of the columns of a shape (n, k) that describe values (n,) best beside a constant."""
    shape = shape - shape.mean(axis=0)
    return np.linalg.solve(shape.T @ shape + 1e-12 * np.eye(shape.shape[1]), shape.T @ values)


def disorder(look: Look, series: Series, along: Along, start: float, span: float, looks: int) -> Disorder:
    """A finding with its size in the units of the series, and with where it is in those of the order or the time."""
    where = look.at
    if look.kind == "change point":
        where = start + span * look.at
    elif look.kind == "season":
        where = span * look.at
    size, unit = look.size, look.unit
    if look.shape is not None:
        size, unit = factors(series.values, look.shape), series.unit
        size = float(np.linalg.norm(size)) if look.kind == "season" else float(size[0])
    return Disorder(
        kind=look.kind,
        feature=series.feature,
        of=series.of,
        at=where,
        along=along,
        size=size,
        unit=unit,
        p_value=min(look.p_value * looks, 1.0),
    )
