"""Effects hidden in measured data, written independently of the catalogue: other shapes of the same physics."""

import numpy as np

from avobench.challenge.shapes import second
from avobench.challenge.shapes.contract import Injection, Place, Simulate
from avobench.challenge.shapes.first import (
    acceptance,
    backgrounds,
    converter,
    counting,
    distortion,
    images,
    intervals,
    smearing,
    tracker,
)
from avobench.tasks import Task

__all__ = ["FAMILIES", "Injection", "Place", "Simulate", "kind_of_events", "shapes"]

FAMILIES: dict[str, tuple[type[Injection], ...]] = {
    "counts": (
        intervals.Trips,
        intervals.Discharges,
        intervals.TwoIntensities,
        intervals.LognormalRate,
        intervals.Oscillation,
        intervals.SoftTrigger,
        intervals.StrayIntervals,
        counting.HybridDeadTime,
        counting.Afterpulses,
        counting.LateReset,
        counting.UnevenPileUp,
        counting.UnevenInefficiency,
        converter.LandauNoise,
        converter.LaplaceNoise,
        converter.StuckBit,
        converter.CoarseRange,
        second.counts.LeakyShutter,
        second.counts.Flares,
        second.counts.DecayingSource,
        second.counts.ReadoutBuffer,
        second.counts.PrescaledTrigger,
        second.counts.SweptPulser,
        second.counts.Ringing,
        second.counts.MainsHum,
        second.counts.PrescaledScaler,
        second.counts.PulsedBeam,
        second.counts.ChannelsOff,
    ),
    "continuous": (
        smearing.AngularSmearing,
        smearing.DoubleGaussian,
        smearing.SkewedSmearing,
        smearing.TurnedAxis,
        smearing.DriftingOffset,
        smearing.AngularScale,
        smearing.BentGain,
        acceptance.ErfTurnOn,
        acceptance.BeamPipe,
        acceptance.RimLoss,
        acceptance.TwoHalves,
        acceptance.FadingSide,
        acceptance.SoftGap,
        backgrounds.NearlyFlat,
        backgrounds.SoftEnded,
        backgrounds.BreitWigner,
        backgrounds.RadiativePeak,
        distortion.StraightTracks,
        distortion.StudentTails,
        distortion.LandauTails,
        distortion.HardScattering,
        distortion.RectifiedCrosstalk,
        distortion.TruncatingReadout,
        distortion.Segments,
        distortion.SoftSaturation,
        second.continuous.SlantedMaterial,
        second.continuous.StochasticTerm,
        second.continuous.DisplacedVertex,
        second.continuous.PedestalStep,
        second.continuous.StretchedBarrel,
        second.continuous.LogarithmicGain,
        second.continuous.LayersMissed,
        second.continuous.AttenuatedLight,
        second.continuous.UnevenNoise,
        second.continuous.JacobianPeak,
        second.continuous.TaperedGap,
        second.continuous.LopsidedFlips,
        second.continuous.NuclearScattering,
        second.continuous.BitFlips,
        second.continuous.TwoNeighbours,
        second.continuous.EtaTowers,
        second.continuous.LogarithmicConverter,
        second.continuous.UnsteadyRail,
    ),
    "images": (
        images.DeadPatch,
        images.HotCells,
        images.UnevenEfficiency,
        images.NoiseClusters,
        images.SpreadPileUp,
        images.MultiplicityTrigger,
        tracker.MovedBeam,
        tracker.TiltedDetector,
        tracker.SoftParticles,
        second.images.SilentLink,
        second.images.NoisyChip,
        second.images.BadTiming,
        second.images.GradedNoise,
        second.images.OutOfTime,
        second.images.WanderingBeam,
        second.images.TiltedBeams,
        second.images.CentralTrigger,
    ),
}
"""All shapes, by the kind of events."""


def kind_of_events(task: Task) -> str:
    """counts, continuous or images."""
    if task.event_shape:
        return "images"
    return "counts" if np.issubdtype(np.dtype(task.dtype), np.integer) else "continuous"


def shapes(place: Place) -> list[type[Injection]]:
    """The shapes that make sense at `place`."""
    return [shape for shape in FAMILIES[kind_of_events(place.task)] if shape.suits(place)]
