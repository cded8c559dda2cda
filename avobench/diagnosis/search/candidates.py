"""Which effect may a fitted model lack? All are screened, and what may be the answer is fitted with ever more events.

Successive halving: after each round a candidate stays if, for all that simulation leaves open, it may still matter
beside the best.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import descend
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.sharpening import sharpen
from avobench.diagnosis.search.evidence import TEMPERATURE, Evidence, evidence_of
from avobench.diagnosis.search.processes import in_processes
from avobench.diagnosis.search.screening import Look, Sample, closer, glance
from avobench.diagnosis.search.starts import Start, hidden, starts_of
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.tasks.meter import Meter

OF_ONE_FEATURE = 32
"""Effects of a catalogue, at most, where theta may hide one that is weak: several features tell them apart."""
MATTERS = 8.0
"""Difference of log evidence from which a model is fitted no further beside another, though its probability, which is
coarser, may not be small."""
LOOKED_AT = 2
"""Times as many shapes as fits that begin are looked at more closely."""
FURTHEST = 0.2
"""How far, in cube coordinates, theta follows an effect's strength within a first design: a fifth of the range, so that
the design stays inside the cube."""
FIRST_ROUNDS = 3
"""Of a fit that begins; enough to tell the promising ones."""
PARENTS = 3
"""Families that stay although they do not matter: to which a further effect may be added."""
MOST = (8, 6, 6)
"""Candidates that are left after each round of halving, at most."""
SHAPES_KEPT = 3
"""Of each family, in which fits go on: the plainest may be right, or need a parameter more, and families of many
shapes must not crowd out the others."""
NEARBY = 0.05
"""In cube coordinates: fits of one shape that are closer than that are one."""


@dataclass(frozen=True)
class Weighed:
    """A fitted model and its evidence."""

    fit: Fit
    evidence: Evidence
    resemblance: float = 0.0
    """Logarithm of how much the measured events look like its effects, on average."""

    @classmethod
    def of(cls, fit: Fit, like: dict[str, float] | None = None) -> "Weighed":
        """`like` is the logarithm of how much they look like each family, where that is known."""
        known = [like[effect.name] for effect in fit.model.effects] if like else []
        return cls(fit, evidence_of(fit), float(np.mean(known)) if known else 0.0)

    @property
    def effects(self) -> frozenset[tuple]:
        """What names it."""
        return frozenset(effect.key for effect in self.fit.model.effects)


@dataclass(frozen=True)
class Candidates:
    """The search for one more effect: what it adds to, and what all its parts need."""

    parent: Weighed
    """That one effect is added to."""
    target: Target
    effects: list[Effect]
    """Adapted to the measured events."""
    x: NDArray
    """The measured events that are fitted (N, d)."""
    rng: np.random.Generator
    effort: Effort
    jobs: int
    like: dict[str, float] = field(default_factory=dict)
    """Logarithm of how much the events look like each family."""

    @property
    def without(self) -> Fit:
        return self.parent.fit

    @cached_property
    def sample(self) -> Sample:
        """Events from which all effects are screened."""
        return Sample(self.without, self.target, self.effort.sample, self.rng)

    @cached_property
    def glances(self) -> list[Look]:
        """First looks at all effects in all shapes."""
        shapes = [shape for effect in self.effects for shape in effect.shapes()]
        looks = [glance(self.sample, shape, self.x, self.rng, self.effort) for shape in shapes]
        return [look for look in looks if look is not None]

    def promise(self, look: Look) -> float:
        """The Q that a look lets expect: lowest for what is most promising."""
        return float(look.expected(self.without)[0].min())

    def screened(self, glances: list[Look]) -> list[Start]:
        """Starts, most promising first, of what looked so at first, also beside other effects, which hardly matter."""
        free = {effect.key for effect in self.effects}
        best_first = sorted((look for look in glances if look.effect.key in free), key=self.promise)
        starts, all_alone = [], not self.parent.effects and len(self.effects) <= OF_ONE_FEATURE
        for first in best_first[: LOOKED_AT * self.effort.starts]:
            look = closer(self.sample, first, self.rng)
            own = starts_of(self.without, look)
            if all_alone and not look.guessed and any(look.effect is effect for effect in self.effects):
                own += hidden(self.sample, own[0], self.rng, self.effort)
            starts += own
        return sorted(starts, key=lambda start: start.expected)

    def hopeful(self, starts: list[Start]) -> list[Start]:
        """The best start of each shape, and one more elsewhere, where screening expects that it explains something."""
        kept: dict[tuple, list[Start]] = {}
        for start in starts:
            effect = start.model.effects[-1]
            own = kept.setdefault((effect.key, effect.shape), [])
            if start.expected < self.without.noiseless_q and len(own) < 2:
                own.append(start)
        first, second = ([own[k] for own in kept.values() if len(own) > k] for k in (0, 1))
        return [*first[: self.effort.starts], *second[: self.effort.starts // 4]]

    def weighed(self, glances: list[Look], beside: float) -> list[Weighed]:
        """The model with one more effect, fitted: all that may matter beside a log evidence of `beside`."""
        return self.told_apart(self.hopeful(self.screened(glances)), beside)

    def told_apart(self, starts: list[Start], beside: float) -> list[Weighed]:
        """Fits from these starts, with more and more events, of those that may matter beside each other.

        Where few events may be simulated, half of them are for fits that begin, of the best starts first, and what was
        fitted when they end is weighed.
        """
        meter = self.without.model.events.meter if self.without.model.events is not None else Meter()
        with meter.keeping(max(meter.remaining or 0, 0) // 2):
            begun = [fit for fit in self.work(begin, starts, self.effort.fit) if fit is not None]
        fits = distinct(sorted(begun, key=lambda fit: fit.noiseless_q))[: self.effort.begun]
        found: list[Weighed] = []
        for (ratio, rounds), most in zip(self.effort.rounds_of_search, MOST, strict=True):
            events = int(ratio * max(self.target.num_events, self.effort.few))
            more = self.work(go_on, fits, events, rounds)
            if None in more:
                break
            settled = bool(found)  # a first fit may have far to go: the best of them stay, however far
            found = sorted((Weighed.of(fit, self.like) for fit in more), key=worth)
            found = (self.matter(found, beside) if settled else found)[:most]
            fits = [one.fit for one in found]
        return found or self.matter((Weighed.of(fit, self.like) for fit in fits), beside)[: MOST[0]]

    @cached_property
    def known(self) -> KnownModel:
        """What effects are added to: what it makes is the same noise for all."""
        return self.without.known(self.target, int(self.effort.known * self.target.num_events), self.rng)

    def work(self, fitting: Callable[..., Fit], begun: list, *how: int) -> list[Fit | None]:
        """The fits of all, from one seed, by so many processes as were asked for; None where events end."""
        seed = int(self.rng.integers(2**63))
        calls = [(one, self.known, self.target, np.random.default_rng(seed), *how) for one in begun]
        return in_processes(self.jobs, self.without.model.events, fitting, calls)

    def matter(self, found: Iterable[Weighed], beside: float) -> list[Weighed]:
        """Those that may matter beside the best of them, or beside another model, best first.

        The best few families stay, since further effects may be added to them.
        """
        found = sorted(found, key=worth)
        least = max([beside, *(one.evidence.at_least for one in found)]) - MATTERS
        firsts = list({one.effects: one for one in reversed(found)}.values())[::-1][:PARENTS]
        return [one for one in found if one.evidence.at_most > least or any(one is first for first in firsts)]


def worth(one: Weighed) -> float:
    """Lowest for what is worth most: whether it is known well, further events tell."""
    return -one.evidence.value - TEMPERATURE * one.resemblance


def begin(start: Start, known: KnownModel, target: Target, rng: np.random.Generator, num_events: int) -> Fit:
    """The first steps of a fit of theta and the effects' parameters together."""
    model = start.model
    last = model.dim - len(model.effects[-1].parameters)
    half = np.full(model.dim, 0.08)
    half[:last] = 0.02
    half[last] = max(start.near, 1e-4)
    design = known.design(start.point, half)
    shear = np.zeros_like(design.axes)
    shear[:last, last] = np.clip(start.along * half[last], -FURTHEST, FURTHEST)
    design = replace(design, axes=design.axes + shear)
    return descend(model, target, design, rng, num_events, FIRST_ROUNDS, known)


def go_on(fit: Fit, known: KnownModel, target: Target, rng: np.random.Generator, num_events: int, rounds: int) -> Fit:
    """The same fit with more events, until it stands still."""
    return sharpen(fit, target, rng, num_events, rounds, known)


def distinct(fits: list[Fit]) -> list[Fit]:
    """Of fits, best first, each once, and of each family the best SHAPES_KEPT."""
    kept: list[Fit] = []
    for fit in fits:
        own = [one for one in kept if one.model.effects[-1].key == fit.model.effects[-1].key]
        if len(own) < SHAPES_KEPT and not any(same(fit, one) for one in own):
            kept.append(fit)
    return kept


def same(fit: Fit, other: Fit) -> bool:
    """Whether two fits are of one shape and close to each other."""
    effect, than = fit.model.effects[-1], other.model.effects[-1]
    if (effect.key, effect.shape) != (than.key, than.shape):
        return False
    return bool(np.abs(fit.point - other.point).max() < NEARBY)
