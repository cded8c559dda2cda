"""Intervals of each feature in which simulation and measurement disagree, with the look-elsewhere effect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Region
from avobench.diagnosis.settings import TEST
from avobench.diagnosis.summary.bins import Bins, Span
from avobench.diagnosis.summary.target import Target


@dataclass(frozen=True)
class Scan:
    """All regions of a summary, and how each reads off a whitened residual."""

    regions: list[tuple[int, int, int]]
    """(which span, first bin, last bin)."""
    reading: NDArray[np.float64]
    """(number of regions, r): rows of length 1 in what is left after the fit."""


def intervals(fit: Fit, target: Target, spans: list[Span]) -> Scan:
    """Contiguous runs of bins in each span."""
    regions, masks = [], []
    for k, span in enumerate(spans):
        bins = len(span.ends) - 1
        for first in range(bins):
            for last in range(first, min(bins, first + max(bins // 2, 1))):
                mask = np.zeros(target.summary.size)
                mask[span.start + first : span.start + last + 1] = 1
                regions.append((k, first, last))
                masks.append(mask)
    # A mean of whitened residual r is the mean C W r of the summary, so a sum of bins reads r through W^T C.
    whole = np.array(masks) @ target.cov @ target.whitening
    reading = whole @ fit.projector()
    length = np.linalg.norm(reading, axis=1)
    free = length > 1e-6 * np.linalg.norm(whole, axis=1).max()  # none where theta takes up all that there is
    return Scan([r for r, s in zip(regions, free, strict=True) if s], reading[free] / length[free, None])


def spots(fit: Fit, target: Target, x: NDArray, feature: int | str | None) -> list[tuple[float, float, int]]:
    """The intervals where a feature of simulated events x (n, d), or any if it is "all", disagrees most.

    The ends and the feature of the interval of the largest excess, and of the largest deficit; nothing for images, nor
    for an effect on a parameter of the task.
    """
    if not isinstance(target.summary, Bins):
        return []
    spans = [span for span in target.summary.view(x).spans if feature in ("all", None, span.feature)]
    if not spans:
        return []
    scan = intervals(fit, target, spans)
    if not scan.regions:
        return []
    z = scan.reading @ fit.residual
    strongest = []
    for i in (z.argmax(), z.argmin()):
        k, first, last = scan.regions[i]
        strongest.append((float(spans[k].ends[first]), float(spans[k].ends[last + 1]), spans[k].feature))
    return strongest


def significant(
    scan: Scan, fit: Fit, rng: np.random.Generator, alpha: float
) -> list[tuple[int, int, int, float, float]]:
    """Regions that stand out though all were looked at, strongest first, none overlapping another.

    Each is (which span, first bin, last bin, z, global p).
    """
    if not scan.regions:
        return []
    z = scan.reading @ fit.residual / np.sqrt(1 + fit.noise)
    draws = rng.standard_normal((TEST.draws, len(fit.residual))) @ fit.projector()
    highest = np.sort(np.abs(draws @ scan.reading.T).max(axis=1))
    p = (1 + TEST.draws - np.searchsorted(highest, np.abs(z))) / (1 + TEST.draws)
    strongest: list[tuple[int, int, int, float, float]] = []
    for i in np.argsort(-np.abs(z)):
        k, first, last = scan.regions[i]
        if p[i] > alpha or len(strongest) == TEST.regions:
            break
        if all(k != other or last < start or first > stop for other, start, stop, _, _ in strongest):
            strongest.append((k, first, last, float(z[i]), float(p[i])))
    return strongest


def regions(
    fit: Fit, target: Target, spans: list[Span], rng: np.random.Generator, alpha: float, names: tuple[str, ...]
) -> list[Region]:
    """The intervals of each span in which measured events and simulated ones disagree.

    `names` are those of the features, (d,), or none where there is nothing to choose from.
    """
    strongest = significant(intervals(fit, target, spans), fit, rng, alpha)

    def named(feature: int | str) -> str | None:
        if isinstance(feature, str):
            return feature
        return names[feature] if names else None

    return [
        Region(
            feature=named(spans[k].feature),
            low=float(spans[k].ends[first]),
            high=float(spans[k].ends[last + 1]),
            kind="excess" if z > 0 else "deficit",
            z=z,
            p_global=p,
        )
        for k, first, last, z, p in strongest
    ]
