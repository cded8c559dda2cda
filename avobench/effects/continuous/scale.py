"""A wrong scale: every value is recorded stretched."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class Scale(Change):
    """Every value is stretched: about zero, about the centre of the angle, or more the larger it is.

    In the shape `two_gains` values on one side of the centre are stretched by a share of what those on the other are.
    In the shape `bowed` the scale is right at the centre and at both ends, where it was calibrated, and not between; so
    it is for the cosine of an angle where lengths along the axis are stretched. It, too, may differ on either side.
    In `above` and `below` values beyond a level are stretched away from it, as by an amplifier that changes its range.
    """

    shape: str = "linear"
    name = "scale"
    position = 3
    sentence = "The unit of the scale is wrong."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 5"

    def strength(self) -> Parameter:
        return Parameter("stretch", -0.5, 0.5, 0, "1")

    def variants(self):
        share = Parameter("share", 0, 1, None, "of the stretch")
        gains = {f"two_gains_{side}": (share,) for side in ("low", "high")}
        level, _ = self.place(0.5, 1)
        switched = {side: (replace(level, name="level"),) for side in ("above", "below")}
        bowed = {f"bowed_{side}": (share,) for side in ("low", "high")}
        return (
            {"linear": (), "cubic": (), "bowed": ()}
            | ({"angle": ()} if self.bounded else {})
            | gains
            | bowed
            | switched
        )

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(np.pi / 2 + (1 + phi[:, 0]) * (span.angle(x) - np.pi / 2))
        side = self.shape.rpartition("_")[2]
        less = (x < span.centre) if side == "low" else (x > span.centre)
        gain = phi[:, 0] * np.where(less, phi[:, 1], 1) if side in ("low", "high") else phi[:, 0]
        if self.shape.startswith("two_gains"):
            return span.centre + (x - span.centre) * (1 + gain)
        if self.shape.startswith("bowed"):
            return x + gain * (x - span.centre) * np.maximum(1 - span.unit(x) ** 2, 0)
        if self.shape in ("above", "below"):
            beyond = x - (span.centre + span.half * phi[:, 1] if self.feature == "all" else phi[:, 1])
            return x + phi[:, 0] * (np.maximum if self.shape == "above" else np.minimum)(beyond, 0)
        growth = span.relative(x) ** 2 if self.shape == "cubic" else 1
        return x * (1 + phi[:, 0] * growth)
