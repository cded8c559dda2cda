"""Where do simulation and measurement disagree? Intervals of each feature, with the look-elsewhere effect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit import Fit, Target
from avobench.diagnosis.summary import Bins, closed

DRAWS = 2000
MOST = 6


@dataclass(frozen=True)
class Scan:
    """All regions of a summary, and how each reads off a whitened residual."""

    regions: list[tuple[int, int, int]]
    """(block of the summary, first bin, last bin)."""
    reading: NDArray[np.float64]
    """(number of regions, r): rows of length 1 in what is left after the fit."""


def intervals(fit: Fit, target: Target, blocks: list[tuple[int, int]]) -> Scan:
    """Contiguous runs of bins in each block, given as (start, number of bins) within the summary."""
    regions, masks = [], []
    for k, (start, bins) in enumerate(blocks):
        for first in range(bins):
            for last in range(first, min(bins, first + max(bins // 2, 1))):
                mask = np.zeros(target.summary.size)
                mask[start + first : start + last + 1] = 1
                regions.append((k, first, last))
                masks.append(mask)
    # A mean of whitened residual r is the mean C W r of the summary, so a sum of bins reads r through W^T C.
    reading = np.array(masks) @ target.cov @ target.whitening @ fit.projector()
    length = np.linalg.norm(reading, axis=1)
    seen = length > 1e-6 * length.max()
    return Scan([r for r, s in zip(regions, seen, strict=True) if s], reading[seen] / length[seen, None])


def blocks_of(summary: Bins) -> list[tuple[int, int]]:
    """Start and number of the bins of each feature."""
    lengths = [len(edges) + 1 for edges in summary.edges]
    return [(int(start), n) for start, n in zip(np.cumsum([0, *lengths[:-1]]), lengths, strict=True)]


def spots(fit: Fit, target: Target, x: NDArray, feature: int | str | None) -> list[tuple[float, float, int]]:
    """Where a feature of simulated events x (n, d), or any if it is "all", disagrees most with measured ones.

    The ends and the feature of the interval of the largest excess, and of the largest deficit; nothing for images.
    """
    if not isinstance(target.summary, Bins):
        return []
    blocks = blocks_of(target.summary)
    scan = intervals(fit, target, blocks if feature == "all" else blocks[feature or 0 :][:1])
    z = scan.reading @ fit.residual
    found = []
    for i in (z.argmax(), z.argmin()):
        block, first, last = scan.regions[i]
        column = block if feature == "all" else feature or 0
        ends = closed(target.summary.edges[column], x[:, column])
        found.append((float(ends[first]), float(ends[last + 1]), column))
    return found


def significant(
    scan: Scan, fit: Fit, rng: np.random.Generator, alpha: float
) -> list[tuple[int, int, int, float, float]]:
    """Regions that stand out though all were looked at, strongest first, none overlapping another.

    Each is (block, first bin, last bin, z, global p).
    """
    z = scan.reading @ fit.residual / np.sqrt(1 + fit.noise)
    draws = rng.standard_normal((DRAWS, len(fit.residual))) @ fit.projector()
    highest = np.sort(np.abs(draws @ scan.reading.T).max(axis=1))
    p = (1 + DRAWS - np.searchsorted(highest, np.abs(z))) / (1 + DRAWS)
    found: list[tuple[int, int, int, float, float]] = []
    for i in np.argsort(-np.abs(z)):
        block, first, last = scan.regions[i]
        if p[i] > alpha or len(found) == MOST:
            break
        if all(block != b or last < start or first > stop for b, start, stop, _, _ in found):
            found.append((block, first, last, float(z[i]), float(p[i])))
    return found
