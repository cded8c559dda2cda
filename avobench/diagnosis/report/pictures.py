"""What the figures of a diagnosis are drawn from."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.summary.bins import Bins, closed
from avobench.diagnosis.summary.pixels import Pixels
from avobench.diagnosis.summary.target import Target

MAP_EVENTS = 4
"""Simulated events a measured one, for the maps of cells."""


@dataclass(frozen=True)
class Spectrum:
    """One feature: shares of the events in bins, measured and simulated."""

    feature: str
    edges: NDArray[np.float64]
    """(bins + 1,), from the smallest to the largest measured value at least."""
    measured: NDArray[np.float64]
    """(bins,), as the next ones."""
    error: NDArray[np.float64]
    """Standard error of the measured shares."""
    before: NDArray[np.float64]
    after: NDArray[np.float64] | None
    """With the effects; None where none was added."""

    def pulls(self, simulated: NDArray[np.float64]) -> NDArray[np.float64]:
        """(measured - simulated) / error: (bins,)."""
        return (self.measured - simulated) / self.error


@dataclass(frozen=True)
class Maps:
    """Of images: how often, or how strongly, each cell fires, on average. All (rows, columns)."""

    measured: NDArray[np.float64]
    error: NDArray[np.float64]
    before: NDArray[np.float64]
    after: NDArray[np.float64] | None

    def pulls(self, simulated: NDArray[np.float64]) -> NDArray[np.float64]:
        """(measured - simulated) / error: (rows, columns)."""
        return (self.measured - simulated) / self.error


@dataclass(frozen=True)
class Pictures:
    """The spectra of features, and of images the maps of cells as well."""

    spectra: tuple[Spectrum, ...] = ()
    maps: Maps | None = None


def pictures(x: NDArray, target: Target, before: Fit, after: Fit | None, names: tuple[str, ...]) -> Pictures:
    """What there is to see of the events x (N, d) that were fitted."""
    summary = target.summary
    if isinstance(summary, Bins):
        spans = [(name, x[:, j], inner) for j, (name, inner) in enumerate(zip(names, summary.edges, strict=True))]
        return Pictures(tuple(_spectra(spans, target, 0, before, after)))
    assert isinstance(summary, Pixels)
    hits = [("hits", (x > 0).sum(axis=1), summary.fullness)]
    start = sum(length for name, length in summary.blocks[:2])
    mean, error = x.mean(axis=0, dtype=float), np.sqrt(np.maximum(x.var(axis=0, dtype=float), 1 / len(x)) / len(x))
    cells = [None if fit is None else _cells(fit, len(x)).reshape(summary.grid) for fit in (before, after)]
    maps = Maps(mean.reshape(summary.grid), error.reshape(summary.grid), cells[0], cells[1])
    return Pictures(tuple(_spectra(hits, target, start, before, after)), maps)


def _cells(fit: Fit, num_events: int) -> NDArray[np.float64]:
    """Mean of each cell at the fitted parameters: (d,)."""
    x = fit.model.simulate(np.tile(fit.params, (MAP_EVENTS * num_events, 1)), np.random.default_rng(0))
    return x.mean(axis=0, dtype=float)


def _spectra(spans: list, target: Target, start: int, before: Fit, after: Fit | None) -> Iterator[Spectrum]:
    for name, values, inner in spans:
        own = slice(start, start + len(inner) + 1)
        start = own.stop
        share = target.mean[own]
        # At least one event's worth: a bin in which nothing was measured is not known exactly.
        error = np.sqrt(np.maximum(share * (1 - share), 1 / target.num_events) / target.num_events)
        found = None if after is None else after.predicted[own]
        yield Spectrum(name, closed(inner, values), share, error, before.predicted[own], found)
