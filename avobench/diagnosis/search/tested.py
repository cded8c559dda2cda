"""A model of the loop, before all gates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.goodness_of_fit.cells import cell_gate
from avobench.diagnosis.goodness_of_fit.classifier import classifier_gate
from avobench.diagnosis.goodness_of_fit.summary import summary_gate
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary.target import Target

SHARES = {"summary": 0.8, "classifier": 0.2}
"""Each gate's share of the false alarms. Most effects show in the summary, so that it has most of them."""
IMAGE_SHARES = {"summary": 0.6, "cells": 0.2, "classifier": 0.2}
"""The same where events are images."""


@dataclass(frozen=True)
class Step:
    """A model of the loop, tested."""

    fit: Fit
    """In the metric of the loop's target."""
    own: Fit
    """In its own metric, with more events: what is reported."""
    gates: dict[str, Gate]

    @classmethod
    def of(
        cls,
        fit: Fit,
        target: Target,
        x: NDArray,
        rng: np.random.Generator,
        effort: Effort,
        known: KnownModel | None = None,
    ) -> "Step":
        """A fitted model before the gates. `known` is the model without its last effect, if that is known well."""
        gate, own, own_target = summary_gate(fit, target, rng, effort, known)
        gates = {"summary": gate}
        if fit.model.task.event_shape:
            gates["cells"] = cell_gate(own, x, rng, effort)
        gates["classifier"] = classifier_gate(own, own_target, x, rng)
        return cls(fit, own, gates)

    @property
    def shares(self) -> dict[str, float]:
        """Each gate's share of the false alarms."""
        return IMAGE_SHARES if "cells" in self.gates else SHARES

    @property
    def p_value(self) -> float:
        """Of all gates together; 1 before any."""
        return min([1.0, *(gate.p_value / self.shares[name] for name, gate in self.gates.items())])
