"""A simulator that fails at some parameters: the region where it works is learnt, and events are made there."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from subprocess import SubprocessError
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Task
from avobench.tasks.errors import BudgetExhausted, SimulatorError, raised

Failed = Literal["raise", "region"]
"""What is done where a simulator fails."""
FAILURES = (ValueError, ArithmeticError, RuntimeError, TimeoutError, SubprocessError)
"""What a simulator raises that fails; all else is a fault of its code."""
TRIED = 512
"""Parameters at which a simulator is tried to learn where it works; a power of two, as Sobol's sequence needs."""
LEAST = 0.05
"""A simulator that works at a smaller share of them is not used."""
TIMES = 10
"""So often an event that failed is made again at the same parameters; then at the nearest ones known to work."""
MOST = 1000
"""So often it is made again at all."""
DEPTH = 0.5
"""What is asked for outside of the region is made so deep in it: 0 at its edge, 1 at the machine's margin."""
STEPS = 12
"""Halvings of the way to parameters that work, by which the edge of the region is found."""
CALLS, MADE, AGAIN, MOVED = range(4)
DRAWS = 10_000
"""Draws of the prior by which the share of it that works is told."""


class Region:
    """Where a simulator works, learnt from events that were tried all over its support, and what failed.

    Parameters are in the region where a support vector machine says so (C. Cortes, V. Vapnik, Mach. Learn. 20 (1995)
    273): mostly where more than half of the events near by were made. `call` makes events of theta (n, p): (n, d), and
    raises one of FAILURES, or returns rows that are not finite, where it fails.
    """

    def __init__(
        self,
        task: Task,
        call: Callable[[NDArray, np.random.Generator], NDArray],
        per_theta: bool,
        learnt: Mapping[str, Any] | None,
    ) -> None:
        """Try the simulator, or take what was `learnt` at an earlier time.

        Raises SimulatorError where it hardly ever works.
        """
        from scipy.stats import qmc

        self._task, self._call, self._per_theta = task, call, per_theta
        self.reason = learnt["reason"] if learnt else "it returned NaN or infinity"
        """Why it failed last."""
        self._raises = False
        self.charge: Callable[[int], None] | None = None
        """What is told of events before they are made in place of failed ones, see `Meter.paying`."""
        self._charged = 0
        self.counts = np.zeros(4, np.int64)
        """Events that were asked of the simulator, that it was asked for, that were made again after one had failed,
        and those made at other parameters since theirs failed every time."""
        self._low, self._width = np.array(task.support.low), task.support.width
        theta = self._low + qmc.Sobol(len(self._low), seed=0).random(TRIED) * self._width
        theta = np.where(task.is_integer, np.rint(theta), theta)
        self.worked = np.array(
            ~self._attempted(theta, np.random.default_rng(0))[1] if learnt is None else learnt["worked"], bool
        )
        """Whether it worked at each of those that were tried: (TRIED,)."""
        self._tried = (theta - self._low) / self._width
        if self.worked.mean() < LEAST:
            raise SimulatorError(
                f"the simulator of {task.name} failed at {(~self.worked).sum()} of {TRIED} thetas within its support, "
                f"such as {theta[~self.worked][0].tolist()} ({self.reason}): mend it, or narrow its prior and support"
            )

    @property
    def learnt(self) -> dict[str, Any]:
        """What is known of it, as plain lists and texts."""
        return {"reason": self.reason, "worked": self.worked.tolist()}

    @property
    def within_it(self) -> tuple[int, int]:
        """Of the thetas in the region at which it was tried: at how many it failed, and how many there are."""
        worked = self.worked[self._depth(self._tried) >= 0]
        return int((~worked).sum()), len(worked)

    @property
    def beside(self) -> int:
        """Events that were asked of the simulator beside those that it was asked for."""
        return int(self.counts[CALLS] - self.counts[MADE])

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "charge": None}  # a copy in another process only counts

    def uncharged(self) -> int:
        """Events beside those that it was asked for which nobody was told of."""
        more, self._charged = self.beside - self._charged, self.beside
        return max(more, 0)

    def _count(self, num_events: int) -> None:
        """Count events that are about to be asked of the simulator. Raises BudgetExhausted as `charge` does."""
        more = self.beside + num_events - self._charged
        if more > 0 and self.charge is not None:
            self.charge(more)
        self._charged += max(more, 0)
        self.counts[CALLS] += num_events

    @cached_property
    def _machine(self) -> Any:
        from sklearn.svm import SVC

        return None if self.worked.all() else SVC().fit(self._tried, self.worked)

    def contains(self, theta: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether each row of theta (n, p) is in the region: (n,)."""
        return self._depth((theta - self._low) / self._width) >= 0

    def _depth(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """How clearly each row (n, p) of the unit cube is in the region, above 0, or outside of it: (n,)."""
        return np.full(len(unit), np.inf) if self._machine is None else self._machine.decision_function(unit)

    @cached_property
    def _working(self) -> tuple[NDArray[np.float64], Any]:
        """Parameters in the region that worked, in the unit cube (k, p), clearly if there are any; and their tree."""
        from scipy.spatial import cKDTree

        depth = np.where(self.worked, self._depth(self._tried), -np.inf)
        working = self._tried[depth >= min(DEPTH, depth.max())]
        return working, cKDTree(working)

    def _nearest(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        working, tree = self._working
        return working[tree.query(unit)[1]]

    def within(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Parameters (n, p), those outside of the region moved just into it, on the way to the nearest that worked."""
        unit = (theta - self._low) / self._width
        outside = np.flatnonzero(self._depth(unit) < 0)
        if not len(outside):
            return theta
        far, near = unit[outside], self._nearest(unit[outside])
        for _ in range(STEPS):
            middle = (near + far) / 2
            inside = self._depth(middle)[:, None] >= DEPTH
            near, far = np.where(inside, middle, near), np.where(inside, far, middle)
        moved = theta.copy()
        moved[outside] = self._theta(near)
        return moved

    def _theta(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        theta = np.clip(self._low + unit * self._width, self._low, self._task.support.high)
        return np.where(self._task.is_integer, np.rint(theta), theta)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row, at the edge of the region for those outside: theta (n, p) -> (n, d).

        Raises SimulatorError where it fails again and again.
        """
        theta = self.within(theta).copy()
        self._charged = self.beside
        self.counts[MADE] += len(theta)
        x, failed = self._attempted(theta, rng)
        for k in range(MOST):
            rows = np.flatnonzero(failed)
            if not len(rows):
                return x
            self.counts[AGAIN] += len(rows)
            if k == TIMES:
                self.counts[MOVED] += len(rows)
                theta[rows] = self._theta(self._nearest((theta[rows] - self._low) / self._width))
            x[rows], failed[rows] = self._attempted(theta[rows], rng, apart=self._raises)
        raise SimulatorError(f"the simulator of {self._task.name} failed {MOST} times at {theta[rows[0]].tolist()}")

    def _attempted(
        self, theta: NDArray[np.float64], rng: np.random.Generator, apart: bool = False
    ) -> tuple[NDArray, NDArray[np.bool_]]:
        """Events (n, d), made in one call or each `apart`, and which of them failed (n,).

        An exception ends a call. Its events are then split into about as many calls as each has events, so that one
        that fails costs few others.
        """
        x = np.zeros((len(theta), self._task.num_features), self._task.dtype)
        failed = np.ones(len(theta), bool)
        calls = np.split(np.arange(len(theta)), len(theta) if apart else 1)
        if self._per_theta:
            _, which, counts = np.unique(theta, axis=0, return_inverse=True, return_counts=True)
            calls = np.split(np.argsort(which, kind="stable"), np.cumsum(counts)[:-1])
        while calls:
            rows = calls.pop()
            self._count(len(rows))
            try:
                made = self._call(theta[rows], rng)
            except FAILURES as error:
                self.reason = raised(error)
                if len(rows) > 1 and not self._per_theta:
                    self._raises = True
                    calls += np.array_split(rows, int(np.ceil(np.sqrt(len(rows)))))
                continue
            except (SimulatorError, BudgetExhausted):
                raise
            except (Exception, SystemExit) as error:
                raise SimulatorError(f"the simulator of {self._task.name} raised {raised(error)}") from error
            if made.shape != (len(rows), self._task.num_features):
                raise SimulatorError(f"the simulator of {self._task.name} returned events of shape {made.shape}")
            fine = ~self._task.broken(made)
            if x.dtype.kind == "i" and (made[fine] != np.rint(made[fine])).any():
                raise SimulatorError(f"the simulator of {self._task.name} returned fractions where counts were due")
            x[rows[fine]], failed[rows] = made[fine], ~fine
        return x, failed

    def notes(self, theta: NDArray[np.float64] | None = None, std: NDArray[np.float64] | None = None) -> list[str]:
        """What failed, and where: sentences for the answer of a fit that found theta with errors std (p,)."""
        name, notes = self._task.name, []
        if lost := int((~self.worked).sum()):
            share = self.contains(self._task.prior.sample(DRAWS, np.random.default_rng(0))).mean()
            notes.append(
                f"{name} failed at {lost} of {TRIED} thetas at which it was tried ({self.reason}){self._where()}; the "
                f"fit keeps to where it works, {100 * share:.3g} % of the prior"
            )
        if again := int(self.counts[AGAIN]):
            notes.append(
                f"{again} later events of {name} have failed and were made again at the same theta, "
                f"{self.counts[MOVED]} of them at the nearest theta that is known to work; its events are those that "
                "succeed"
            )
        if (
            theta is not None
            and not self.contains(np.vstack([theta, theta + np.diag(std), theta - np.diag(std)])).all()
        ):
            notes.append(
                f"theta or its error reaches out of the region where {name} works: what lies beyond is not known"
            )
        return notes

    def _where(self) -> str:
        """Where most failures are, as the one condition on one parameter that tells them best."""
        from sklearn.tree import DecisionTreeClassifier

        tree = DecisionTreeClassifier(max_depth=1).fit(self._tried, self.worked).tree_
        if tree.node_count < 3:
            return ""
        k, cut = int(tree.feature[0]), float(tree.threshold[0])
        above = self._tried[:, k] > cut
        side, beyond = (">", above) if self.worked[above].mean() < self.worked[~above].mean() else ("<", ~above)
        held = (beyond & ~self.worked).sum() / (~self.worked).sum()
        return (
            f", {100 * held:.0f} % of them where {self._task.parameter_names[k]} {side} "
            f"{self._low[k] + cut * self._width[k]:.3g}"
        )


def failing(task: Task) -> list[Any]:
    """The task itself, or those that it is made of, whose simulator may fail."""
    itself = [task] if getattr(task, "failed", "raise") == "region" else []
    return itself + [one for part in task.tasks for one in failing(part)]


def regions(task: Task) -> list[Region]:
    """The regions of these; they are learnt, unless they were before."""
    return [one.region for one in failing(task)]


def recall(task: Task, learnt: Sequence[Mapping[str, Any]]) -> None:
    """Tell tasks what was `learnt` of their regions. Raises KeyError, TypeError or ValueError for what is none."""
    for one, record in zip(failing(task), learnt, strict=True):
        if len(record["worked"]) != TRIED:
            raise ValueError(f"it has {len(record['worked'])} in place of {TRIED}")
        one.__dict__.setdefault("region", one.region_of(record))


def beside(task: Task) -> int:
    """Events that simulators were asked for beside those of a task: to learn a region, and in place of failed ones."""
    return sum(one.region.beside for one in failing(task) if "region" in one.__dict__)


def failures(task: Task, theta: NDArray[np.float64], std: NDArray[np.float64]) -> list[str]:
    """What failed of the simulators of a task, for the answer of a fit that found theta with errors std (p,)."""
    task_region = getattr(task, "region", None)
    return [
        note
        for region in regions(task)
        for note in (region.notes(theta, std) if region is task_region else region.notes())
    ]
