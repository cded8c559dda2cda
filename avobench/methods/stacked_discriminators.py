"""The discriminators of `avo`, two a problem, of all problems that are inferred together: trained in one batch.

On a graphics card thirty small networks in one product of matrices cost little more than two. How many problems there
are concerns this module alone; what one problem does stands in `avo.py`. Needs PyTorch as it loads.
"""

from collections.abc import Generator, Sequence
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import Sequential
from torch.nn.functional import logsigmoid

from avobench.methods.contract import Estimate
from avobench.methods.fused_step import FusedStep


class Lesson(NamedTuple):
    """The events that one problem gives its two discriminators in one iteration, and those to judge afterwards.

    Those in even rows are of the first half, whose network is the first, those in odd rows of the second.
    """

    fresh: NDArray[np.float32]
    """Events simulated since the last lesson, as the discriminators see them (m, k)."""
    rows: NDArray[np.int64]
    """Rows of the observed and of the simulated events to train with: (2, steps, 2 networks, batch)."""
    judged: slice
    """The simulated events of which log(1 - d) is wanted; from an even row to the last that was simulated."""
    learning_rate: float


Game = Generator[Lesson, NDArray[np.float64], Estimate]
"""One problem: it yields lessons, is sent log(1 - d) of the events to be judged (n,), and returns its estimate."""


class StackedDiscriminators:
    """Two networks for each of P problems whose observations, budgets and settings are of one size.

    `networks` are P pairs; they are trained in place. `real` are the P sets of observed events (N, k) as the networks
    see them. Up to `num_events` simulated events are kept for each problem. With `cross_fit` a network judges the
    events that the other of its pair was trained on, else its own.
    """

    def __init__(
        self,
        networks: Sequence[Sequence[Sequential]],
        real: Sequence[NDArray[np.float32]],
        num_events: int,
        *,
        r1: float,
        cross_fit: bool,
        device: str,
    ) -> None:
        self.cross_fit = cross_fit
        self.step = FusedStep([network.to(device) for pair in networks for network in pair], 0.0, r1)
        self.real = torch.from_numpy(np.stack(real)).to(device)
        self.synthetic = torch.empty((len(real), num_events, self.real.shape[2]), device=device)

    def learn(self, lessons: Sequence[Lesson]) -> NDArray[np.float64]:
        """Train all networks with a lesson for each problem, and judge: log(1 - d) of the events asked for (P, n)."""
        judged = lessons[0].judged
        for events, lesson in zip(self.synthetic, lessons, strict=True):
            events[judged.stop - len(lesson.fresh) : judged.stop] = torch.from_numpy(lesson.fresh)
        self.step.learning_rate = lessons[0].learning_rate
        self._train(np.concatenate([lesson.rows for lesson in lessons], axis=2))
        return self._log_one_minus_d(self.synthetic[:, judged])

    def _train(self, rows: NDArray[np.int64]) -> None:
        """One update for each of (2, steps, 2 P networks, batch) rows, which count within each problem."""
        problem = np.repeat(np.arange(len(self.real)), 2)[:, None]
        rows[0] += self.real.shape[1] * problem
        rows[1] += self.synthetic.shape[1] * problem
        real, synthetic = self.real.flatten(0, 1), self.synthetic.flatten(0, 1)
        for r, s in zip(*torch.from_numpy(rows).to(real.device), strict=True):
            self.step(real[r], synthetic[s])

    def _log_one_minus_d(self, events: torch.Tensor) -> NDArray[np.float64]:
        """(P, n, k) -> (P, n), each event by the network that is to judge it."""
        halves = events.unflatten(1, (-1, 2)).transpose(1, 2)  # (problems, half, events, inputs)
        f = logsigmoid(-self.step.logits(self._other(halves).flatten(0, 1))).unflatten(0, (-1, 2))
        return self._other(f).transpose(1, 2).flatten(1).cpu().numpy().astype(np.float64)

    def _other(self, halves: torch.Tensor) -> torch.Tensor:
        return halves.flip(1) if self.cross_fit else halves


def play(games: Sequence[Game], discriminators: StackedDiscriminators) -> list[Estimate]:
    """Carry out all games in step, lesson by lesson, and return their estimates."""
    verdicts: Sequence[NDArray[np.float64] | None] = [None] * len(games)  # nothing is judged before the first lesson
    while True:
        lessons, estimates = [], []
        for game, verdict in zip(games, verdicts, strict=True):
            try:
                lessons.append(game.send(verdict))
            except StopIteration as end:
                estimates.append(end.value)
        if estimates:  # games of one size end together
            return estimates
        verdicts = discriminators.learn(lessons)
