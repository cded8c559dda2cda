"""Intervals of each feature in which simulation and measurement disagree, with the look-elsewhere effect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Place, Region
from avobench.diagnosis.settings import SEARCH, TEST
from avobench.diagnosis.summary.bins import Bins, Span
from avobench.diagnosis.summary.target import Target


@dataclass(frozen=True)
class Interval:
    """Bins of a span that lie side by side, from the first to the last."""

    span: Span
    first: int
    last: int

    @property
    def ends(self) -> tuple[float, float]:
        return float(self.span.ends[self.first]), float(self.span.ends[self.last + 1])

    def overlaps(self, other: "Interval | Together") -> bool:
        return isinstance(other, Interval) and (
            self.span is other.span and self.first <= other.last and other.first <= self.last
        )


@dataclass(frozen=True)
class Together:
    """How features go together: two of them, or all."""

    features: tuple[int, ...]

    def overlaps(self, other: "Interval | Together") -> bool:
        return self == other


@dataclass(frozen=True)
class Scan:
    """All regions of a summary, and how each reads off a whitened residual."""

    regions: list[Interval | Together]
    reading: NDArray[np.float64]
    """(number of regions, r): rows of length 1 in what is left after the fit."""

    def z(self, fit: Fit) -> NDArray[np.float64]:
        """What each region disagrees by, in standard errors: (number of regions,)."""
        return self.reading @ fit.residual / np.sqrt(1 + fit.noise)

    def __add__(self, other: "Scan") -> "Scan":
        return Scan(self.regions + other.regions, np.vstack([self.reading, other.reading]))


def intervals(fit: Fit, target: Target, spans: list[Span]) -> Scan:
    """Contiguous runs of bins in each span."""
    regions, readings, lengths = [], [], []
    whole, free = _readings(fit, target)
    for span in spans:
        bins = len(span.ends) - 1
        some = [(a, b) for a in range(bins) for b in range(a, min(bins, a + max(bins // 2, 1)))]
        regions += [Interval(span, *each) for each in some]
        first, last = span.start + np.array(some).T
        readings.append(_sums(free, first, last))
        lengths.append(np.linalg.norm(_sums(whole, first, last), axis=1))
    return _scan(regions, np.vstack(readings), np.concatenate(lengths)) if spans else _nothing(fit)


def dependences(fit: Fit, target: Target) -> Scan:
    """How features go together, each pair and all of them; nothing for images."""
    directions = target.summary.directions() if isinstance(target.summary, Bins) else []
    if not directions:
        return _nothing(fit)
    rows = np.array([row for _, row in directions])
    whole, free = _readings(fit, target)
    return _scan([Together(features) for features, _ in directions], rows @ free, np.linalg.norm(rows @ whole, axis=1))


def _nothing(fit: Fit) -> Scan:
    return Scan([], np.empty((0, len(fit.residual))))


def _readings(fit: Fit, target: Target) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How each number of the summary reads off a whitened residual (K, r), and off what theta cannot make of it.

    A mean of whitened residual r is the mean C W r of the summary, so a sum of bins reads r through W^T C.
    """
    whole = target.cov @ target.whitening
    return whole, whole @ fit.projector()


def _sums(rows: NDArray[np.float64], first: NDArray[np.intp], last: NDArray[np.intp]) -> NDArray[np.float64]:
    """The sums of the rows (K, r) from each first to each last one: (n, r)."""
    start = first.min()
    cumulated = np.vstack([np.zeros(rows.shape[1]), np.cumsum(rows[start : last.max() + 1], axis=0)])
    return cumulated[last + 1 - start] - cumulated[first - start]


def _scan(regions: list[Interval | Together], reading: NDArray[np.float64], whole: NDArray[np.float64]) -> Scan:
    """Regions with their readings (n, r), the length of each before the fit (n,), without those that theta takes up."""
    length = np.linalg.norm(reading, axis=1)
    free = length > 1e-6 * whole.max()
    return Scan([r for r, s in zip(regions, free, strict=True) if s], reading[free] / length[free, None])


