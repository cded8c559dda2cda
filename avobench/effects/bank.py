"""Simulated events at the nodes of a lattice of parameters, made on demand, kept, and used again."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.meter import Meter
from avobench.tasks.pieces import in_pieces
from avobench.tasks.region import regions
from avobench.tasks.sample import SampleTask

COARSEST = 4
"""The spacing of the lattice is 2^-4 of the range of each parameter, at most."""
FINEST = 40
"""Nodes are numbered in steps of 2^-40 of the range, so that those of a lattice are nodes of all finer ones. With this
spacing the lattice begins: every theta is a node of its own."""

PIECE = 20_000
"""Events that a process makes at a time. Each piece has a stream of its own, so that their number changes no event."""


class Bank:
    """A simulator whose events are never made twice: each is of a node of a lattice in theta, and is kept there.

    An event that is asked for at theta is one of a corner of the cell of the lattice that theta lies in. The corners
    are those of Freudenthal's triangulation, drawn with the weights of linear interpolation: the mean of any function
    of the events is that of the simulator, interpolated between nodes (H. Freudenthal, Ann. Math. 43 (1942) 580).

    Every session begins with the first events of each node, and a node makes more only where a session asks for more
    than it has. So no event comes twice within a session, and what one fit has simulated serves all others.
    """

    worth = 1.0
    """What an event tells, in those of equal weight."""

    def __init__(self, task: Task, meter: Meter, seed: int, jobs: int = 1) -> None:
        self.task, self.meter, self.jobs = task, meter, jobs
        self._seed, self._size = seed, 0
        regions(task)  # where it works is learnt here, and not by each process that simulates
        self.fills = 0
        """How often events came into the bank."""
        self._low, self._high = np.array(task.support.low), np.array(task.support.high)
        self._step = np.ones(len(self._low), np.int64)
        self._events = np.empty((0, task.num_features), task.dtype)
        """With room for more: the first `_size` rows are events."""
        self._nodes: dict[bytes, NDArray[np.intp]] = {}
        """Where the events of each node stand among all, by its `_key`."""
        self._handed: dict[bytes, int] = {}
        """The most events of each node that a session was handed out: a bank that was kept may have more."""

    def resolve(self, scale: NDArray[np.float64]) -> None:
        """Make the lattice so fine that its spacing is at most `scale` (p,), in shares of each parameter's range."""
        finest = np.clip(np.floor(np.log2(scale)), COARSEST - FINEST, -COARSEST)
        self._step = 2 ** (FINEST + finest.astype(int))

    def fresh(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """Events that no session hands out, kept aside for whoever needs such: theta (n, p) -> (n, d)."""
        return self.take(theta, rng, {}, aside=True)

    def repeats(self, taken: dict[bytes, int]) -> float:
        """How often a session that has `taken` so many events of each node had each of them: once."""
        return 1.0

    def session(self) -> "Session":
        """A simulator that hands out each event of the bank once."""
        return Session(self)

    def take(
        self, theta: NDArray[np.float64], rng: np.random.Generator, taken: dict[bytes, int], aside: bool = False
    ) -> NDArray:
        """An event for each row of theta, beyond those of each node that are `taken`: (n, p) -> (n, d).

        They are of those kept aside, or of all others; what is lacking is simulated. Raises BudgetExhausted.
        """
        keys, which, counts = self.draw(theta, rng, taken, aside)
        order, rows = np.argsort(which, kind="stable"), np.empty(len(theta), np.intp)
        ends = [taken[key] for key in keys]
        chosen = [self._rows(key, end - n, end) for key, end, n in zip(keys, ends, counts.tolist(), strict=True)]
        rows[order] = np.concatenate([rows[:0], *chosen])
        return self._events[rows]

    def _rows(self, key: bytes, start: int, end: int) -> NDArray[np.intp]:
        """Where these events of a node stand among all."""
        return self._nodes[key][start:end]

    def draw(
        self, theta: NDArray[np.float64], rng: np.random.Generator, taken: dict[bytes, int], aside: bool = False
    ) -> tuple[list[bytes], NDArray[np.intp], NDArray[np.intp]]:
        """The nodes that rows of theta (n, p) have an event of: their keys, which of them each row has, and how often.

        These events are then `taken`, and what is lacking is simulated. Raises BudgetExhausted.
        """
        corners = self._corners(theta, rng)
        nodes, which, counts = distinct_rows(corners)
        keys = [_key(node, aside) for node in nodes]
        first = np.array([taken.get(key, 0) for key in keys], np.intp)
        have = np.array([len(self._nodes.get(key, ())) for key in keys], np.intp)
        order, place = np.argsort(which, kind="stable"), np.empty(len(theta), np.intp)
        place[order] = np.arange(len(theta)) + np.repeat(first - np.cumsum(counts) + counts, counts)
        with self.meter.paying(self.task):
            self._make(corners[place >= have[which]], aside)
        taken.update(zip(keys, (first + counts).tolist(), strict=True))
        self._handed.update((key, max(taken[key], self._handed.get(key, 0))) for key in keys)
        return keys, which, counts

    def handed(self, keys: list[bytes]) -> tuple[NDArray[np.float64], NDArray, NDArray[np.intp]]:
        """The thetas of nodes, all their events that any session was handed out, and the node of each.

        (m, p), (n, d), (n,).
        """
        theta = self._theta(np.array([np.frombuffer(key, np.int64) for key in keys]))
        groups = [self._nodes[key][: self._handed[key]] for key in keys]
        return theta, self._events[np.concatenate(groups)], np.repeat(np.arange(len(keys)), list(map(len, groups)))

    def _theta(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        return np.clip(self._low + nodes / 2.0**FINEST * (self._high - self._low), self._low, self._high)

    def _corners(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.int64]:
        """A random corner of the cell around each row of theta (n, p), in steps of 2^-FINEST of the range: (n, p)."""
        at = (theta - self._low) / (self._high - self._low) * (2.0**FINEST / self._step)
        below = np.floor(at)
        # Of the finest lattice it is the nearest, so that the same theta is always the same node.
        above = np.where(self._step == 1, 0.5, rng.random((len(theta), 1)))
        return (below + (at - below > above)).astype(np.int64) * self._step

    def _make(self, rows: NDArray[np.int64], aside: bool) -> None:
        if not len(rows):
            return
        theta = self._theta(rows)
        self.meter.charge(len(theta))
        seeds = np.random.SeedSequence([self._seed, self.fills]).spawn(-(-len(theta) // PIECE))
        pieces = [theta[k * PIECE : (k + 1) * PIECE] for k in range(len(seeds))]
        self._keep(rows, theta, in_pieces(self.task, pieces, seeds, self.jobs), aside)

    def _keep(self, nodes: NDArray[np.int64], theta: NDArray[np.float64], x: NDArray, aside: bool) -> None:
        self.add(nodes, x, aside)

    def add(self, nodes: NDArray[np.int64], x: NDArray, aside: bool = False) -> None:
        """Put events x (n, d) of these nodes (n, p) into the bank."""
        at, end = self._size, self._size + len(x)
        if end > len(self._events):
            room = np.empty((2 * end, self.task.num_features), self.task.dtype)
            room[:at] = self._events[:at]
            self._events = room
        self._events[at:end] = x
        self.fills, self._size = self.fills + 1, end
        distinct, which, counts = distinct_rows(nodes)
        groups = np.split(at + np.argsort(which, kind="stable"), np.cumsum(counts)[:-1])
        for node, more in zip(distinct, groups, strict=True):
            key = _key(node, aside)
            self._nodes[key] = np.r_[self._nodes[key], more] if key in self._nodes else more


class Given(Bank):
    """The events of a sample, and no more; a session that asks for more gets the first ones again."""

    def __init__(self, task: SampleTask, meter: Meter) -> None:
        self.task, self.meter, self.worth = task, meter, task.worth
        meter.add(len(task.events))
        self._events, self._nodes = task.events, {}
        for aside, groups in ((False, task.groups), (True, task.aside)):
            self._nodes |= {_key(np.int64(number), aside): group for number, group in enumerate(groups)}
        self._handed = {key: len(group) for key, group in self._nodes.items()}

    def resolve(self, scale: NDArray[np.float64]) -> None:
        """The nodes are those that there are."""

    def draw(
        self, theta: NDArray[np.float64], rng: np.random.Generator, taken: dict[bytes, int], aside: bool = False
    ) -> tuple[list[bytes], NDArray[np.intp], NDArray[np.intp]]:
        """The thetas of the sample that rows of theta (n, p) have an event of, as in `Bank.draw`."""
        nodes, which, counts = np.unique(self.task.corner(theta, rng), return_inverse=True, return_counts=True)
        keys = [_key(node, aside) for node in nodes.astype(np.int64)]
        taken.update((key, taken.get(key, 0) + count) for key, count in zip(keys, counts.tolist(), strict=True))
        return keys, which, counts

    def _rows(self, key: bytes, start: int, end: int) -> NDArray[np.intp]:
        return self._nodes[key][np.arange(start, end) % len(self._nodes[key])]

    def _theta(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        return self.task.nodes[nodes[:, 0]]

    def num_around(self, theta: NDArray[np.float64]) -> float:
        """How many events of equal weight at theta (p,) tell as much as all those of the nodes around it."""
        return float(self.worth / (self.task.around(theta) ** 2 / self.task.sizes).sum())

    def repeats(self, taken: dict[bytes, int]) -> float:
        """How often a session that has `taken` so many events of each node had each of them, on average."""
        have = sum(min(count, len(self._nodes[key])) for key, count in taken.items())
        return sum(taken.values()) / max(have * self.worth, 1) if taken else 1.0


class Session:
    """A simulator with the events of a bank, of which each comes once."""

    def __init__(self, bank: Bank) -> None:
        self._bank = bank
        self._taken: dict[bytes, int] = {}

    def __copy__(self) -> "Session":
        """A session that will hand out the same events as this one."""
        other = Session(self._bank)
        other._taken = self._taken.copy()
        return other

    def __call__(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """theta (n, p) -> (n, d). Raises BudgetExhausted."""
        return self._bank.take(theta, rng, self._taken)

    def after(self, other: "Session") -> "Session":
        """A session of the same bank that hands out what neither of two has."""
        later = Session(self._bank)
        for node in self._taken.keys() | other._taken.keys():
            later._taken[node] = max(self._taken.get(node, 0), other._taken.get(node, 0))
        return later

    @property
    def repeats(self) -> float:
        """How often each event was handed out, on average: by that the variance of a mean is larger than it seems."""
        return self._bank.repeats(self._taken)


def _key(node: NDArray[np.int64] | np.int64, aside: bool) -> bytes:
    return node.tobytes() + b"aside" * aside


def distinct_rows(rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.intp], NDArray[np.intp]]:
    """The distinct rows (k, p) among these (n, p), which of them each one is (n,), and how often each comes (k,)."""
    number = np.zeros(len(rows), np.int64)
    for column in rows.T:
        which, values = pd.factorize(column)
        number = pd.factorize(number * len(values) + which)[0]
    counts = np.bincount(number)
    first = np.empty(len(counts), np.intp)
    first[number[::-1]] = np.arange(len(rows))[::-1]
    return rows[first], number, counts
