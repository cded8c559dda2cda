"""Shapes for images of hits, of this series."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.sixth import cells, hits

FAMILIES: tuple[type[Injection], ...] = (
    cells.CrackedWafer,
    cells.BeamSpot,
    cells.AmplifierGlow,
    cells.TelegraphCells,
    hits.OxygenLeak,
    hits.LostPackets,
    hits.DewarTemperature,
    hits.RadonProgeny,
    hits.UnwoundFilm,
    hits.SlowPixels,
    hits.ClusterCleaning,
    hits.OppositeSectors,
    cells.ResistiveStrip,
    cells.ClockFeedthrough,
)
"""Two of each family."""
