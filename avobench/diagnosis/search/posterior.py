"""How probable each set of effects is, of all that were weighed."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import comb, logsumexp
from scipy.stats import chi2

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.evidence import Evidence, Weighed
from avobench.diagnosis.settings import SCORE
from avobench.effects import Effect

Names = frozenset[tuple]
"""The effects of a model, by their keys; empty for the simulator as it is."""


@dataclass(frozen=True)
class Posterior:
    """Sets of effects that were weighed, and how probable each is beside others and what is outside the catalogue.

    A conditional logit: see `SCORE.sharpness`, and what follows it.
    """

    shares: dict[Names, float]
    """Of each set, by its evidence and what the events look like; together 1."""
    shapes: dict[Names, list[Weighed]]
    """The fits of each set, a shape each, best first."""
    beyond: float = 0.0
    """What outside the catalogue weighs beside the sets, by `goodness_of_fit.outside`; 0 until the best is tested."""

    @classmethod
    def of(cls, weighed: Iterable[Weighed], catalogue: list[Effect]) -> "Posterior":
        """Of all models that were weighed, each shape once."""
        shapes: dict[Names, dict[tuple, Weighed]] = {}
        for one in weighed:
            each = tuple(sorted((str(effect.key), effect.shape) for effect in one.fit.model.effects))
            best = shapes.setdefault(one.effects, {})
            if each not in best or best[each].evidence.at_least < one.evidence.at_least:
                best[each] = one
        prior = Prior.of(catalogue)
        to_explain = max((one.evidence.excess for one in shapes.get(frozenset(), {}).values()), default=0.0)
        logs = {}
        for names, best in shapes.items():
            values = [tempered(one.evidence, to_explain) for one in best.values()]
            logs[names] = float(logsumexp(values)) + prior.log(names) / SCORE.temperature
        logs |= pooled(
            {each: (logs[each], next(iter(best.values())).resemblance) for each, best in shapes.items() if each}
        )
        total = logsumexp(list(logs.values()))
        share = {names: float(np.exp(log - total)) for names, log in logs.items()}
        fits = {each: sorted(best.values(), key=lambda one: -one.evidence.at_least) for each, best in shapes.items()}
        return cls(share, fits)

    @cached_property
    def weights(self) -> dict[Names, float]:
        """What each set weighs, most first."""
        weights = {
            names: share**SCORE.sharpness * (np.exp(SCORE.several) if len(names) > 1 else 1.0)
            for names, share in self.shares.items()
        }
        return dict(sorted(weights.items(), key=lambda item: -item[1]))

    @property
    def total(self) -> float:
        """What all sets weigh, with other sets and what is outside the catalogue."""
        return sum(self.weights.values()) + np.exp(SCORE.others) + self.beyond

    @property
    def probability(self) -> dict[Names, float]:
        """Of each set, most probable first."""
        return {names: float(weight / self.total) for names, weight in self.weights.items()}

    @property
    def others(self) -> float:
        """The probability of sets of effects of the catalogue that are none of these."""
        return float(np.exp(SCORE.others) / self.total)

    @property
    def outside(self) -> float:
        """The probability that what is missing is outside the catalogue."""
        return float(self.beyond / self.total)

    @property
    def best(self) -> Weighed | None:
        """The model of the most probable effects; None where more probably none is missing."""
        names = next(iter(self.weights))
        return self.shapes[names][0] if names else None

    def without(self, key: tuple) -> "Posterior":
        """The same if an effect of the best model is none: what the model has goes to that without the effect."""
        names = self.best.effects
        shares = {each: share for each, share in self.shares.items() if each != names}
        if names - {key} in shares:
            shares[names - {key}] += self.shares[names]
        total = sum(shares.values())
        return replace(self, shares={each: share / total for each, share in shares.items()})

    def unsupported(self, fit: Fit, refit: Callable[[Fit], Fit]) -> tuple | None:
        """The key of the least supported effect of a fit that does not count; None if each does.

        An effect counts if its size is not compatible with none, or if it explains more than chance. What it explains
        is by how much chi-squared falls below that of the best fit without it, which `refit` makes as good as this one.
        Both are told in units of what chi-squared of this fit is for each degree of freedom.
        """
        keys, scale = {effect.key for effect in fit.model.effects}, np.sqrt(max(1.0, fit.q / max(fit.dof, 1)))
        chances = {None: SCORE.chance}
        for k, effect in enumerate(fit.model.effects):
            at, strength = fit.model.columns(k).start, effect.parameters[0]
            if abs(fit.params[at] - strength.null) >= SCORE.sized * scale * fit.std[at]:
                continue
            others = [one.fit for names, fits in self.shapes.items() if names <= keys - {effect.key} for one in fits]
            without = refit(min(others, key=lambda one: one.noiseless_q))
            explained = (without.noiseless_q - fit.noiseless_q) / scale**2
            chances[effect.key] = float(chi2.sf(explained, len(effect.parameters)))
        return max(chances, key=chances.get)

    @property
    def credible(self) -> list[Names]:
        """The smallest set of models that is credible, should it be one of these."""
        reached = np.cumsum(list(self.weights.values()))
        return list(self.weights)[: int(np.searchsorted(reached, SCORE.credible * reached[-1])) + 1]

    def rivals(self, k: int) -> list[tuple]:
        """Effects in credible models that lack the k-th of the named ones, but for the named ones: by key."""
        model = self.best.fit.model
        names, key = {effect.key for effect in model.effects}, model.effects[k].key
        others = [each for each in self.credible if key not in each]
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
            for key in names:
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
        # One family may act on two features, so that there are more effects than families.
        sets = max(comb(len(self.odds), k), 1) * (all_odds / len(self.odds)) ** k if k else 1
        each = sum(np.log(self.odds[name] / self.choices[name] / self.shapes[name, on]) for name, on in names)
        return float(np.log(SCORE.number[min(k, len(SCORE.number) - 1)]) - np.log(sets) + each)
