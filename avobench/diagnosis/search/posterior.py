"""How probable each set of effects is, of all that were weighed."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import comb, logsumexp
from scipy.stats import chi2

from avobench.diagnosis.experience.recogniser import OUTSIDE
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.evidence import Weighed
from avobench.diagnosis.settings import SCORE
from avobench.effects import Effect

LIKENESS = 2
"""The column of the likeness among the covariates. *Something outside the catalogue* has this covariate alone."""
Names = frozenset[tuple]
"""The effects of a model, by their keys; empty for the simulator as it is."""


@dataclass(frozen=True)
class Posterior:
    """Sets of effects that were weighed, and how probable each is beside others and what is outside the catalogue.

    A conditional logit: see `SCORE.decision`, and what follows it.
    """

    weights: dict[Names, float]
    """What each set weighs, most first."""
    shapes: dict[Names, list[Weighed]]
    """The fits of each set, a shape each, best first."""
    covariates: dict[Names, NDArray[np.float64]] = field(default_factory=dict)
    """Of each set in the logit: (7,)."""
    looks_outside: float = -np.inf
    """Logarithm of how much the events look like what is outside the catalogue."""

    @classmethod
    def of(cls, weighed: Iterable[Weighed], catalogue: list[Effect], like: dict[str, float]) -> "Posterior":
        """Of all models that were weighed, each shape once; `like` is the logarithm of how much they look like each."""
        shapes: dict[Names, dict[tuple, Weighed]] = {}
        for one in weighed:
            each = tuple(sorted((str(effect.key), effect.shape) for effect in one.fit.model.effects))
            best = shapes.setdefault(one.effects, {})
            if each not in best or best[each].evidence.at_least < one.evidence.at_least:
                best[each] = one
        fits = {each: sorted(best.values(), key=lambda one: -one.evidence.at_least) for each, best in shapes.items()}
        covariates = covariates_of(fits, Prior.of(catalogue))
        weights = {
            names: float(np.exp(each @ SCORE.decision + of_families(names))) for names, each in covariates.items()
        }
        return cls(_most_first(weights), fits, covariates, like[OUTSIDE])

    @property
    def outside_weight(self) -> float:
        """The weight of *something outside the catalogue*, on the scale of the weights of the sets."""
        return float(np.exp(SCORE.outside + SCORE.decision[LIKENESS] * self.looks_outside))

    @property
    def total(self) -> float:
        """What all sets weigh, with other sets and what is outside the catalogue."""
        return sum(self.weights.values()) + np.exp(SCORE.others) + self.outside_weight

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
        return float(self.outside_weight / self.total)

    @property
    def best(self) -> Weighed | None:
        """The model of the most probable effects; None where more probably none is missing."""
        names = next(iter(self.weights))
        return self.shapes[names][0] if names else None

    def without(self, key: tuple) -> "Posterior":
        """The same without its best set, whose weight goes to that set without `key`, if that was weighed."""
        names = self.best.effects
        weights = {each: weight for each, weight in self.weights.items() if each != names}
        if names - {key} in weights:
            weights[names - {key}] += self.weights[names]
        return replace(self, weights=_most_first(weights))

    def unsupported(self, fit: Fit, refit: Callable[[Fit], Fit]) -> tuple | None:
        """The key of the least supported effect among those of a fit that do not count, or None.

        An effect counts if its size is not compatible with none, or if it explains more than chance. What it explains
        is by how much chi-squared falls below that of the best fit without it, which `refit` makes as good as this one.
        The size is divided by the root of chi-squared per degree of freedom, the explained chi-squared by that ratio.
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
        """The smallest set of models with SCORE.credible of the weight of all that were weighed."""
        reached = np.cumsum(list(self.weights.values()))
        return list(self.weights)[: int(np.searchsorted(reached, SCORE.credible * reached[-1])) + 1]

    def rivals(self, k: int) -> list[tuple]:
        """Keys of effects that are not named, but are in a credible model without the k-th named effect."""
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


def covariates_of(fits: dict[Names, list[Weighed]], prior: "Prior") -> dict[Names, NDArray[np.float64]]:
    """The covariates of each set of effects in the logit, in the order of `SCORE.decision`: (7,).

    These are how much its log evidence falls short of the best, as -ln(1 + deficit), since no shape of the catalogue is
    exactly that of nature; the log prior; how much the events look like its effects; whether it has more than one; how
    far down the list of its family its shape is; the logarithm of the number of its fit's events, as a share of the
    largest; and how far it is from describing the events, as -ln(Q / dof) where Q is larger than dof. The simulator as
    it is has no shape, so that its deficit counts in full.
    """
    values = {names: logsumexp([one.evidence.value for one in some]) for names, some in fits.items()}
    most, looks = max(values.values()), [some[0].resemblance for names, some in fits.items() if names]
    events = max((some[0].fit.num_events for names, some in fits.items() if names), default=1)
    covariates = {}
    for names, (best, *_) in fits.items():
        deficit, log, fit = most - values[names], prior.log(names), best.fit
        if names:
            kind = best.resemblance, len(names) > 1, -prior.plainness(best)
            reached = np.log(fit.num_events / events), -np.log(max(fit.noiseless_q / max(fit.dof, 1), 1))
            row = -np.log1p(deficit), log, *kind, *reached
        else:
            row = -deficit, log, np.mean(looks or [0.0]), 0, 0, 0, 0
        covariates[names] = np.array(row, dtype=float)
    return covariates


def of_families(names: Names) -> float:
    """Log weight of what is missing more often, or seldom, than others; effects of a user's have none."""
    return sum(SCORE.families.get(name, 0.0) for name, _ in names)


def _most_first(weights: dict[Names, float]) -> dict[Names, float]:
    return dict(sorted(weights.items(), key=lambda item: -item[1]))


@dataclass(frozen=True)
class Prior:
    """What is held of sets of effects beforehand: families by their odds, features of one and its shapes alike."""

    odds: dict[str, float]
    """By family."""
    choices: dict[str, int]
    """Features that a family may act on."""
    shapes: dict[tuple, list[str]]
    """Of an effect, by its key, the plainest first."""

    @classmethod
    def of(cls, catalogue: list[Effect]) -> "Prior":
        """Of the effects that may be missing. Classes of one name are one family, with the odds and shapes of all."""
        odds: Counter[str] = Counter()
        shapes: dict[tuple, list[str]] = defaultdict(list)
        for effect in {type(effect): effect for effect in catalogue}.values():
            odds[effect.name] += effect.odds
        for effect in catalogue:
            shapes[effect.key] += [each.shape for each in effect.shapes()]
        return cls(odds, Counter(name for name, _ in shapes), shapes)

    def log(self, names: Names) -> float:
        """Logarithm of the probability of a set of effects in given shapes."""
        k, all_odds = len(names), sum(self.odds.values())
        # One family may act on two features, so that there are more effects than families.
        sets = max(comb(len(self.odds), k), 1) * (all_odds / len(self.odds)) ** k if k else 1
        each = sum(np.log(self.odds[name] / self.choices[name] / len(self.shapes[name, on])) for name, on in names)
        return float(np.log(SCORE.number[min(k, len(SCORE.number) - 1)]) - np.log(sets) + each)

    def plainness(self, one: Weighed) -> float:
        """The mean place of the shapes of a model in the lists of their families: 0 if all are the plainest."""
        effects = one.fit.model.effects
        return float(np.mean([min(self.shapes[each.key].index(each.shape), SCORE.special) for each in effects]))
