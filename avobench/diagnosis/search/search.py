"""Which effects are missing: a beam search over sets of effects, all weighed by their evidence."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.candidates import PARENTS, Candidates, Weighed
from avobench.diagnosis.search.evidence import Scale
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect

PRICE = 8.0
"""What a further effect costs in log evidence at least: its strength, and its place among all sets."""


@dataclass(frozen=True)
class Search:
    """What a search for effects needs beside the model that it begins with."""

    target: Target
    x: NDArray
    """The measured events that are fitted (N, d)."""
    effects: list[Effect]
    max_effects: int
    rng: np.random.Generator
    effort: Effort
    jobs: int

    def posterior(self, null: Fit) -> Posterior:
        """Sets of effects that may be missing from a rejected model, with their probabilities."""
        scale, effects = Scale(self.target), [effect.adapted(self.x) for effect in self.effects]
        weighed = [Weighed(null, scale.of(null))]
        outside = scale.outside(null)
        beam = list(weighed)
        for size in range(self.max_effects):
            added = []
            for parent in beam[: PARENTS if size < 2 else 1]:
                beside = max(outside, *(one.evidence.at_least for one in weighed + added))
                if parent.effects and parent.evidence.value + parent.evidence.excess - PRICE < beside:
                    continue  # no further effect can make it the best
                free = [e for e in effects if e.key not in parent.effects]
                effort = self.effort.beside if parent.effects else self.effort
                added += Candidates(parent, scale, free, self.x, self.rng, effort, self.jobs).weighed(beside)
            weighed += added
            beam = self.foremost(added)
        return Posterior.of(weighed, outside, effects)

    def foremost(self, added: list[Weighed]) -> list[Weighed]:
        """The best model of each set of effects, of the best PARENTS sets."""
        best_last = sorted(added, key=lambda one: one.evidence.at_least)
        return list({one.effects: one for one in best_last}.values())[::-1][:PARENTS]


def widened(fit: Fit, target: Target, rng: np.random.Generator, effort: Effort) -> tuple[Fit, list[str]]:
    """The fit with the bound of its last effect's strength doubled, if it ended there and the bound is a guess."""
    effect = fit.model.effects[-1]
    at = fit.model.dim - len(effect.parameters)
    if not (effect.parameters[0].soft and fit.at_bound[at] > 0):
        return fit, []
    stretch = (*(fit.model.stretch or (1.0,) * len(fit.model.effects))[:-1], 2.0)
    model = replace(fit.model, stretch=stretch)
    again = refine(model, target, model.to_cube(fit.params), 0.1, rng, num_events=effort.least)
    return again, [f"the bound of {effect.name}: {effect.parameters[0].name} was doubled, since the fit ended there"]
