"""Which effect is missing? Every shape of every candidate is screened, and the promising ones fitted with theta."""

import os
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import joblib
import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit, descend, polish, refine, scan, settled
from avobench.diagnosis.fit.known import Base
from avobench.diagnosis.search.ranking import cost, likely, ranking
from avobench.diagnosis.search.starts import ROUGH, Sample, Start, hidden, screen, searched
from avobench.diagnosis.summary.bins import Bins, whitening
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.pool import Counted, Pool

AT_EDGE = 0.48
"""Distance from the middle of the range, of which the edge is at 0.5."""
MOST_SCREENED, OF_FEATURE = 32, 2
"""Effects of which all shapes are screened; families of each feature that are fitted for what it shows by itself."""
FIRST_ROUNDS, LAST_ROUNDS, CONTINUED, AGAIN = 3, 7, 10, 4
"""Rounds of all fits, of those that go on, how many of these beside the best of each family; rounds of a repetition."""
NEARBY = 0.05
"""In unit coordinates: fits of one shape that are closer than that are one."""
SHAPES_AGAIN, MOST_AGAIN, MOST_FINAL, RESHAPED, ON_ALL = 2, 8, 4, 3, 6
"""Fits of a family that are repeated, and fits in all; families that are told apart with yet more events; other
shapes of an effect to try beside a second one; families of one feature that are tried on all."""
WEAK, MOST_EVENTS = 10.0, 4
"""Noise of chi-squared is kept to a fifth of the excess, with at most so many events a measured one."""
CLOSES, CLEARLY = 0.5, 4.0
"""Share of the gap that an effect must close to be named, and standard deviations by which one feature's own gap must
stand out to count."""
STRONG = 10.0
"""Chi-squared per degree of freedom above which theta may be too far off for an effect to be seen from there."""
FURTHEST = 0.2
"""How far, in unit coordinates, theta follows an effect's strength within a first design."""


def excess_by_feature(fit: Fit, target: Target) -> dict[int, float]:
    """By how much chi-squared of each feature's own bins exceeds their number.

    Nothing where there is one feature, or where the summary does not tell them apart.
    """
    if not isinstance(target.summary, Bins) or len(target.summary.edges) == 1:
        return {}
    residual, start, found = target.mean - fit.predicted, 0, {}
    for features, size in target.summary.blocks:
        if len(features) == 1:
            own = slice(start, start + size)
            w = whitening(target.cov[own, own])
            q = target.num_events * float(((residual[own] @ w) ** 2).sum())
            found[features[0]] = q - (1 + fit.noise) * w.shape[1]
        start += size
    return found


def open_features(fit: Fit, target: Target) -> dict[int, float]:
    """By how much chi-squared of a feature's own bins is too large, where that is plain and no effect acts on it yet.

    What is left in a feature that no effect acts on is not left by a wrong shape. Largest first.
    """
    acted = {effect.feature for effect in fit.model.effects}
    found = sorted(excess_by_feature(fit, target).items(), key=lambda item: -item[1])
    return {
        feature: value
        for feature, value in found
        if acted.isdisjoint({feature, "all"}) and value > CLEARLY * np.sqrt(2 * len(target.summary.edges[feature]))
    }


def clears_feature(fit: Fit, before: Fit, target: Target) -> bool:
    """Whether the last effect closes most of what its feature shows, on which no effect before it acts."""
    feature, shown = fit.model.effects[-1].feature, open_features(before, target)
    return feature in shown and excess_by_feature(fit, target)[feature] < (1 - CLOSES) * shown[feature]


def joint(start: Start, base: Base, target: Target, rng: np.random.Generator, num_events: int) -> Fit:
    """The first steps of a fit of theta and the effects' parameters together."""
    model = start.model
    last = model.dim - len(model.effects[-1].parameters)
    half = np.full(model.dim, 0.08)
    half[:last] = 0.02
    half[last] = max(start.near, 1e-4)
    design = base.design(start.unit, half)
    shear = np.zeros_like(design.axes)
    shear[:last, last] = np.clip(start.along * half[last], -FURTHEST, FURTHEST)
    design = replace(design, axes=design.axes + shear)
    return descend(model, target, design, rng, num_events, FIRST_ROUNDS, base)


