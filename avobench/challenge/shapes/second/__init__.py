"""The second series of hidden effects: the same families by other mechanisms, so that no shape is known already."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.second import continuous, counts, images

FAMILIES: dict[str, tuple[type[Injection], ...]] = {
    "counts": (
        counts.LeakyShutter,
        counts.Flares,
        counts.DecayingSource,
        counts.ReadoutBuffer,
        counts.PrescaledTrigger,
        counts.SweptPulser,
        counts.Ringing,
        counts.MainsHum,
        counts.PrescaledScaler,
        counts.PulsedBeam,
        counts.ChannelsOff,
    ),
    "continuous": (
        continuous.SlantedMaterial,
        continuous.StochasticTerm,
        continuous.DisplacedVertex,
        continuous.PedestalStep,
        continuous.StretchedBarrel,
        continuous.LogarithmicGain,
        continuous.LayersMissed,
        continuous.AttenuatedLight,
        continuous.UnevenNoise,
        continuous.JacobianPeak,
        continuous.TaperedGap,
        continuous.LopsidedFlips,
        continuous.NuclearScattering,
        continuous.BitFlips,
        continuous.TwoNeighbours,
        continuous.EtaTowers,
        continuous.LogarithmicConverter,
        continuous.UnsteadyRail,
    ),
    "images": (
        images.SilentLink,
        images.NoisyChip,
        images.BadTiming,
        images.GradedNoise,
        images.OutOfTime,
        images.WanderingBeam,
        images.TiltedBeams,
        images.CentralTrigger,
    ),
}
"""By the kind of events. Random draws go by this order, so that a new shape belongs at an end."""
