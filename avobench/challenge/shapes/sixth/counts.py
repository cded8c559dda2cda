"""Shapes for one count an event, of this series."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.sixth import counts_added, counts_lost, counts_read

FAMILIES: tuple[type[Injection], ...] = (
    counts_lost.StuckShutter,
    counts_lost.TelemetryGaps,
    counts_added.PassingCirrus,
    counts_added.FlaringBlazar,
    counts_lost.OnePerBucket,
    counts_lost.OverloadRecovery,
    counts_lost.CurrieLimit,
    counts_lost.WarmDiscriminators,
    counts_added.AirShowerTriggers,
    counts_added.PulserSweep,
    counts_added.BouncingReed,
    counts_added.RingBufferReread,
    counts_read.SingleEventUpset,
    counts_read.TremblingNeedle,
    counts_read.SquareRootCompression,
    counts_read.PrescalerCarry,
    counts_lost.TrackingTimeout,
    counts_lost.SpotFinder,
    counts_read.FullWell,
    counts_read.TopCodedForms,
    counts_added.ScintillatorAfterglow,
    counts_added.UnevenBunches,
)
"""One or two of each family."""
