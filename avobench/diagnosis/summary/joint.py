"""Several data sets with one theta: their summaries side by side, with a covariance in blocks."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from avobench.diagnosis.summary.bins import Shown, Summary, View
from avobench.diagnosis.summary.part import Measured, Part, split, target_for
from avobench.diagnosis.summary.table import TableSummary
from avobench.diagnosis.summary.target import Target
from avobench.tasks import Task
from avobench.tasks.joint import JointTask


@dataclass(frozen=True, eq=False)
class StackedSummary(Summary):
    """The summaries of several data sets, one after the other; an event has the features of one event of each."""

    names: tuple[str, ...]
    """Of the sets: (k,)."""
    columns: tuple[slice, ...]
    """Where the features of each set are in an event."""
    summaries: tuple[Summary, ...]
    weights: NDArray[np.float64]
    """By what the covariance of an event of each set is multiplied, since one has more events than another: (k,)."""

    @cached_property
    def size(self) -> int:
        return sum(summary.size for summary in self.summaries)

    @cached_property
    def parts(self) -> list[slice]:
        """Where the vector of each set is in that of all."""
        ends = np.cumsum([0, *(summary.size for summary in self.summaries)]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    def _sets(self, x: NDArray) -> Iterator[tuple[Summary, NDArray]]:
        """The summary of each set with its features of events (n, d)."""
        return zip(self.summaries, (np.ascontiguousarray(x[:, at]) for at in self.columns), strict=True)

    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        return np.hstack([summary.mean(events, pieces) for summary, events in self._sets(x)])

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.hstack([summary.moments(events, weights) for summary, events in self._sets(x)])

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        each = zip(self._sets(x), self.parts, strict=True)
        return sum(summary.project(events, direction[part]) for (summary, events), part in each)

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        each = zip(self._sets(before), self._sets(after), strict=True)
        moved = [summary.moved(a, b) for (summary, a), (_, b) in each]
        return np.average(moved, axis=0, weights=[summary.size for summary in self.summaries])

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        return block_diag(*(summary.covariance(events) for summary, events in self._sets(x)))

    def linear(self, terms: NDArray[np.float64]) -> NDArray[np.float64]:
        each = zip(self.summaries, self.parts, strict=True)
        return np.hstack([summary.linear(terms[:, part]) for summary, part in each])

    def model_covariance(self, x: NDArray, num_events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        blocks, lacking = [], []
        for (summary, events), weight in zip(self._sets(x), self.weights, strict=True):
            cov, more = summary.model_covariance(events, max(round(num_events / weight), 1))
            blocks.append(weight * cov)
            lacking.append(weight * more)
        return block_diag(*blocks), np.concatenate(lacking)

    def view(self, x: "NDArray | JointPart") -> View:
        spans, shown = [], []
        sets = x.sets if isinstance(x, JointPart) else [x[:, at] for at in self.columns]
        for name, summary, at, part, events in zip(
            self.names, self.summaries, self.columns, self.parts, sets, strict=True
        ):
            view = summary.view(events)
            for span in view.spans:
                feature = span.feature + at.start if isinstance(span.feature, int) else span.feature
                named = f"{name}: {span.name}" if span.name else ""
                spans.append(replace(span, feature=feature, start=span.start + part.start, name=named))
            shown.append(view.shown or _shares(summary.mean(events)[0], len(events)))
        return View(spans, shown=Shown(*map(np.concatenate, zip(*shown, strict=True))))

    def chi_squared_variance(self, rank: int, num_events: int) -> float:
        """The variance of a chi-squared of so many degrees of freedom, more than a Gaussian's where counts are few."""
        each = zip(self.summaries, self.weights, strict=True)
        more = (s.chi_squared_variance(0, num_events / w) for s, w in each if isinstance(s, TableSummary))
        return 2 * rank + sum(more)


@dataclass(frozen=True, eq=False)
class JointPart(Part):
    """A random part of each of several data sets."""

    task: JointTask
    sets: tuple[Measured, ...]
    """What is measured of each: events, or a part of tables."""

    def __len__(self) -> int:
        return self.first.num_events

    def split(self, aside: float, rng: np.random.Generator) -> "tuple[JointPart, JointPart]":
        fitted, held_out = zip(*(split(one, aside, rng) for one in self.sets), strict=True)
        return replace(self, sets=fitted), replace(self, sets=held_out)

    @cached_property
    def first(self) -> Target:
        targets = [
            one.first if isinstance(one, Part) else target_for(task, one, one)
            for task, one in zip(self.task.tasks, self.sets, strict=True)
        ]
        return self._joined(targets)

    def target(self, simulated: NDArray) -> Target:
        each = zip(self.task.tasks, self.sets, self.task.columns, strict=True)
        return self._joined([target_for(task, one, _of(task, simulated, at)) for task, one, at in each])

    def _joined(self, targets: list[Target]) -> Target:
        """All targets as one, of so many events that noise of simulation is right on average over what is fitted."""
        number = np.array([target.num_events for target in targets])
        num_events = max(round(np.average(number, weights=[max(target.rank, 1) for target in targets])), 1)
        weights = num_events / number
        names, columns = self.task.names, self.task.columns
        summary = StackedSummary(names, columns, tuple(target.summary for target in targets), weights)
        cov = block_diag(*(weight * target.cov for weight, target in zip(weights, targets, strict=True)))
        return Target.of(summary, np.concatenate([target.mean for target in targets]), num_events, cov)

    def seen_by(self, summary: Summary) -> tuple[NDArray[np.float64], int]:
        means = [
            one.seen_by(part_summary) if isinstance(one, Part) else (part_summary.mean(one)[0], len(one))
            for part_summary, one in zip(summary.summaries, self.sets, strict=True)
        ]
        return np.concatenate([mean for mean, _ in means]), max(round(summary.weights[0] * means[0][1]), 1)

    def as_events(self, task: Task, simulated: NDArray, rng: np.random.Generator) -> NDArray:
        """Each feature by itself: how those of one set go together is lost, and effects do not read that off."""
        shown = [
            one.as_events(part_task, _of(part_task, simulated, at), rng) if isinstance(one, Part) else one
            for part_task, one, at in zip(self.task.tasks, self.sets, self.task.columns, strict=True)
        ]
        least = min(map(len, shown))
        return np.hstack([rng.permutation(one)[:least].astype(task.dtype) for one in shown])


def _shares(mean: NDArray[np.float64], num_events: int) -> Shown:
    """Shares of events in bins, with their errors, of one event at least."""
    errors = np.sqrt(np.maximum(mean * (1 - mean), 1 / num_events) / num_events)
    return Shown(mean, errors, np.ones(len(mean)))


def _of(task: Task, x: NDArray, columns: slice) -> NDArray:
    """The features of one set, in the type of its task."""
    return np.ascontiguousarray(x[:, columns]).astype(task.dtype)
