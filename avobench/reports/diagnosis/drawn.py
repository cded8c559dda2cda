"""A figure of a diagnosis, and the colours of all of them, each repeated in a style or a marker."""

from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

from avobench.diagnosis.schema import Region
from avobench.reports.style import PALETTE

BEFORE, AFTER = PALETTE[1], PALETTE[0]
REGION = {"excess": PALETTE[2], "deficit": PALETTE[4]}


@dataclass(frozen=True, eq=False)
class Drawn:
    """A figure, the numbers that it shows, and what a reader is told about it."""

    name: str
    caption: str
    figure: Figure
    table: pd.DataFrame


def sigma(region: Region) -> str:
    """The significance of a region: +12.1 sigma for an excess, -7.5 sigma for a deficit."""
    return rf"${region.z:+.1f}\,\sigma$"
