"""Which effect may a fitted model lack? All are screened, and what may be the answer is fitted with ever more events.

Successive halving: after each round a candidate stays if, for all that simulation leaves open, it may still matter
beside the best.
"""

import os
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import joblib
import numpy as np
from joblib.externals.loky.process_executor import TerminatedWorkerError
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import descend, refine, scan, seen_at, sharpen
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import ReferenceModel
from avobench.diagnosis.search.evidence import Weighed
from avobench.diagnosis.search.populations import populations
from avobench.diagnosis.search.screening import Around, Look, Sample, Start, glance, hidden, looked_again, starts_of
from avobench.diagnosis.settings import SCORE, SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.bank import Bank
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.tasks.errors import BudgetExhausted, ProcessEnded
from avobench.tasks.meter import Meter

T = TypeVar("T")


@dataclass(frozen=True)
class Candidates:
    """The search for one more effect: what it adds to, and what all its parts need."""

    parent: Weighed
    """The model to which one effect is added."""
    target: Target
    effects: list[Effect]
    """Adapted to the measured events."""
    rng: np.random.Generator
    effort: Effort
    jobs: int
    like: dict[str, float] = field(default_factory=dict)
    """Logarithm of how much the events look like each family."""

    @property
    def without(self) -> Fit:
        return self.parent.fit

    @property
    def meter(self) -> Meter:
        """What counts simulated events; one without a limit where nothing is counted."""
        events = self.without.model.events
        return Meter() if events is None else events.meter

    @cached_property
    def sample(self) -> Sample:
        """Events from which all effects are screened."""
        around = Around(self.reference(), self.target)
        return Sample(self.without, self.target, self.effort.sample, self.rng, around)

    def glances(self, guesses: list[tuple[Effect, NDArray[np.float64] | None]]) -> list[Look]:
        """First looks at shapes of effects, but for those that the measured events rule out by an empty guess."""
        possible = [(shape, points) for shape, points in guesses if points is None or len(points)]
        return [glance(self.sample, shape, points, self.rng, self.effort) for shape, points in possible]

    def screened(self, glances: list[Look]) -> list[Start]:
        """Starts from the most promising first looks, best first.

        Looks at the simulator alone serve beside other effects too, which hardly change them. Where few events may be
        simulated, half of them are for the second looks; what needs more is left at its first look.
        """
        free = {effect.key for effect in self.effects}
        possible = [look for look in glances if look.effect.key in free]
        best_first = sorted(possible, key=lambda look: look.expected(self.sample).q.min())
        with self.meter.keeping(max(self.meter.remaining or 0, 0) // 2):
            looks = of_all(best_first, SEARCH.looked_at * self.effort.starts)
            for k, look in enumerate(looks):
                with suppress(BudgetExhausted):
                    looks[k] = looked_again(self.sample, look, self.rng)
            begun = [(starts_of(self.sample, look), look) for look in looks]
            return self.elsewhere(sorted(begun, key=lambda one: one[0][0].expected))

    def elsewhere(self, begun: list[tuple[list[Start], Look]]) -> list[Start]:
        """Starts of looks, and others where theta moves far from where it was, or hides a weak effect."""
        all_alone = not self.parent.effects and len(self.effects) <= SEARCH.of_one_feature
        starts, again = [], 0
        for of_shape, look in begun:
            first = of_shape[0]
            with suppress(BudgetExhausted):
                if again < SEARCH.again and self.moved(
                    first
                ):  # an effect does something else to events of another theta
                    there = self.sample.elsewhere(first.point[: self.without.model.dim], self.effort.fit, self.rng)
                    of_shape, again = starts_of(there, looked_again(there, look, self.rng)), again + 1
                second = look.effect.second
                if not self.parent.effects and 1 < len(second) == self.without.model.num_theta:
                    of_shape = populations(self.without, self.target, look.effect, self.rng, self.effort)
                if all_alone and not look.guessed and any(look.effect is effect for effect in self.effects):
                    of_shape += hidden(self.sample, first, self.rng, self.effort)
            starts += of_shape
        return sorted(starts, key=lambda start: start.expected)

    def moved(self, start: Start) -> bool:
        """Whether theta moved by more than SEARCH.moved standard errors, and the effect acts on finished events.

        Any other effect would need all events simulated again.
        """
        away = start.point[: self.without.model.dim] - self.without.point
        far = away @ self.without.information[0] @ away > SEARCH.moved**2
        within = self.sample.around.holds(start.point[: self.without.model.dim])
        return bool(far) and within and start.model.newest_acts_last

    def hopeful(self, starts: list[Start]) -> list[Start]:
        """The best start of each shape, and one more elsewhere, where screening expects that it explains something.

        Events at each of them say what it is worth, since theta follows an effect otherwise than screening knows. Where
        few may be simulated, a quarter of them is for that.
        """
        promising = [start for start in starts if start.expected < self.without.noiseless_q]
        with self.meter.keeping(3 * max(self.meter.remaining or 0, 0) // 4):
            tried = self.work(check, [each for some in by_shape(promising) for each in some[:2]], self.effort.fit // 2)
            ranked = sorted((start for start in tried if start is not None), key=lambda start: start.expected)
            firsts = {start.model.effects[-1].key: start for start in ranked[::-1] if start.slope is not None}
            nearer = self.work(approach, list(firsts.values()), self.effort.fit // 2, self.without)
        others = [start for start in ranked if not any(start is first for first in firsts.values())]
        reached = [near or first for near, first in zip(nearer, firsts.values(), strict=True)]
        ranked = sorted([*others, *reached], key=lambda start: start.expected)
        first, second = ([some[k] for some in by_shape(ranked or promising) if len(some) > k] for k in (0, 1))
        first = varied(first, lambda start: start.expected / 2, lambda start: start.model)
        return [*first[: self.effort.starts], *second[: self.effort.starts // 4]]

    def weighed(self, glances: list[Look], beside: float) -> tuple[list[Weighed], list[Weighed]]:
        """The models with one more effect that may matter beside a log evidence of `beside`, and the dropped ones."""
        return self.halved(self.hopeful(self.screened(glances)), beside)

    def halved(self, starts: list[Start], beside: float) -> tuple[list[Weighed], list[Weighed]]:
        """Fits from these starts that may matter beside each other, made with more and more events, and dropped ones.

        A dropped fit is as it was when it was dropped. Where few events may be simulated, half of them are for the
        first fits, those of the best starts first, and what was fitted when they end is weighed.
        """
        with self.meter.keeping(max(self.meter.remaining or 0, 0) // 2):
            begun = [fit for fit in self.work(begin, starts, self.effort.fit) if fit is not None]
            begun = distinct(sorted(begun, key=lambda fit: fit.noiseless_q))
            astray = [fit for fit in begun if fit.far][: SEARCH.astray]
            again = self.work(search_again, astray, self.effort.fit, *self.effort.scan) if astray else []
        begun = distinct(sorted([*begun, *(fit for fit in again if fit)], key=lambda fit: fit.noiseless_q))
        fits = varied(begun, lambda fit: fit.noiseless_q / 2, lambda fit: fit.model)[: self.effort.begun]
        ranked: list[Weighed] = []
        dropped: list[Weighed] = []
        for (ratio, rounds), most in zip(self.effort.rounds_of_search, SEARCH.most, strict=True):
            wanted = ratio * max(self.target.num_events, self.effort.few)
            events = max(int(wanted), self.effort.fit)  # fewer than the fits began with would lead them astray
            more = self.work(go_on, fits, events, max(round(rounds * wanted / events), 2))
            if not any(more):
                break
            settled = bool(ranked)  # a first fit may have far to go: the best of them stay, however far
            fits = [fit or before for fit, before in zip(more, fits, strict=True)]  # where events end, as it was
            fitted = sorted((Weighed.of(fit, self.like) for fit in fits), key=cost)
            ranked = varied(self.matter(fitted, beside) if settled else fitted, cost, lambda one: one.fit.model)[:most]
            dropped += [one for one in fitted if not any(one is other for other in ranked)]
            fits = [one.fit for one in ranked]
        return ranked or self.matter((Weighed.of(fit, self.like) for fit in fits), beside)[: SEARCH.most[0]], dropped

    @cached_property
    def seed(self) -> int:
        """Seed of the reference."""
        return int(self.rng.integers(2**63))

    def reference(self) -> ReferenceModel:
        """The surrogate of the model to which effects are added. Its noise is the same for all effects."""
        events, rng = int(self.effort.reference * self.target.num_events), np.random.default_rng(self.seed)
        return self.without.reference(self.target, events, rng)

    def work(self, fitting: Callable[..., T], begun: list, *how: Any) -> list[T | None]:
        """The fits of all, from one seed, by so many processes as were asked for; None where events end."""
        seed = int(self.rng.integers(2**63))
        reference = self.reference()
        calls = [(one, reference, self.target, np.random.default_rng(seed), *how) for one in begun]
        return in_processes(self.jobs, self.without.model.events, fitting, calls)

    def matter(self, ranked: Iterable[Weighed], beside: float) -> list[Weighed]:
        """Those that may matter beside the best of them, or beside another model, best first.

        The best few sets of effects stay, since further effects may be added to them.
        """
        ranked = sorted(ranked, key=cost)
        least = max([beside, *(one.evidence.at_least for one in ranked)]) - SCORE.indifferent
        firsts = list({one.effects: one for one in reversed(ranked)}.values())[::-1][: SEARCH.parents]
        return [one for one in ranked if one.evidence.at_most > least or any(one is first for first in firsts)]


def cost(one: Weighed) -> float:
    """The key by which models are sorted, best first. The error of the evidence is left to later rounds."""
    return -one.evidence.value - SEARCH.likeness * one.resemblance


def varied(some: list[T], key: Callable[[T], float], model: Callable[[T], Model]) -> list[T]:
    """Starts or fits by a key in units of log evidence, lowest first; each further shape of an effect pays a price.

    What is to be told is which effect is missing: shapes of one must not crowd out others.
    """
    places: Counter[tuple] = Counter()
    costs = []
    for one in sorted(some, key=key):
        effects = tuple(effect.key for effect in model(one).effects)
        costs.append((key(one) + SEARCH.alike * places[effects], one))
        places[effects] += 1
    return [one for _, one in sorted(costs, key=lambda each: each[0])]


def of_all(looks: list[Look], most: int) -> list[Look]:
    """The best `most` of the looks, and the best look at each of the `2 * most // 3` most promising effects.

    Where theta takes up much of an effect, a first look promises little of it: shapes of others must not crowd it out.
    """
    best = sorted({look.effect.key: k for k, look in reversed([*enumerate(looks)])}.values())[: 2 * most // 3]
    return [looks[k] for k in sorted({*range(min(most, len(looks))), *best})]


def by_shape(starts: list[Start]) -> list[list[Start]]:
    """Starts, best first, of each shape."""
    kept: dict[tuple, list[Start]] = {}
    for start in starts:
        effect = start.model.effects[-1]
        kept.setdefault((effect.key, effect.shape), []).append(start)
    return list(kept.values())


def check(start: Start, reference: ReferenceModel, target: Target, rng: np.random.Generator, num_events: int) -> Start:
    """The start, or a point between it and the fit without the effect: whichever has the lower simulated Q."""
    model, origin = start.model, reference.surrogate.design.centre
    last = len(origin)
    null = model.nulls[last]
    tried = []
    for share in SEARCH.shares:
        point = start.point.copy()
        point[:last] = origin + share * (point[:last] - origin)
        point[last] = null + share * (point[last] - null)
        _, q = seen_at(model, point, target, rng, num_events)
        tried.append(replace(start, point=point, expected=q, near=share * start.near))
        if q < reference.surrogate.noiseless_q_at_centre(target)[0]:
            break
    return min(tried, key=lambda one: one.expected)


def approach(
    start: Start, reference: ReferenceModel, target: Target, rng: np.random.Generator, num_events: int, without: Fit
) -> Start:
    """Where Gauss-Newton steps of theta and the strength lead from a start, as long as the simulated Q falls.

    The slopes are those of the model without the effect, and are not updated on the way.
    """
    model, last = start.model, without.model.dim
    free = without.projector() @ start.slope
    best, point = replace(start, expected=np.inf), start.point
    for _ in range(SEARCH.approached):
        residual, q = seen_at(model, point, target, rng, num_events)
        if q >= best.expected:
            break
        best = replace(start, point=point, expected=q)
        stronger = free @ residual / max(free @ free, 1e-30)  # what an effect does may be nothing, or what theta does
        step = np.r_[without.follow(residual - stronger * start.slope), stronger]
        moved = point[: last + 1] + np.clip(step, -SEARCH.stride, SEARCH.stride)
        point = np.r_[np.clip(moved, 0, 1), point[last + 1 :]]
    return best


def begin(start: Start, reference: ReferenceModel, target: Target, rng: np.random.Generator, num_events: int) -> Fit:
    """The first steps of a fit of theta and the effects' parameters together."""
    model = start.model
    last = model.dim - len(model.effects[-1].parameters)
    half = np.full(model.dim, SEARCH.first_half) if start.half is None else start.half.copy()
    if start.half is None:
        half[:last] = 0.02
        half[last] = start.near
    half = np.maximum(half, 1e-4)
    design = reference.design(start.point, half)
    shear = np.zeros_like(design.axes)
    shear[:last, last] = np.clip(start.along * half[last], -SEARCH.furthest, SEARCH.furthest)
    design = replace(design, axes=design.axes + shear)
    return descend(model, target, design, rng, num_events, SEARCH.first_rounds, reference)


def search_again(
    fit: Fit,
    reference: ReferenceModel,
    target: Target,
    rng: np.random.Generator,
    num_events: int,
    points: int,
    events: int,
) -> Fit:
    """The fit, or one of the same model that begins where points all around it come closest to the measured events.

    Steps do not get far where the way is bent, as where an edge moves and theta follows.
    """
    point, near = scan(fit.model, target, rng, around=fit.point, half=SEARCH.all_around, size=(points, events))
    other = refine(fit.model, target, point, near, rng, num_events=num_events, max_rounds=SEARCH.first_rounds)
    return min(fit, other, key=lambda fit: fit.noiseless_q)


def go_on(
    fit: Fit, reference: ReferenceModel, target: Target, rng: np.random.Generator, num_events: int, rounds: int
) -> Fit:
    """The same fit with more events, until it stands still."""
    return sharpen(fit, target, rng, num_events, rounds, reference)


def distinct(fits: list[Fit]) -> list[Fit]:
    """Of fits, best first, each once, and of each effect the best SEARCH.shapes_kept.

    Where even the best has far to go, all that are not much worse are kept: the order may change on the way.
    """
    kept: list[Fit] = []
    for fit in fits:
        of_effect = [one for one in kept if one.model.effects[-1].key == fit.model.effects[-1].key]
        far = bool(of_effect) and fit.far
        open_yet = far and fit.noiseless_q < SEARCH.not_much_worse * of_effect[0].noiseless_q
        if (len(of_effect) < SEARCH.shapes_kept or open_yet) and not any(same(fit, one) for one in of_effect):
            kept.append(fit)
    return kept


def same(fit: Fit, other: Fit) -> bool:
    """Whether two fits are of one shape and close to each other."""
    effect, than = fit.model.effects[-1], other.model.effects[-1]
    if (effect.key, effect.shape) != (than.key, than.shape):
        return False
    return bool(np.abs(fit.point - other.point).max() < SEARCH.nearby)


def in_processes(
    jobs: int, events: Bank | Pool | None, fitting: Callable[..., T], calls: list[tuple]
) -> list[T | None]:
    """The fits of all calls, by so many processes; `events` is what simulates, and its meter counts it.

    With a bank it is one process, so that all find the events that others had made; the bank simulates in many.

    Under a limit each other process has an equal share of what remains. A fit that needs more is made here, from the
    rest; None where that is too little.
    """
    jobs = 1 if isinstance(events, Bank) else jobs
    remaining = events.meter.remaining if events is not None else None
    share = None if jobs == 1 or remaining is None else max(remaining, 0) // max(len(calls), 1)
    try:
        work = joblib.Parallel(n_jobs=jobs, return_as="generator")
        made: list[T | None] = []
        for fit, used, process in work(joblib.delayed(_apart)(share, fitting, *call) for call in calls):
            made.append(fit)
            if process != os.getpid() and events is not None:
                events.meter.add(used)
    except TerminatedWorkerError as error:
        raise ProcessEnded("crashed", "a worker process of the fits was ended (killed, or out of memory)") from error
    for k in (k for k, fit in enumerate(made) if fit is None and share is not None):
        with suppress(BudgetExhausted):
            made[k] = fitting(*calls[k])
    return [fit and replace(fit, model=replace(fit.model, events=events)) for fit in made]


def _apart(share: int | None, fitting: Callable[..., T], begun: Start | Fit, *more: Any) -> tuple[T | None, int, int]:
    """A fit without this process's copy of what simulates, how many events that made, and which process it is.

    No more than a `share` of events is made, which a process of its own has; None where the fit needs more.
    """
    events = begun.model.events
    before = events.meter.used if events else 0
    if share is not None:
        events.meter.share(share)
    try:
        fit = fitting(begun, *more)
    except BudgetExhausted:
        return None, events.meter.used - before, os.getpid()
    return replace(fit, model=replace(fit.model, events=None)), events.meter.used - before if events else 0, os.getpid()
