"""Which effects are missing: a beam search over sets of effects, all weighed by their evidence."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort, Phases
from avobench.diagnosis.experience.recogniser import resemblance
from avobench.diagnosis.fit.descent import refine, sharpen
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.candidates import Candidates, Weighed, cost
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.search.screening import Start
from avobench.diagnosis.settings import BUDGET, FIT, SCORE, SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.model import Model
from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.meter import Meter


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
    phases: Phases | None = None
    """What is told which effect is looked for."""
    experience: bool = True
    """Whether the networks are asked what the events look like."""
    features: Sequence[int] | None = None
    """The features on which effects are looked for, beside effects on all of them; None for each."""

    def posterior(self, null: Fit) -> Posterior | None:
        """Sets of effects that may be missing from a rejected model, with their probabilities.

        Where the simulated events end, those that were weighed until then; None if they end before any was.
        """
        effects = [effect.adapted(self.x) for effect in self.effects if self.looks_at({effect.feature})]
        weighed, dropped = [Weighed.of(null)], []
        meter = null.model.events.meter if null.model.events is not None else Meter()
        like = resemblance(null.model.task, effects, self.x, None)
        with suppress(BudgetExhausted):
            like = self.like(null.model, null.params)
            self.extend(weighed, dropped, effects, like)
        sets = {one.effects for one in weighed}
        weighed += [one for one in dropped if one.effects not in sets]
        return Posterior.of(weighed, effects, like) if len(weighed) > 1 or not meter.refused else None

    def like(self, model: Model, theta: NDArray[np.float64]) -> dict[str, float]:
        """Logarithm of how much the events look like each family, beside those of a model at theta (p,)."""
        rng = self.rng.spawn(1)[0]
        make = (lambda n: model.simulate(np.tile(theta, (n, 1)), rng)) if self.experience else None
        return resemblance(model.task, self.effects, self.x, make)

    def extend(
        self, weighed: list[Weighed], dropped: list[Weighed], effects: list[Effect], like: dict[str, float]
    ) -> None:
        """Extend the models `weighed`, at first the null alone, by all that may matter: an effect more in each round.

        Models that fall behind go to `dropped`, and no effect is added to them. They may be right all the same, as no
        shape is exactly that of nature. Raises BudgetExhausted where the simulated events end.
        """
        first, beam = self.candidates(weighed[0], effects, like), weighed[:1]
        shapes = [shape for effect in effects for shape in effect.shapes() if self.looks_at(named(shape))]
        guesses = [(shape, shape.guess(self.x)) for shape in shapes]
        for size in range(1, self.max_effects + 1):
            added = []
            for parent in beam[: SEARCH.parents if size == 2 else 1]:
                beside = max(one.evidence.value for one in weighed)
                if size > 1 and parent.evidence.value + parent.evidence.excess - SCORE.indifferent < beside:
                    continue  # no further effect can make it the best
                if self.phases is not None:
                    self.phases.begin(f"search for effect {size}")
                if size == 1:
                    looks = first.glances(guesses)
                search = self.candidates(parent, effects, like) if size > 1 else first
                larger, smaller = search.weighed(looks, beside)
                added += larger
                weighed += larger
                dropped += smaller
            beam = self.foremost(added)
            if size == 2 and beam:  # each of the two may describe the events alone: fitted from its values in the pair
                weighed += first.halved([start_without(beam[0].fit, k) for k in (0, 1)], -np.inf)[0]

    def looks_at(self, features: set[int | str | None]) -> bool:
        """Whether effects are looked for on all single features among these."""
        return self.features is None or {j for j in features if isinstance(j, int)} <= set(self.features)

    def candidates(self, parent: Weighed, effects: list[Effect], like: dict[str, float]) -> Candidates:
        """Those to add to a model."""
        free = [effect for effect in effects if effect.key not in parent.effects]
        effort = self.effort.beside if parent.effects else self.effort
        return Candidates(parent, self.target, free, self.rng, effort, self.jobs, like)

    def foremost(self, added: list[Weighed]) -> list[Weighed]:
        """The best model of each set of effects, of the best SEARCH.parents sets."""
        best_last = sorted(added, key=cost)[::-1]
        return list({one.effects: one for one in best_last}.values())[::-1][: SEARCH.parents]


def named(shape: Effect) -> set[int | str | None]:
    """The single features that the name of a shape holds, as "x1 x3" does."""
    return {int(number) - 1 for number in re.findall(r"\bx(\d+)\b", shape.shape)}


def start_without(fit: Fit, k: int) -> Start:
    """A start without the k-th effect: other parameters keep their values, and are searched for within their errors."""
    model, gone = fit.model.minus(k), fit.model.columns(k)
    kept = np.delete(np.arange(fit.model.dim), np.arange(gone.start, gone.stop))
    half = FIT.min_sigmas * np.sqrt(np.diag(fit.point_covariance))[kept]
    point, last = fit.point[kept], model.columns(0).start
    return Start(model, point, np.nan, half[last], half=np.minimum(half, SEARCH.first_half))


def refined(fit: Fit, target: Target, rng: np.random.Generator, effort: Effort) -> tuple[Fit, list[str]]:
    """The fit of the effects that were named, with more events; and notes.

    The bound of a strength is doubled if the fit ended there and the bound is a guess.
    """
    notes = []
    for k, effect in enumerate(fit.model.effects):
        if effect.parameters[0].soft and fit.at_bound[fit.model.columns(k).start] > 0:
            stretch = list(fit.model.stretch or (1.0,) * len(fit.model.effects))
            stretch[k] = 2.0
            model = replace(fit.model, stretch=tuple(stretch))
            fit = refine(model, target, model.to_cube(fit.params), 0.1, rng, num_events=effort.least)
            name = f"{effect.name}: {effect.parameters[0].name}"
            notes.append(f"the bound of {name} was doubled, since the fit ended there")
    ratio, _ = effort.rounds_of_search[-1]
    again = sharpen(fit, target, rng, int(ratio * target.num_events), BUDGET.refined)
    return min(again, fit, key=lambda fit: fit.noiseless_q + fit.noiseless_q_error), notes