def spots(fit: Fit, target: Target, x: NDArray, feature: int | str | None) -> list[tuple[float, float, int]]:
    """The intervals where a feature of simulated events x (n, d), or any if it is "all", disagrees most.

    The ends and the feature of the interval of the largest excess, and of the largest deficit; nothing for images, nor
    for an effect on a parameter of the task.
    """
    spans = [
        span
        for span in target.summary.view(x).spans
        if isinstance(span.feature, int) and feature in ("all", None, span.feature) and not span.of_missing
    ]
    scan = intervals(fit, target, spans)
    if not scan.regions:
        return []
    z = scan.z(fit)
    strongest = [scan.regions[i] for i in (z.argmax(), z.argmin())]
    return [(*region.ends, region.span.feature) for region in strongest]


def disagreeing(fit: Fit, target: Target, x: NDArray) -> list[int]:
    """The features of events x (n, d) that disagree most, alone or in a pair, as many as a search can look at."""
    d = x.shape[1]
    if d <= SEARCH.most_features or not isinstance(target.summary, Bins):
        return list(range(d))
    most = int(SEARCH.most_features**1.5 / np.sqrt(d))
    scan = intervals(fit, target, target.summary.view(x).spans) + dependences(fit, target)
    strongest = np.zeros(d)
    for region, z in zip(scan.regions, np.abs(scan.z(fit)), strict=True):
        features = region.features if isinstance(region, Together) else (region.span.feature,)
        if len(features) <= 2:
            strongest[list(features)] = np.maximum(strongest[list(features)], z)
    return sorted(np.argsort(-strongest)[:most].tolist())


def significant(
    scan: Scan, fit: Fit, rng: np.random.Generator, alpha: float
) -> list[tuple[Interval | Together, float, float]]:
    """Regions that stand out though all were looked at, strongest first, none overlapping another.

    Each with z and its global p-value.
    """
    if not scan.regions:
        return []
    z = scan.z(fit)
    draws = rng.standard_normal((TEST.draws, len(fit.residual))) @ fit.projector()
    highest = np.sort(np.abs(draws @ scan.reading.T).max(axis=1))
    p = (1 + TEST.draws - np.searchsorted(highest, np.abs(z))) / (1 + TEST.draws)
    strongest: list[tuple[Interval | Together, float, float]] = []
    for i in np.argsort(-np.abs(z)):
        if p[i] > alpha or len(strongest) == TEST.regions:
            break
        if not any(scan.regions[i].overlaps(other) for other, _, _ in strongest):
            strongest.append((scan.regions[i], float(z[i]), float(p[i])))
    return strongest


def regions(
    fit: Fit, target: Target, spans: list[Span], rng: np.random.Generator, alpha: float, names: tuple[str, ...]
) -> list[Region]:
    """The intervals of each span, and the features together, in which measured and simulated events disagree.

    `names` are those of the features, (d,), or none where there is nothing to choose from.
    """
    disagreements = significant(intervals(fit, target, spans) + dependences(fit, target), fit, rng, alpha)
    return [Region(**placed(region, z, names).model_dump(), z=z, p_global=p) for region, z, p in disagreements]


def placed(region: Interval | Together, z: float, names: tuple[str, ...]) -> Place:
    """A region by the names of its features, with what it is by the sign of its disagreement z."""
    if isinstance(region, Together):
        pair = len(region.features) == 2
        feature = " and ".join(names[j] for j in region.features) if pair else "all"
        return Place(feature=feature, low=None, high=None, kind="dependence")
    feature, (low, high) = region.span.feature, region.ends
    name = region.span.name or (feature if isinstance(feature, str) else names[feature] if names else None)
    kind = "excess" if z > 0 else "deficit"
    if region.span.of_missing:
        return Place(feature=name, low=None, high=None, kind=kind)
    return Place(feature=name, low=low, high=high, kind=kind, unit=region.span.unit or "1")