def continued(fit: Fit, base: Base, target: Target, rng: np.random.Generator, num_events: int, effort: Effort) -> Fit:
    """The same fit until it stands still.

    One that ends at an edge of theta's range, or far from the data, may have been led there by the effect that was
    missing: theta is then looked for anew.
    """
    p = fit.model.num_theta
    fit = polish(fit, target, rng, num_events, rounds=LAST_ROUNDS, base=base)
    if np.abs(fit.unit[:p] - 0.5).max() < AT_EDGE and fit.gap < STRONG * fit.dof:
        return fit
    centre, near = scan(fit.model, target, rng, fixed=fit.unit[p:], size=effort.scan)
    half = np.r_[np.maximum(near, 0.005), 0.3 * fit.model.reach(centre)[p:]]
    again = refine(fit.model, target, centre, half, rng, num_events=num_events, base=base)
    return min(fit, again, key=lambda f: f.gap)


def candidates(
    base: Fit,
    target: Target,
    effects: list[Effect],
    x: NDArray,
    rng: np.random.Generator,
    effort: Effort,
    *,
    hopeful: Callable[[Fit], bool],
    gap_without: float,
    jobs: int = 1,
) -> tuple[list[Fit], Base]:
    """Fits to events x (N, d) of `base` with one more effect: the best starts of the most promising families.

    Fits that may still be the best are repeated with more events, all from the same seed, if one of them is `hopeful`;
    else none will do. `gap_without` is the gap without any effect. Also `base`, made known for that.
    """
    sample = Sample(base, target, effort.sample, rng)
    effects = [effect.adapted(x) for effect in effects]
    plain = {effect.key: screen(sample, effect, x, rng, effort) for effect in effects}
    # Every shape of an effect that looks promising in its plainest is looked at, and of all effects if they are few.
    best_first = sorted(effects, key=lambda e: min((s.expected for s in plain[e.key]), default=np.inf))
    if len(effects) > MOST_SCREENED:
        own = excess_by_feature(base, target)
        worst = max(own, key=own.get, default=None)
        best_first = sorted(best_first, key=lambda e: e.feature not in (worst, "all"))[:MOST_SCREENED]
    families, spare = [], {}
    for effect in best_first:
        starts, far = [], []
        for k, shape in enumerate(effect.shapes()):
            own = plain[effect.key] if k == 0 else screen(sample, shape, x, rng, effort)
            if own and base.gap > STRONG * base.dof and (k == 0 or len(effects) <= MOST_SCREENED):
                own = [*own, searched(base, target, shape, rng, effort)]
            if own and len(effects) <= MOST_SCREENED and shape.guess(x) is None:
                far += hidden(sample, own[0], rng, effort)
            starts += sorted(own, key=lambda start: start.expected)
        # The plainest shape always has its fit: screening is too rough to prefer another to it.
        first, rest = starts[:1], sorted(starts[1:], key=lambda start: start.expected)
        families.append([*first, *rest[: effort.starts - 1], *far])
        fitted = {start.model.effects[-1].shape for start in families[-1]}
        shapes = {start.model.effects[-1].shape: start for start in reversed(rest)}
        spare[effect.key] = [start for shape, start in shapes.items() if shape not in fitted]
    families = sorted(filter(None, families), key=lambda starts: min(start.expected for start in starts))
    # Each feature that shows something of its own has its best families, whatever another one shows.
    own = [
        starts
        for feature in open_features(base, target)
        for starts in [starts for starts in families if starts[0].model.effects[-1].feature == feature][:OF_FEATURE]
    ][: effort.families // 2]
    others = [starts for starts in families if all(starts is not one for one in own)]
    starts = [start for starts in [*own, *others][: effort.families] for start in starts]
    work = partial(_in_processes, jobs, base.model.events)
    known = base.known(target, int(effort.base * target.num_events), rng)

    def begun(starts: list[Start]) -> list[Fit]:
        streams = rng.spawn(len(starts))  # so that any number of workers gives the same fits
        calls = zip(starts, streams, strict=True)
        return work(joint, [(start, known, target, stream, effort.fit // 2) for start, stream in calls])

    fits = begun(starts)
    if fits:  # the family that seems best is free to take any of its shapes, and what acts on one feature to act on all
        foremost = sorted(fits, key=lambda fit: fit.gap)
        more = spare[foremost[0].model.effects[-1].key] + _on_all(_distinct(foremost, 1)[:ON_ALL], effects)
        starts, fits = starts + more, fits + begun(more)
    # A weak effect is not seen in fits whose noise is as large as what it leaves.
    beyond = max(base.gap - base.dof, 1.0)
    noise = beyond**2 / (WEAK * np.sqrt(2 * target.rank) * beyond + WEAK**2 * base.gap)
    needed = target.num_events / noise
    enough = int(np.clip(needed, effort.fit, max(effort.fit, MOST_EVENTS * target.num_events)))
    fits = _going_on(fits, [start.expected for start in starts])
    streams = rng.spawn(len(fits))
    calls = zip(fits, streams, strict=True)
    fits = work(continued, [(fit, known, target, stream, enough, effort) for fit, stream in calls])
    seed, many = int(rng.integers(2**63)), max(target.num_events, effort.few)
    for ratio in effort.again:
        fits = _distinct(fits)
        if not any(hopeful(fit) for fit in fits):
            break
        best = min(fits, key=lambda fit: fit.gap + fit.gap_error)
        foremost = _distinct(fits, SHAPES_AGAIN)[:MOST_AGAIN]
        promising = [any(fit is one for one in foremost) and likely(fit, best, gap_without) for fit in fits]
        events = max(int(ratio * many), enough)
        worthy = [fit for fit, worth in zip(fits, promising, strict=True) if worth]
        again = work(polish, [(fit, target, np.random.default_rng(seed), events, AGAIN, known) for fit in worthy])
        fits = [*again, *(fit for fit, worth in zip(fits, promising, strict=True) if not worth)]
    else:
        ranks = ranking(fits, gap_without)
        foremost = [entry.fit for entry in ranks if likely(entry.fit, ranks[0].fit, gap_without)][:MOST_FINAL]
        if len(foremost) > 1:
            streams = [np.random.default_rng(seed) for _ in foremost]
            calls = zip(foremost, streams, strict=True)
            final = work(settled, [(fit, target, stream, many, effort.final) for fit, stream in calls])
            fits = [*final, *(fit for fit in fits if all(fit is not one for one in foremost))]
    return fits, known


def _in_processes(
    jobs: int, events: Counted | Pool | None, fitting: Callable[..., Fit], calls: list[tuple]
) -> list[Fit]:
    """The fits of all calls, by so many processes; `events` is what simulates, and counts what they simulated."""
    fits = []
    for fit, used, process in joblib.Parallel(n_jobs=jobs)(joblib.delayed(_apart)(fitting, *call) for call in calls):
        if process != os.getpid() and events is not None:
            events.used += used
        fits.append(replace(fit, model=replace(fit.model, events=events)))
    return fits


def _apart(fitting: Callable[..., Fit], begun: Start | Fit, *more: Any) -> tuple[Fit, int, int]:
    """A fit without this process's copy of what simulates, how many events that made, and which process it is."""
    events = begun.model.events
    before = events.used if events else 0
    fit = fitting(begun, *more)
    return replace(fit, model=replace(fit.model, events=None)), events.used - before if events else 0, os.getpid()


def reshaped(
    pairs: list[Fit],
    known: Base,
    others: tuple[Fit, ...],
    target: Target,
    rng: np.random.Generator,
    effort: Effort,
    gap_without: float,
) -> list[tuple[Fit, Base]]:
    """Fits of effects that differ in the last one, each with the one before in another shape if that leaves less.

    Without the last, that one took the shape that imitates it best. `others` are fits without the last, in other shapes
    of the one before; `known` is the model without the last, as is what is returned beside each fit.
    """
    best = [(pair, known) for pair in pairs]
    for alone in others[:RESHAPED]:
        base = alone.known(target, int(effort.base * target.num_events), rng)
        for k, pair in enumerate(pairs):
            again = beside(pair, base, alone, target, rng, effort, gap_without)
            best[k] = min(best[k], (again, base), key=lambda each: cost(each[0]))
    return best


def beside(
    pair: Fit,
    base: Base,
    alone: Fit,
    target: Target,
    rng: np.random.Generator,
    effort: Effort,
    gap_without: float,
) -> Fit:
    """The last effect of a pair added to another fit, whose model is `base`, from the values it has in the pair.

    With as many events as the pair where the two may be tied.
    """
    second, before = pair.model.effects[-1], alone.model
    model = before.plus(second)
    if pair.model.stretch:
        stretch = before.stretch or (1.0,) * len(before.effects)
        model = replace(model, stretch=(*stretch, pair.model.stretch[-1]))
    unit = np.concatenate([alone.unit, pair.unit[-len(second.parameters) :]])
    start = Start(model, unit, np.nan, ROUGH * model.strengths(unit)[before.dim])
    few = min(pair.num_events, max(int(effort.again[0] * target.num_events), effort.least))
    fit = continued(joint(start, base, target, rng, effort.fit), base, target, rng, few, effort)
    if few < pair.num_events and likely(fit, pair, gap_without):
        fit = polish(fit, target, rng, pair.num_events, AGAIN, base)
    return fit


def _on_all(fits: list[Fit], effects: list[Effect]) -> list[Start]:
    """Starts of effects that act on all features alike, from fits in which they act on one."""
    starts = []
    for fit in fits:
        model, effect = fit.model, fit.model.effects[-1]
        units = [(p.name, p.unit) for p in effect.parameters]
        for whole in [one for one in effects if one.key == (effect.name, "all") != effect.key]:
            for shape in whole.shapes():
                if shape.shape == effect.shape and [(p.name, p.unit) for p in shape.parameters] == units:
                    larger = replace(model, effects=(*model.effects[:-1], shape))
                    unit = larger.to_unit(np.clip(fit.params, larger.low, larger.high))
                    near = ROUGH * larger.strengths(unit)[model.dim - len(units)]
                    starts.append(Start(larger, unit, np.inf, near))
    return starts


def _going_on(fits: list[Fit], expected: list[float]) -> list[Fit]:
    """Of each family the fit that left least and the one of most hope, by what screening expected too; and others."""
    hope = {id(fit): min(fit.gap, value) for fit, value in zip(fits, expected, strict=True)}
    hopeful = sorted(fits, key=lambda fit: hope[id(fit)])
    firsts = list({fit.model.effects[-1].key: fit for fit in sorted(fits, key=lambda fit: -fit.gap)}.values())
    for fit in {fit.model.effects[-1].key: fit for fit in reversed(hopeful)}.values():
        if not any(_same(fit, one) for one in firsts):
            firsts.append(fit)
    others: list[Fit] = []
    for fit in hopeful:
        if len(others) < CONTINUED and not any(_same(fit, one) for one in (*firsts, *others)):
            others.append(fit)
    return [*firsts, *others]


def _same(fit: Fit, other: Fit) -> bool:
    """Whether two fits are of one shape and close to each other."""
    effect, than = fit.model.effects[-1], other.model.effects[-1]
    if (effect.key, effect.shape) != (than.key, than.shape):
        return False
    return bool(np.abs(fit.unit - other.unit).max() < NEARBY)


def _distinct(fits: list[Fit], most: int | None = None) -> list[Fit]:
    """The best fits of each family that are not the same, and of a family at most so many, of other shapes first."""
    kept: dict[tuple, list[Fit]] = {}
    for fit in sorted(fits, key=lambda fit: fit.gap):
        own = kept.setdefault(fit.model.effects[-1].key, [])
        if not any(_same(fit, one) for one in own):
            own.append(fit)
    for key, own in kept.items():
        shapes = {fit.model.effects[-1].shape: fit for fit in reversed(own)}
        kept[key] = sorted(own, key=lambda fit: all(fit is not one for one in shapes.values()))[:most]
    return sorted((fit for own in kept.values() for fit in own), key=lambda fit: fit.gap)
