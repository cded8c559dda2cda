"""All effects that apply to a task."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.acceptance import DeadRegion, EdgeAcceptance, ForwardBackwardAcceptance
from avobench.effects.continuous.background import FlatBackground, PeakBackground
from avobench.effects.continuous.calibration import ChargeMisid, Crosstalk, Offset, Scale
from avobench.effects.continuous.feature import ranges
from avobench.effects.continuous.readout import Quantisation, Saturation
from avobench.effects.continuous.smearing import Outliers, Resolution
from avobench.effects.contract import Effect
from avobench.effects.counts import exposure, recording
from avobench.effects.images import cells, tracker
from avobench.tasks import Task
from avobench.tasks.alignment import Alignment
from avobench.tasks.errors import UsageError

Domain = Literal["counts", "continuous", "images"]

CONTINUOUS = (
    Resolution,
    Offset,
    Scale,
    EdgeAcceptance,
    ForwardBackwardAcceptance,
    FlatBackground,
    PeakBackground,
    DeadRegion,
    ChargeMisid,
    Outliers,
    Crosstalk,
    Quantisation,
    Saturation,
)
COUNTS = (
    recording.ZeroInflation,
    exposure.Overdispersion,
    recording.DeadTime,
    recording.ThresholdLoss,
    recording.FlatBackground,
    recording.DoubleCounting,
    recording.ReadoutNoise,
    recording.Quantisation,
    exposure.PileUp,
    exposure.Inefficiency,
)
IMAGES = (cells.DeadCells, cells.NoisyCells, cells.Inefficiency, cells.RandomNoise, cells.PileUp, cells.Threshold)


def domain(task: Task) -> Domain:
    """What the events of a task are. Raises UsageError for several counts an event, for which there is no catalogue."""
    if task.event_shape:
        return "images"
    if np.dtype(task.dtype).kind not in "iu":
        return "continuous"
    if task.num_features > 1:
        raise UsageError(f"an event of {task.name} has {task.num_features} counts: effects are known of one count only")
    return "counts"


def catalogue(task: Task, x: NDArray | None = None) -> list[Effect]:
    """Every effect that applies to `task`: one entry a name and feature, each in its plainest shape.

    Ranges of features are those that events x (N, d) show, or those over the prior.
    """
    kind = domain(task)
    if kind == "counts":
        return [effect() for effect in COUNTS]
    if kind == "images":
        found = [effect(task.event_shape) for effect in IMAGES]
        if not isinstance(task, Alignment):
            return found
        found[IMAGES.index(cells.Inefficiency)] = tracker.TrackInefficiency(task.event_shape)
        return [*found, tracker.TransverseOffset(task.event_shape, task.radius), tracker.AxialTilt(task.event_shape)]
    spans = ranges(task)
    if x is not None:
        spans = tuple(span.shown(x[:, j]) for j, span in enumerate(spans))
    features = [0] if len(spans) == 1 else [*range(len(spans)), "all"]
    effects = [effect(feature, spans) for effect in CONTINUOUS for feature in features]
    return [e for e in effects if len(spans) > 1 or e.name != "crosstalk"]
