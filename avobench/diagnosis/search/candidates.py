"""Which effect is missing? Every shape of every candidate is screened, and the promising ones fitted with theta.

From `candidates` downwards: screen, begin, go on, repeat with more events, settle what is tied.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.sharpening import settled, sharpen
from avobench.diagnosis.search.alike import distinct, going_on
from avobench.diagnosis.search.features import excess_by_feature, open_features
from avobench.diagnosis.search.joint import AGAIN, STRONG, continued, joint
from avobench.diagnosis.search.processes import in_processes
from avobench.diagnosis.search.ranking import likely, ranking
from avobench.diagnosis.search.starts import ROUGH, Sample, Start, hidden, screen, searched
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.tasks.errors import BudgetExhausted

MOST_SCREENED = 32
"""Effects of which all shapes are screened. Above that, where several features have their own entries in the catalogue,
it would take longer than all fits."""
OF_FEATURE = 2
"""Families of each feature that are fitted for what it shows by itself: what bounds the time."""
SHAPES_AGAIN = 2
"""Fits of a family that are repeated with more events, of other shapes first."""
MOST_AGAIN = 8
"""Fits that are repeated with more events, in all: what bounds the time. Chosen by trial."""
MOST_FINAL = 4
"""Families that are told apart with yet more events: what bounds the time."""
ON_ALL = 6
"""Families of one feature, best first, that are tried on all features alike."""
WEAK = 10.0
"""Twice 5: the standard error of Q by simulation, sqrt(2 r n^2 + 4 Q n) with the noise n and the rank r, is kept to a
fifth of what Q exceeds its degrees of freedom by."""
MOST_EVENTS = 4
"""Simulated events a measured one, at most, that the last rule may ask for."""


@dataclass(frozen=True)
class Candidates:
    """The search for one more effect: what it adds to, and what all its parts need."""

    without: Fit
    """That one effect is added to."""
    target: Target
    effects: list[Effect]
    """Adapted to the measured events."""
    x: NDArray
    """The measured events that are fitted (N, d)."""
    rng: np.random.Generator
    effort: Effort
    jobs: int

    def screened(self) -> tuple[list[list[Start]], dict[tuple, list[Start]]]:
        """The best starts of each family, most promising family first, and starts in their other shapes, by key."""
        sample = Sample(self.without, self.target, self.effort.sample, self.rng)
        plain = {effect.key: screen(sample, effect, self.x, self.rng, self.effort) for effect in self.effects}
        families, spare = [], {}
        for effect in self._best_first(plain):
            starts, far = self._starts(effect, plain[effect.key], sample)
            # The plainest shape always has its fit: screening is too rough to prefer another to it.
            first, rest = starts[:1], sorted(starts[1:], key=lambda start: start.expected)
            families.append([*first, *rest[: self.effort.starts - 1], *far])
            fitted = {start.model.effects[-1].shape for start in families[-1]}
            shapes = {start.model.effects[-1].shape: start for start in reversed(rest)}
            spare[effect.key] = [start for shape, start in shapes.items() if shape not in fitted]
        families = sorted(filter(None, families), key=lambda starts: min(start.expected for start in starts))
        return families, spare

    def _best_first(self, plain: dict[tuple, list[Start]]) -> list[Effect]:
        """The effects of which every shape is looked at: those promising in their plainest, and all if they are few."""
        best_first = sorted(self.effects, key=lambda e: min((s.expected for s in plain[e.key]), default=np.inf))
        if len(self.effects) <= MOST_SCREENED:
            return best_first
        own = excess_by_feature(self.without, self.target)
        worst = max(own, key=own.get, default=None)
        return sorted(best_first, key=lambda e: e.feature not in (worst, "all"))[:MOST_SCREENED]

    def _starts(self, effect: Effect, plain: list[Start], sample: Sample) -> tuple[list[Start], list[Start]]:
        """Starts of every shape of an effect, those of the plainest (`plain`) first; and starts far from its null."""
        few = len(self.effects) <= MOST_SCREENED
        strong = self.without.noiseless_q > STRONG * self.without.dof
        starts, far = [], []
        for k, shape in enumerate(effect.shapes()):
            own = plain if k == 0 else screen(sample, shape, self.x, self.rng, self.effort)
            if own and strong and (k == 0 or few):
                own = [*own, searched(self.without, self.target, shape, self.rng, self.effort)]
            if own and few and shape.guess(self.x) is None:
                far += hidden(sample, own[0], self.rng, self.effort)
            starts += sorted(own, key=lambda start: start.expected)
        return starts, far

    def chosen(self, families: list[list[Start]]) -> list[Start]:
        """The starts of the families that are fitted.

        Each feature that shows something of its own has its best families, whatever another one shows.
        """
        own = [
            starts
            for feature in open_features(self.without, self.target)
            for starts in [starts for starts in families if starts[0].model.effects[-1].feature == feature][:OF_FEATURE]
        ][: self.effort.families // 2]
        others = [starts for starts in families if all(starts is not one for one in own)]
        return [start for starts in [*own, *others][: self.effort.families] for start in starts]

    def begun(self, starts: list[Start], known: KnownModel) -> list[Fit]:
        """The first steps of a fit from each start."""
        streams = self.rng.spawn(len(starts))  # so that any number of workers gives the same fits
        calls = zip(starts, streams, strict=True)
        return self.work(joint, [(start, known, self.target, stream, self.effort.fit // 2) for start, stream in calls])

    def further(self, fits: list[Fit], spare: dict[tuple, list[Start]]) -> list[Start]:
        """More starts: the family that seems best in any of its shapes, and on all features what acts on one."""
        if not fits:
            return []
        foremost = sorted(fits, key=lambda fit: fit.noiseless_q)
        best = foremost[0].model.effects[-1]
        return spare[best.key] + on_all(distinct(foremost, 1)[:ON_ALL], self.effects)

    def gone_on(self, fits: list[Fit], starts: list[Start], known: KnownModel) -> list[Fit]:
        """The fits that go on, until they stand still."""
        fits = going_on(fits, [start.expected for start in starts])
        streams, enough = self.rng.spawn(len(fits)), self.enough
        calls = zip(fits, streams, strict=True)
        return self.work(continued, [(fit, known, self.target, stream, enough, self.effort) for fit, stream in calls])

    @property
    def enough(self) -> int:
        """Events for a fit: a weak effect is not seen in fits whose noise is as large as what it leaves."""
        beyond = max(self.without.noiseless_q - self.without.dof, 1.0)
        noise = beyond**2 / (WEAK * np.sqrt(2 * self.target.rank) * beyond + WEAK**2 * self.without.noiseless_q)
        needed = self.target.num_events / noise
        least = self.effort.fit
        return int(np.clip(needed, least, max(least, MOST_EVENTS * self.target.num_events)))

    def repeated(
        self, fits: list[Fit], known: KnownModel, hopeful: Callable[[Fit], bool], q_without: float
    ) -> list[Fit]:
        """The fits, of which those that may still be the best are repeated with more events, if one is `hopeful`."""
        seed, many = int(self.rng.integers(2**63)), max(self.target.num_events, self.effort.few)
        for ratio in self.effort.again:
            fits = distinct(fits)
            if not any(hopeful(fit) for fit in fits):
                return fits
            best = min(fits, key=lambda fit: fit.noiseless_q + fit.noiseless_q_error)
            foremost = distinct(fits, SHAPES_AGAIN)[:MOST_AGAIN]
            promising = [any(fit is one for one in foremost) and likely(fit, best, q_without) for fit in fits]
            events = max(int(ratio * many), self.enough)
            worthy = [fit for fit, worth in zip(fits, promising, strict=True) if worth]
            calls = [(fit, self.target, np.random.default_rng(seed), events, AGAIN, known) for fit in worthy]
            again = self.work(sharpen, calls)
            fits = [*again, *(fit for fit, worth in zip(fits, promising, strict=True) if not worth)]
        return self._told_apart(fits, seed, many, q_without)

    def _told_apart(self, fits: list[Fit], seed: int, many: int, q_without: float) -> list[Fit]:
        """The fits, those of families that are nearly tied with yet more events."""
        ranks = ranking(fits, q_without)
        foremost = [entry.fit for entry in ranks if likely(entry.fit, ranks[0].fit, q_without)][:MOST_FINAL]
        if len(foremost) < 2:
            return fits
        calls = [(fit, self.target, np.random.default_rng(seed), many, self.effort.final) for fit in foremost]
        final = self.work(settled, calls)
        return [*final, *(fit for fit in fits if all(fit is not one for one in foremost))]

    def work(self, fitting: Callable[..., Fit], calls: list[tuple]) -> list[Fit]:
        """The fits of all calls, by so many processes as were asked for."""
        return in_processes(self.jobs, self.without.model.events, fitting, calls)


def candidates(
    without: Fit,
    target: Target,
    effects: list[Effect],
    x: NDArray,
    rng: np.random.Generator,
    effort: Effort,
    *,
    hopeful: Callable[[Fit], bool],
    q_without: float,
    jobs: int = 1,
) -> tuple[list[Fit], KnownModel]:
    """Fits to events x (N, d) of `without` with one more effect: the best starts of the most promising families.

    Fits that may still be the best are repeated with more events, all from the same seed, if one of them is `hopeful`;
    else none will do. `q_without` is the Q without any effect. Also the model of `without`, made known for that.
    """
    found = Candidates(without, target, [effect.adapted(x) for effect in effects], x, rng, effort, jobs)
    families, spare = found.screened()
    starts = found.chosen(families)
    known = without.known(target, int(effort.known * target.num_events), rng)
    fits = found.begun(starts, known)
    # Where simulated events end, what was fitted so far is compared.
    with suppress(BudgetExhausted):
        more = found.further(fits, spare)
        fits += found.begun(more, known)
        fits = found.gone_on(fits, [*starts, *more], known)
        fits = found.repeated(fits, known, hopeful, q_without)
    return fits, known


def on_all(fits: list[Fit], effects: list[Effect]) -> list[Start]:
    """Starts of effects that act on all features alike, from fits in which they act on one."""
    starts = []
    for fit in fits:
        model, effect = fit.model, fit.model.effects[-1]
        meanings = [(p.name, p.unit) for p in effect.parameters]
        for whole in [one for one in effects if one.key == (effect.name, "all") != effect.key]:
            for shape in whole.shapes():
                if shape.shape == effect.shape and [(p.name, p.unit) for p in shape.parameters] == meanings:
                    larger = replace(model, effects=(*model.effects[:-1], shape))
                    point = larger.to_cube(np.clip(fit.params, larger.low, larger.high))
                    near = ROUGH * larger.strengths(point)[model.dim - len(meanings)]
                    starts.append(Start(larger, point, np.inf, near))
    return starts
