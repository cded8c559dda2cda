"""The number of events that each part of a diagnosis simulates, and its progress through them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from avobench.diagnosis.settings import BUDGET, SUMMARY, TEST
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.joint import JointTask

Progress = Callable[[str, int, int], None]
"""A function of the phase, the simulated events so far, and about how many there will be."""


class Phases:
    """Tells `progress` the phase of a diagnosis with whatever a meter tells."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.phase, self.used, self.total = progress, "first fit", 0, total

    def begin(self, phase: str, more: int = 0) -> None:
        """A phase begins, for which `more` events are expected than for those before."""
        self.phase = phase
        self.total = max(self.total, self.used + more)
        self(self.used)

    def __call__(self, used: int) -> None:
        self.used = used
        if self.progress is not None:
            self.progress(self.phase, used, max(used, self.total))


@dataclass(frozen=True)
class Effort:
    """Numbers of simulated events. What is `per measured event` is multiplied by the number of measured events."""

    rounds: float = 1
    """Events of each round of the first fit, per measured event."""
    sharpen: float = 8
    """Events where a p-value is at stake, per measured event: simulation then adds a quarter to the variance."""
    reference: float = 5
    """Events of the model that candidates are added to, per measured event."""
    rounds_of_search: tuple[tuple[float, int], ...] = ((0.4, 7), (1.2, 4), (3.2, 2))
    """Events of the fits that go on, per measured event, and the steps of each."""
    few: int = 1000
    """Measured events that fewer count as in the line above."""
    settle: tuple[float, ...] = (1, 2, 4)
    """Multiples of a sharpening, for the last step of a fit, and to tell what the data say nothing about."""
    least: int = 1500
    """Events of a round, at least."""
    fit: int = 6_000
    """Events of each round of a candidate's first fit."""
    sample: int = 15_000
    """Events from which effects are screened."""
    generated: float = 10
    """Events of a slow generator that is asked only once, per measured event."""
    screen: int = 6_000
    """Events of a screening grid; each of its points gets a fiftieth of them at least."""
    covariance: int = 60_000
    """Events from which the covariance that a model predicts is taken, at most."""
    covariance_of_pairs: int = 0
    """The same, at least, where pairs of features have bins: of features that depend closely on each other hardly any
    event differs along some combinations of bins, and a few measured ones there reject a right simulator. Chosen on
    development cases."""
    metrics: int = 4
    """Tests of a model, at most, each with the covariance of where the one before ended: of one that is rejected, and
    never more of one that is not. Chosen on development cases."""
    scan: tuple[int, int] = (60, 150)
    """Points of each search for theta, and events at each."""
    rescan: tuple[int, int] = (240, 60)
    """The same where theta was missed, or the simulator is wrong: one of more points is near a narrow minimum, as that
    of a peak of unknown place. Chosen on development cases."""
    pairs: tuple[int, int] = (60, 100)
    """Thetas of each round of a search for two populations, and events at each."""
    starts: int = 30
    """Fits that begin, at most."""
    begun: int = 18
    """Fits that go on, at most."""

    @property
    def repeated(self) -> float:
        """Events with which a fit is repeated where no p-value is at stake, per measured event."""
        return min(self.reference, self.sharpen)

    @property
    def sure(self) -> "Effort":
        """The effort of the search for theta before a disagreement is believed: no limit makes it coarser than this."""
        return replace(
            self,
            rounds=max(self.rounds, 1),
            reference=max(self.reference, BUDGET.sure),
            sharpen=max(self.sharpen, BUDGET.sure),
            scan=self.rescan,
        )

    @property
    def beside(self) -> "Effort":
        """The effort for a further effect: a quarter of the fits that go on."""
        return replace(self, starts=self.starts // 3, begun=self.begun // 4)

    def of(self, num_events: int) -> "Effort":
        """The effort for so few measured events: their own scatter is more than that of fewer simulated ones."""
        points, events = self.scan
        return replace(
            self,
            fit=min(self.fit, max(num_events, 2000)),
            sample=min(self.sample, max(3 * num_events, 8000)),
            covariance=min(self.covariance, max(3 * num_events, 2000, self.covariance_of_pairs)),
            scan=(points, min(events, max(num_events // 100, 20))),
        )

    def scaled(self, share: float) -> "Effort":
        """The effort with less of everything, but not so little that fits fail."""
        return replace(
            self,
            rounds=max(self.rounds * share, 0.5),
            sharpen=max(self.sharpen * share, 1),
            reference=max(self.reference * share, 1),
            rounds_of_search=tuple((n * max(share, BUDGET.coarsest), steps) for n, steps in self.rounds_of_search),
            few=max(int(self.few * share), 500),
            least=max(int(self.least * share), 500),
            fit=max(int(self.fit * share), 1000),
            sample=max(int(self.sample * share), 3000),
            generated=max(self.generated * share, 2),
            screen=max(int(self.screen * share), 2000),
            scan=(self.scan[0], max(int(self.scan[1] * share), 20)),
            rescan=(max(int(self.rescan[0] * share), self.scan[0]), max(int(self.rescan[1] * share), 20)),
            pairs=(self.pairs[0], max(int(self.pairs[1] * share), 20)),
        )


IMAGES = Effort(
    rounds=2,
    sharpen=8,
    reference=12,
    few=10_000,
    rounds_of_search=((1, 6), (4, 2), (8, 1)),
    settle=(2,),
    least=8000,
    fit=8000,
    sample=12_000,
    screen=8000,
    covariance=30_000,
    scan=(60, 150),
    rescan=(60, 150),
    starts=12,
    begun=6,
)
"""The effort for images, which are slow to simulate and to summarise."""
MANY = Effort(
    rounds_of_search=((0.4, 6), (1.2, 2), (3.2, 1)), screen=4000, covariance_of_pairs=20_000, starts=15, begun=12
)
"""The effort for several features, each of which has its entries in the catalogue."""


def first_fit_events(effort: Effort, task: Task, num_events: int) -> int:
    """Simulated events, about, of the first fit to so many measured ones, of the tests, and of what follows them."""
    if task.generates:
        return int(max(effort.generated * num_events, effort.least)) + 2 * num_events
    points, events = effort.scan
    rounds = BUDGET.rounds * max(effort.least, effort.rounds * num_events)
    tests = effort.sharpen * max(num_events, TEST.few) + BUDGET.tests * num_events
    return int(BUDGET.scans * points * events + rounds + tests) + later_events(effort, num_events)


def later_events(effort: Effort, num_events: int) -> int:
    """Simulated events that are kept for the gaps and what follows them: most were simulated before."""
    return effort.covariance + num_events


def usual_events(domain: str, num_events: int) -> int:
    """Simulated events that a diagnosis of so many measured ones takes, about."""
    return dict(BUDGET.usual)[domain] * max(num_events, Effort.few) // BUDGET.usual_events


def full_effort(task: Task, domain: str, num_events: int) -> Effort:
    """The effort for so many measured events where nothing limits it."""
    if domain == "images":
        return IMAGES
    if isinstance(task, JointTask):  # one data set may take up what another lacks, so that more fits have to go on
        effort, pairs = Effort(), any(each.num_features > 1 for each in task.tasks)  # any of them may be large
    else:
        effort = MANY if task.num_features > 1 else Effort()
        pairs = task.num_features > 1 and num_events >= SUMMARY.paired
    return replace(effort, covariance_of_pairs=pairs * MANY.covariance_of_pairs).of(num_events)


def effort_for(task: Task, domain: str, num_simulations: int | None, num_events: int, num_spent: int = 0) -> Effort:
    """The effort with which the first fit to so many measured events and the tests fit into `num_simulations`.

    Of these, `num_spent` were spent before. The full effort for None. Raises UsageError where even the least does not
    fit.
    """
    full = full_effort(task, domain, num_events)
    if num_simulations is None:
        return full
    least, available = first_fit_events(full.scaled(0), task, num_events), num_simulations - num_spent
    if available < least:
        raise UsageError(
            f"{num_simulations} simulated events are too few: the checks, the first fit and the tests need "
            f"{int(BUDGET.with_checks * least)}"
        )
    share = float(np.clip((available - least) / usual_events(domain, num_events), 0, 1))
    while first_fit_events(full.scaled(share), task, num_events) > available:
        share = share * BUDGET.step if share > BUDGET.least_share else 0.0
    return full.scaled(share)
