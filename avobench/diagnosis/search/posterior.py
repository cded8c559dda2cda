"""How probable each set of effects is, of all that were weighed."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import comb, logsumexp

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.evidence import Evidence, Weighed
from avobench.diagnosis.settings import SCORE
from avobench.effects import Effect

Names = frozenset[tuple]
"""The effects of a model, by their keys; empty for the simulator as it is."""
OUTSIDE: Names = frozenset({("outside",)})
"""That what is missing is not in the catalogue."""


@dataclass(frozen=True)
class Posterior:
    """Probabilities of sets of effects, most probable first, and the fits of each."""

    probability: dict[Names, float]
    shapes: dict[Names, list[Weighed]]
    """The fits of each set, a shape each, best first."""

    @classmethod
    def of(cls, weighed: Iterable[Weighed], outside: float, catalogue: list[Effect]) -> "Posterior":
        """Of all models that were weighed, each shape once."""
        shapes: dict[Names, dict[tuple, Weighed]] = {}
        for one in weighed:
            each = tuple(sorted((str(effect.key), effect.shape) for effect in one.fit.model.effects))
            best = shapes.setdefault(one.effects, {})
            if each not in best or best[each].evidence.at_least < one.evidence.at_least:
                best[each] = one
        prior = Prior.of(catalogue)
        to_explain = max((one.evidence.excess for one in shapes.get(frozenset(), {}).values()), default=0.0)
        logs = {OUTSIDE: (outside + np.log(SCORE.unknown)) / SCORE.temperature}
        for names, best in shapes.items():
            values = [tempered(one.evidence, to_explain) for one in best.values()]
            logs[names] = float(logsumexp(values)) + prior.log(names) / SCORE.temperature
        logs |= pooled(
            {each: (logs[each], next(iter(best.values())).resemblance) for each, best in shapes.items() if each}
        )
        total = logsumexp(list(logs.values()))
        share = {names: (1 - SCORE.imitated) * np.exp(log - total) for names, log in logs.items()}
        share[OUTSIDE] += SCORE.imitated
        names = sorted(share, key=lambda each: -share[each])
        fits = {each: sorted(best.values(), key=lambda one: -one.evidence.at_least) for each, best in shapes.items()}
        return cls({each: float(share[each]) for each in names}, fits)

    @property
    def outside(self) -> float:
        return self.probability[OUTSIDE]

    @property
    def looks(self) -> dict[Names, float]:
        """The probabilities without that of what is outside the catalogue and looks like it."""
        return {**self.probability, OUTSIDE: self.outside - SCORE.imitated}

    @property
    def credible(self) -> list[Names]:
        """The smallest set of models that is credible, but for the probability of what looks like them."""
        looks = self.looks
        ordered = sorted(looks, key=lambda each: -looks[each])
        reached = np.cumsum([looks[each] for each in ordered])
        return ordered[: int(np.searchsorted(reached, SCORE.credible * reached[-1])) + 1]

    @property
    def best(self) -> Weighed | None:
        """The model of the most probable effects; None where more probably nothing in the catalogue is missing.

        What only looks like the catalogue speaks against all names alike, and is no reason for another.
        """
        first = max(self.looks, key=self.looks.get)
        return self.shapes[first][0] if first and first != OUTSIDE else None

    def rivals(self, k: int) -> list[tuple]:
        """Effects in credible models that lack the k-th of the named ones, but for the named ones: by key."""
        model = self.best.fit.model
        names, key = {effect.key for effect in model.effects}, model.effects[k].key
        others = [each for each in self.credible if each != OUTSIDE and key not in each]
        return [one for one in self.included if one not in names and any(one in each for each in others)]

    @property
    def allowed(self) -> list[Fit]:
        """The fits of credible models beside the named one: in other shapes, or with other effects."""
        return [
            one.fit
            for each in self.credible
            for one in self.shapes.get(each, [])
            if one is not self.best and one.fit.model.effects
        ]

    @property
    def single(self) -> list[Weighed]:
        """The best fit with each effect alone, best first."""
        fits = [best[0] for names, best in self.shapes.items() if len(names) == 1]
        return sorted(fits, key=lambda one: -one.evidence.at_least)

    @property
    def included(self) -> dict[tuple, float]:
        """By effect: the probability that it is in the model; most probable first."""
        shares: dict[tuple, float] = {}
        for names, share in self.probability.items():
            for key in names - OUTSIDE:
                shares[key] = shares.get(key, 0.0) + share
        return dict(sorted(shares.items(), key=lambda item: -item[1]))


def tempered(evidence: Evidence, to_explain: float) -> float:
    """A log evidence, of which the price of what is free has SCORE.temperature, and what the fit leaves a coarser one.

    `to_explain` is the excess of the simulator as it is.
    """
    price = evidence.value + evidence.excess
    explained = 2 * max(to_explain - evidence.excess, 0)
    return price / SCORE.temperature - evidence.excess / (SCORE.temperature + SCORE.coarse * explained)


def pooled(opinions: dict[Names, tuple[float, float]]) -> dict[Names, float]:
    """Log weights of sets of effects by two opinions: what the fits say, and what the events look like.

    Together the sets keep what the fits give them: how probable it is that nothing in the catalogue is missing, what
    the events look like does not say.
    """
    if not any(looks for _, looks in opinions.values()):
        return {names: fitted for names, (fitted, _) in opinions.items()}
    both = {names: SCORE.opinion * (fitted + looks) for names, (fitted, looks) in opinions.items()}
    kept = logsumexp([fitted for fitted, _ in opinions.values()]) - logsumexp(list(both.values()))
    return {names: float(log + kept) for names, log in both.items()}


@dataclass(frozen=True)
class Prior:
    """What is held of sets of effects beforehand: families by their odds, features of one and its shapes alike."""

    odds: dict[str, float]
    """By family."""
    choices: dict[str, int]
    """Features that a family may act on."""
    shapes: dict[tuple, int]
    """Of an effect, by its key."""

    @classmethod
    def of(cls, catalogue: list[Effect]) -> "Prior":
        """Of the effects that may be missing. Classes of one name are one family, with the odds and shapes of all."""
        odds: Counter[str] = Counter()
        shapes: Counter[tuple] = Counter()
        for effect in {type(effect): effect for effect in catalogue}.values():
            odds[effect.name] += effect.odds
        for effect in catalogue:
            shapes[effect.key] += len(effect.shapes())
        return cls(odds, Counter(name for name, _ in shapes), shapes)

    def log(self, names: Names) -> float:
        """Logarithm of the probability of a set of effects in given shapes."""
        k, all_odds = len(names), sum(self.odds.values())
        sets = comb(len(self.odds), k) * (all_odds / len(self.odds)) ** k if k else 1
        each = sum(np.log(self.odds[name] / self.choices[name] / self.shapes[name, on]) for name, on in names)
        return float(np.log(SCORE.number[min(k, len(SCORE.number) - 1)]) - np.log(sets) + each)
