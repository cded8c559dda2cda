"""The shapes of this series that happen to real features."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.seventh import continuous_added as added
from avobench.challenge.shapes.seventh import continuous_lost as lost
from avobench.challenge.shapes.seventh import continuous_measured as measured
from avobench.challenge.shapes.seventh import continuous_read as read
from avobench.challenge.shapes.seventh import continuous_several as several

FAMILIES: tuple[type[Injection], ...] = (
    measured.FiniteSlits,
    measured.DriftDiffusion,
    measured.WarmUp,
    measured.KnockedMount,
    measured.LensDistortion,
    measured.HalfLengths,
    lost.SurfaceLoss,
    lost.Horizon,
    lost.TiredHalf,
    lost.OneEndReadout,
    lost.PillarShadow,
    lost.AbsorptionLine,
    added.CombinatorialBackground,
    added.AccidentalCoincidences,
    added.FluorescenceLine,
    added.TailingPeak,
    added.DecimalSlip,
    added.CosmicHits,
    read.StiffTracks,
    read.LostSignBit,
    read.ShortMantissa,
    read.DigitPreference,
    read.AmplifierCompression,
    read.SupplyRails,
    several.AnodeCoupling,
    several.MultiplexerMemory,
    several.GasGain,
    several.PumpVibration,
    several.MainsHum,
    several.TiltingTable,
)
