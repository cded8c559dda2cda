"""What the figures of a diagnosis are drawn from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit import Fit, Target
from avobench.diagnosis.summary import Bins


@dataclass(frozen=True)
class Spectrum:
    """One feature: shares of the events in bins, measured and simulated."""

    feature: str
    edges: NDArray[np.float64]
    """(bins + 1,), from the smallest to the largest measured value."""
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
class Pictures:
    """Of tables the spectra, of images the maps; the other is empty."""

    spectra: tuple[Spectrum, ...] = ()


def spectra(x: NDArray, target: Target, before: Fit, after: Fit | None, names: tuple[str, ...]) -> Pictures:
    """The spectra of the events x (N, d) that were fitted."""
    summary = target.summary
    assert isinstance(summary, Bins)
    starts = np.cumsum([0, *(bins for _, bins in summary.blocks)])
    result = []
    for j, inner in enumerate(summary.edges):
        own = slice(starts[j], starts[j] + len(inner) + 1)
        share = target.mean[own]
        # At least one event's worth: a bin in which nothing was measured is not known exactly.
        error = np.sqrt(np.maximum(share * (1 - share), 1 / target.num_events) / target.num_events)
        edges = np.concatenate([[x[:, j].min()], inner, [x[:, j].max()]]).astype(float)
        result.append(
            Spectrum(
                names[j], edges, share, error, before.predicted[own], None if after is None else after.predicted[own]
            )
        )
    return Pictures(tuple(result))
