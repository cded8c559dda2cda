"""A case of a challenge: what was hidden beside what a diagnosis said."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from avobench.diagnosis.schema import Verdict
from avobench.tasks import Task

INVISIBLE = 0.2
"""A hidden effect of lower power that is not detected counts as undetectable: theta absorbs it, or it is too weak."""
VISIBLE = 0.9
"""Power from which an effect counts as visible: nine of ten times the best test would see it."""
DERIVATIVE_STEP = 1e-4
"""The step of a derivative in widths of the prior: small beside curvature, and large beside rounding."""


@dataclass(frozen=True)
class Case:
    """A case with its answer and its diagnosis, as they stand in their files."""

    task: Task
    answer: dict[str, Any]
    diagnosis: dict[str, Any]

    @property
    def detected(self) -> bool:
        return self.diagnosis["verdict"] != Verdict.NOTHING

    @property
    def undetectable(self) -> bool:
        return not self.detected and self.power < INVISIBLE

    @property
    def power(self) -> float:
        """The power of the best test for the least visible of the hidden effects."""
        return min(effect["power"] for effect in self.answer["effects"])

    @property
    def both_visible(self) -> bool:
        """Whether the best test sees each of two hidden effects beside the other; no where older records do not say."""
        beside = [effect.get("beside") for effect in self.answer["effects"]]
        return None not in beside and min(beside) >= VISIBLE

    @property
    def hidden(self) -> list[tuple[str, str | None]]:
        return [self.key(effect) for effect in self.answer["effects"]]

    @property
    def named(self) -> list[tuple[str, str | None]]:
        """The effects that were named, the most probable first."""
        return [self.key(effect) for effect in self.diagnosis["effects"]]

    @property
    def ties(self) -> list[set[tuple[str, str | None]]]:
        """The set of each named effect and of the effects that it is tied with."""
        effects = self.diagnosis["effects"]
        return [{self.key(effect), *map(self.key, effect["tied_with"])} for effect in effects]

    def key(self, effect: dict[str, Any]) -> tuple[str, str | None]:
        """What names an effect; the feature counts where there is one to choose."""
        choose = self.task.num_features > 1 and not self.task.event_shape
        return effect["name"], effect["feature"] if choose else None

    def bias(self, when: str) -> float | None:
        """The mean distance from the truth of what the events determine of theta. `when`: theta_...

        In widths of the prior, or in what else a task tells it in.
        """
        estimate = self._theta(when)
        if estimate is None:
            return None
        estimated, true = self.task.identifiable(np.stack([estimate, self.answer["theta"]]))
        return float((np.abs(estimated - true) / self.task.identifiable_scale).mean())

    def pull(self, when: str) -> float | None:
        """How far theta is from the truth, in quoted errors, at most; None where the data determine nothing of it.

        Of the combinations that the diagnosis says are determined; where the events determine fewer quantities than
        theta has, of those, with the errors that the combinations give them.
        """
        combinations, estimate, truth = (
            self.diagnosis[f"identified_{when}"],
            self._theta(f"theta_{when}"),
            self.answer["theta"],
        )
        if not combinations:
            return None
        names = self.task.parameter_names
        rows = np.array([[each["coefficients"][name] for name in names] for each in combinations])
        std = np.array([each["std"] for each in combinations])
        step = DERIVATIVE_STEP * self.task.prior.width
        at = np.stack([estimate, truth, *(estimate + change for change in np.diag(step))])
        quantities = self.task.identifiable(at)
        if quantities.shape[1] == len(names):
            return float(np.abs(rows @ (estimate - truth) / std).max())
        estimated, true, *moved = quantities
        # A combination moves theta along its own coefficients, in units of the range, by its error.
        width = np.subtract(self.task.support.high, self.task.support.low)
        slopes = [(rows * width) @ (change / step * width) for change in (np.array(moved) - estimated).T]
        errors = [np.sqrt((slope**2) @ std**2) for slope in slopes]
        return float(np.max(np.abs(estimated - true) / errors))

    def _theta(self, when: str) -> np.ndarray | None:
        theta = self.diagnosis[when]
        return np.array([theta[name]["value"] for name in self.task.parameter_names]) if theta else None

    @property
    def explained(self) -> bool:
        return self.diagnosis["verdict"] == Verdict.NAMED

    def first(self, *, feature: bool = True) -> bool:
        """Whether the effect that was named first is the hidden one; without `feature`, on whatever feature."""
        if not self.named:
            return False
        return self.named[0] == self.hidden[0] if feature else self.named[0][0] == self.hidden[0][0]

    @property
    def in_first_tie(self) -> bool:
        return bool(self.ties) and self.hidden[0] in self.ties[0]

    @property
    def both(self) -> bool:
        return set(self.hidden) <= set(self.named)

    @property
    def mistaken(self) -> str | None:
        """A line that tells what was taken for what, unless all that was hidden, in any order, was named first."""
        if set(self.named[: len(self.hidden)]) == set(self.hidden):
            return None
        hidden = " + ".join(_words(each) for each in self.answer["effects"])
        named = " + ".join(_words(each) for each in self.diagnosis["effects"]) or "nothing"
        return f"{self.task.name} {self.answer['case']}: {hidden} taken for {named} ({self.diagnosis['verdict']})"


def _words(effect: dict[str, Any]) -> str:
    shape = f" ({effect['shape']})" if effect.get("shape") else ""
    return effect["name"] + (f" of {effect['feature']}" if effect["feature"] else "") + shape
