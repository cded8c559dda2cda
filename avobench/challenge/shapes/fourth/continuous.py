"""Effects in cosines and in other real features."""

from avobench.challenge.shapes.fourth import continuous_readout, continuous_response, continuous_selection

FAMILIES = (*continuous_response.FAMILIES, *continuous_selection.FAMILIES, *continuous_readout.FAMILIES)
