"""How probable each set of effects is, of all that were weighed."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import comb, logsumexp
from scipy.stats import chi2

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
    best: Weighed | None
    """The model of the most probable effects; None where more probably nothing in the catalogue is missing."""

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
        share = {names: float(np.exp(log - total)) for names, log in logs.items()}
        fits = {each: sorted(best.values(), key=lambda one: -one.evidence.at_least) for each, best in shapes.items()}
        return cls.among(share, fits)

    @classmethod
    def among(cls, share: dict[Names, float], fits: dict[Names, list[Weighed]]) -> "Posterior":
        """Of sets with these shares of the probability, and the fits of each."""
        total = sum(share.values())
        names = sorted(share, key=lambda each: -share[each])
        best = fits[names[0]][0] if names[0] and names[0] != OUTSIDE else None
        return cls({each: share[each] / total for each in names}, fits, best)

    def without(self, key: tuple) -> "Posterior":
        """The same if an effect of the best model is none: what the model has goes to that without the effect."""
        names = self.best.effects
        share = {each: p for each, p in self.probability.items() if each != names}
        if names - {key} in share:
            share[names - {key}] += self.probability[names]
        return self.among(share, self.shapes)

    def with_outside(self, outside: float) -> "Posterior":
        """The same with another probability that what is missing is outside the catalogue."""
        inside = 1 - self.outside
        if inside <= 0:
            return self
        share = {each: share * (1 - outside) / inside for each, share in self.probability.items()} | {OUTSIDE: outside}
        return replace(self, probability=dict(sorted(share.items(), key=lambda item: -item[1])))

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
    def outside(self) -> float:
        return self.probability[OUTSIDE]

    @property
    def credible(self) -> list[Names]:
        """The smallest set of models that is credible, should it be one of the catalogue."""
        inside = [each for each in self.probability if each != OUTSIDE]
        reached = np.cumsum([self.probability[each] for each in inside])
        return inside[: int(np.searchsorted(reached, SCORE.credible * reached[-1])) + 1] if inside else []

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
