"""Forward-backward acceptance: one half of a range is recorded better than the other."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

SHAPES = {
    "linear": (),
    "step": (),
    "smooth": (Parameter("width", 0.05, 1, None, "of half the range"),),
    "growing": (Parameter("power", 0.3, 3, None, "1"),),
}
SIDES = {
    "linear": lambda u, phi: np.clip(u, -1, 1),
    "step": lambda u, phi: np.sign(u),
    "smooth": lambda u, phi: np.tanh(u / phi[:, 1]),
    "growing": lambda u, phi: (s := np.sign(phi[:, 0])) * (1 - 2 * np.clip(-s * u, 0, 1) ** phi[:, 1]),
}
"""By shape: to which side events at u (n,), in half ranges from the centre, belong, from -1 to 1."""


@dataclass(frozen=True)
class ForwardBackwardAcceptance(Acceptance):
    """One half of the range is recorded better than the other: along a line, a step, or a smooth step.

    In the shape `growing` one half loses nothing, and the other the more the nearer to its end.
    """

    shape: str = "linear"
    name = "forward_backward_acceptance"
    position = 5
    sentence = "The detector records one side better than the other."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"

    def strength(self) -> Parameter:
        return Parameter("asymmetry", -0.95, 0.95, 0, "1")

    def variants(self):
        return SHAPES

    def kept(self, x, span, phi):
        asymmetry = phi[:, 0]
        return (1 + asymmetry * SIDES[self.shape](span.unit(x), phi)) / (1 + np.abs(asymmetry))
