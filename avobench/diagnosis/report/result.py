"""The result of a diagnosis: all that is said, and what its figures are drawn from."""

from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.goodness_of_fit.gates import Correction
from avobench.diagnosis.report.decide import Rivals
from avobench.diagnosis.report.outcome import Outcome
from avobench.diagnosis.report.uncertainties import QuotedFit, models, probabilities
from avobench.diagnosis.schema import Decision, Diagnosis, Identifiable, Place, Region
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.settings import REPORT
from avobench.diagnosis.summary.bins import Span, View
from avobench.diagnosis.summary.target import Target
from avobench.tasks import Task


@dataclass(frozen=True)
class Spectrum:
    """One feature: shares of the events in bins, measured and simulated."""

    feature: str
    edges: NDArray[np.float64]
    """(bins + 1,), from the smallest to the largest measured value at least."""
    measured: NDArray[np.float64]
    """Shares of the events (bins,), as are the next ones."""
    error: NDArray[np.float64]
    """Standard error of the measured shares."""
    before: NDArray[np.float64]
    after: NDArray[np.float64] | None
    """The shares with the effects; None where none was added."""
    quantity: str = "probability density"
    """What the shares are, divided by the widths of the bins."""
    axis: str = ""
    """The feature that a published table is binned by."""
    unit: str = ""
    """Of its edges."""

    def pulls(self, simulated: NDArray[np.float64]) -> NDArray[np.float64]:
        """(measured - simulated) / error: (bins,)."""
        return (self.measured - simulated) / self.error


@dataclass(frozen=True)
class Maps:
    """The mean of each cell of images, measured and simulated. All are (rows, columns)."""

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


def pictures(view: View, target: Target, before: Fit, after: Fit | None, names: tuple[str, ...]) -> Pictures:
    """What figures show of the events that were fitted, by a `view` of them; `names` are those of the features."""
    maps = None
    if view.cells is not None:
        cells = [
            None if fit is None else _cells(fit, target.num_events).reshape(view.cells.shape) for fit in (before, after)
        ]
        maps = Maps(view.cells, view.cell_errors, cells[0], cells[1])
    spans = [span for span in view.spans if (maps is None or span.feature == "hits") and not span.of_missing]
    return Pictures(tuple(_spectrum(view, span, target, before, after, names) for span in spans), maps)


def _cells(fit: Fit, num_events: int) -> NDArray[np.float64]:
    """Mean of each cell at the fitted parameters: (d,)."""
    x = fit.model.simulate(np.tile(fit.params, (REPORT.map_events * num_events, 1)), np.random.default_rng(0))
    return x.mean(axis=0, dtype=float)


def _spectrum(
    view: View, span: Span, target: Target, before: Fit, after: Fit | None, names: tuple[str, ...]
) -> Spectrum:
    bins = slice(span.start, span.start + len(span.ends) - 1)
    name = names[span.feature] if isinstance(span.feature, int) else span.feature
    first, then = before.predicted[bins], None if after is None else after.predicted[bins]
    if (shown := view.shown) is not None:
        unit, measured = shown.unit[bins], (shown.values[bins], shown.errors[bins])
        models = (first * unit, None if then is None else then * unit)
        return Spectrum(span.name or name, span.ends, *measured, *models, "density", name, span.unit)
    share = target.mean[bins]
    # At least one event's worth: a bin in which nothing was measured is not known exactly.
    error = np.sqrt(np.maximum(share * (1 - share), 1 / target.num_events) / target.num_events)
    return Spectrum(name, span.ends, share, error, first, then)


PlaceOf = TypeVar("PlaceOf", bound=Place)

PACKAGES = ("avobench", "numpy", "scipy", "scikit-learn")
"""Whose versions a diagnosis states: those that its numbers depend on."""


@dataclass(frozen=True)
class Result:
    """A diagnosis with what it was made of, as `diagnose` returns it."""

    task: Task
    diagnosis: Diagnosis
    """All that is said, as it stands in `diagnosis.json`."""
    fit: Fit | None
    """The fit of the final model, of which `model.json` is written; None where all was read from a file."""
    pictures: Pictures
    """What figures are drawn from."""
    correction: Correction | None
    """Weights for simulated events, where the catalogue does not explain all."""
    rivals: Rivals | None = None
    """The models of the 95 % set, fitted; None where there is one, or all was read from a file."""
    posterior: Posterior | None = None
    """All sets of effects that were weighed; None where nothing disagrees, or all was read from a file."""


def assemble(
    task: Task,
    outcome: Outcome,
    final: QuotedFit,
    regions: list[Region],
    rows: list[Identifiable],
    decisions: list[Decision],
    **facts: Any,
) -> Diagnosis:
    """The diagnosis as it is written to a file.

    `final` is the final fit with its uncertainties, `regions` are where the null model disagrees with the events,
    `rows` the identifiability card, and `decisions` what would tell models apart. `facts` are further fields of the
    diagnosis.
    """
    first, posterior, labels = QuotedFit(outcome.first), outcome.posterior, task.labels
    units = dict(zip(labels, task.feature_units, strict=False))  # none where the task does not say them

    def with_unit(place: PlaceOf) -> PlaceOf:
        return place.model_copy(update={"unit": units.get(place.feature, place.unit)})

    fields = {
        "verdict": outcome.verdict,
        "alpha": outcome.alpha,
        "p_value_before": outcome.null.p_value,
        "p_value_after": None,
        "gates": outcome.null.gates,
        "gap_before": outcome.gap_before,
        "gap_after": outcome.gap_after,
        "theta_before": first.theta,
        "theta_after": None,
        "identified_before": first.identified,
        "identified_after": None,
        "effects": [],
        "regions": [with_unit(region) for region in regions],
        "decisions": [each.model_copy(update={"where": each.where and with_unit(each.where)}) for each in decisions],
        "candidates": outcome.candidates,
        "identifiability": rows,
        "seconds": 0.0,
        "seed": 0,
        "versions": {name: version(name) for name in PACKAGES},
    }
    if posterior is not None:
        fields |= {
            "probabilities": probabilities(posterior, labels),
            "outside": posterior.outside,
            "others": posterior.others,
            "models": models(posterior, labels),
        }
    if outcome.extended is not None:
        effects = [final.effect(k, posterior, labels) for k in range(len(outcome.effects))]
        fields |= {
            "p_value_after": outcome.final.p_value,
            "gates_after": outcome.final.gates,
            "theta_after": final.theta,
            "identified_after": final.identified,
            "effects": sorted(effects, key=lambda effect: -effect.probability),
        }
    return Diagnosis(**fields, **facts)
