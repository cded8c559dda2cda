"""What the events say that were kept aside: how large the gap is, and whether an added effect made it larger."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Gap
from avobench.diagnosis.summary.target import Target

SHARE = 0.25
"""Of the measured events, kept aside: no fit or test sees them; the gap is measured on them, and they may veto."""
VETO = 2.5
"""Standard errors of the scatter of the events kept aside: a gap that grows on them by more vetoes an effect. A right
effect then is vetoed once in 160 times."""


@dataclass(frozen=True)
class HeldOut:
    """Measured events that no fit has seen, by their summary."""

    target: Target
    """That models are fitted to: other events of the same measurement."""
    mean: NDArray[np.float64]
    """Mean summary of the events kept aside (K,)."""
    num_events: int

    @classmethod
    def of(cls, target: Target, x: NDArray) -> "HeldOut":
        """Of events x (n, d)."""
        return cls(target, target.summary.mean(x)[0], len(x))

    def gap(self, fit: Fit) -> Gap:
        """Chi-squared per degree of freedom between a fitted model and these events.

        1 is what is expected if the model is true: scatter of these events, and of the fit by measurement and
        simulation.
        """
        r = self._left(fit)
        share = self.num_events / self.target.num_events
        ndf = self.target.rank * (1 + fit.noise * share) + fit.num_identified * share
        q = float(r @ r)
        spread = np.sqrt(2 * self.target.rank + 4 * max(q - self.target.rank, 0))
        return Gap(value=q / ndf, low=max(q - 1.96 * spread, 0) / ndf, high=(q + 1.96 * spread) / ndf)

    def grew(self, new: Fit, old: Fit) -> bool:
        """Whether the gap grows from one fit to another, beyond the scatter of these events.

        If the new one is right, what it leaves of them is noise, also along the difference d of the two: normal, of
        variance 1 from these events, and their share of those that were fitted from the fit. The gap grows where it is
        below -|d| / 2, which chance alone brings about for a weak effect.
        """
        after, before = self._left(new), self._left(old)
        d = before - after
        error = np.sqrt(1 + (1 + new.noise + old.noise) * self.num_events / self.target.num_events)
        z = float(after @ d) / max(float(np.linalg.norm(d)) * error, 1e-12)
        return float(after @ after) > float(before @ before) and z < -VETO

    def _left(self, fit: Fit) -> NDArray[np.float64]:
        """Measured minus fitted mean, whitened for so many events: (r,)."""
        return np.sqrt(self.num_events) * ((self.mean - fit.predicted) @ self.target.whitening)
