"""Shapes for real features, of this series."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.sixth import acceptance, backgrounds, responses, scales, several

FAMILIES: tuple[type[Injection], ...] = (
    responses.MoffatSeeing,
    responses.DriftDiffusion,
    responses.SlippedEncoder,
    responses.PedestalWarmUp,
    responses.BirksQuenching,
    responses.GainRangeSwitch,
    acceptance.Vignetting,
    acceptance.HorizonExtinction,
    acceptance.OneEndReadout,
    acceptance.WindwardDust,
    acceptance.DustLane,
    acceptance.RoundBeamStop,
    backgrounds.RoomReturn,
    backgrounds.ChanceCoincidences,
    backgrounds.PotassiumLine,
    backgrounds.CopperDoublet,
    responses.BremConversion,
    responses.SwappedCables,
    responses.CycleSlips,
    responses.LightningPickup,
    scales.TubeCompression,
    scales.NeedleAtStop,
    scales.UnevenCodes,
    scales.WirePitch,
    several.MultiplexerMemory,
    several.DiodeLeak,
    several.TemperatureGain,
    several.LeakageBehindEdge,
    several.MainsHum,
    several.GroundBounce,
)
"""One or two of each family."""
