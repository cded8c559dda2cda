"""What the adapters of sbi share: rounds of simulation, and one network a round that is trained on tensors in memory.

The networks, their standardisation and their losses are sbi's. The loop is our own, because sbi's data loader hands
over one row at a time and took most of the time: the same optimiser (Adam), held-out share and choice of the best
epoch.
"""

import copy
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.contract import Estimate, Method, TracePoint, global_seed
from avobench.methods.inputs import origin
from avobench.methods.problem import Problem
from avobench.methods.product_posterior import LogFactors, Posterior, posterior
from avobench.tasks import Box
from avobench.tasks.errors import UsageError

if TYPE_CHECKING:
    from torch import Tensor, nn

HELD_OUT = 0.1
"""The share of the rows by which the best epoch is chosen; sbi's default."""
LOOKS = 20
"""Number of times in a training that the held-out rows are looked at: often enough to stop near the best step."""
LARGEST_GRADIENT = 5.0
"""The norm at which a step's gradient is cut; sbi's default."""
SHRINK = 0.5
"""Least width of a round's box in that of the one before: a posterior from few events may be too narrow."""
SPREADS = 6.0
"""Least half width of a round's box in standard deviations of the posterior before it, which then lies well within."""
EDGE = 1e-3
"""Share of a box's width at each end that `logit` leaves out, since the logit is infinite at the end itself."""


@dataclass(frozen=True)
class Neural(Method):
    """Rounds of simulation with a network each, trained on all events in the round's box.

    The box of the first round is the prior's, later ones are truncated around the posterior of the round before. theta
    is uniform in each, so that events of earlier rounds within the box are drawn as if in this one, and serve again.
    """

    version: ClassVar[str] = "2"
    packages: ClassVar = ("sbi",)
    extra: ClassVar = "sbi"
    first_rows: ClassVar[int] = 400
    """Rows of the observation with which the search of the posterior begins."""

    amortised: bool = False
    """Use the same events and the same network for every target of a task: one budget for all of them."""
    rounds: int = 1
    """Number of rounds, each with an equal share of the budget."""
    hidden: int = 50
    """Nodes of a hidden layer; sbi's default."""
    steps: int = 1800
    """Training steps in each round, of whose twenty states the best by the held-out rows counts."""
    batch_size: int = 1024
    """Rows of a training step."""
    learning_rate: float = 2e-3
    """Learning rate of Adam at the start; it falls to 0 along a cosine."""

    def __post_init__(self) -> None:
        if min(self.rounds, self.hidden, self.steps, self.batch_size) < 1 or self.learning_rate <= 0:
            raise UsageError(
                f"{self.name} needs rounds, hidden, steps, batch_size of at least 1 and learning_rate above 0"
            )
        if self.amortised and self.rounds > 1:
            raise UsageError(f"{self.name} can be amortised in one round only: later ones depend on the observation")

    @property
    def together(self) -> bool:
        return self.amortised

    @property
    def from_prior(self) -> bool:
        return self.rounds == 1

    def min_simulations(self, num_parameters: int) -> int:
        return 1000 * self.rounds

    def rows(self, problem: Problem, x: NDArray, rng: np.random.Generator) -> NDArray[np.float32]:
        """Events (n, d) as a network sees them, (n, k): an image is summed over its cyclic axes."""
        if problem.cyclic_axes:
            x = x.reshape(-1, *problem.event_shape).sum(axis=tuple(1 + axis for axis in problem.cyclic_axes))
        elif not self.amortised and (start := origin(problem.x_observed)).any():  # one network has one origin
            x = x - start
        return x.reshape(len(x), -1).astype(np.float32)

    def simulated(self, problem: Problem, box: Box, number: int, rng: np.random.Generator) -> tuple[NDArray, NDArray]:
        """Draws of theta (n, p), uniform in the box, and a row for each (n, k), from at most `number` events."""
        theta = box.sample(number, rng)
        return theta, self.rows(problem, problem.simulate(theta), rng)

    def observed(self, problem: Problem, rng: np.random.Generator) -> NDArray[np.float32]:
        """The observation as independent rows like the simulated ones: (m, k)."""
        return self.rows(problem, problem.x_observed, rng)

    @abstractmethod
    def learned(self, theta: NDArray, rows: NDArray, box: Box, rng: np.random.Generator) -> LogFactors:
        """The factors of the posterior that a network learns from theta (n, p), uniform in the box, and rows (n, k)."""

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        return self.infer_together([problem], [rng])[0]

    def infer_together(self, problems: Sequence[Problem], rngs: Sequence[np.random.Generator]) -> list[Estimate]:
        import torch  # noqa: F401 - global_seed seeds what has been imported

        estimates, shared = [], None
        for problem, rng in zip(problems, rngs, strict=True):
            box, trace = problem.prior, []
            theta, rows = np.empty((0, box.dim)), None
            total = max(problem.simulate.remaining, self.min_simulations(box.dim))
            for end in problem.simulate.used + np.linspace(0, total, self.rounds + 1).astype(int)[1:]:
                simulating, learning, searching = rng.spawn(3)
                new, summaries = self.simulated(problem, box, end - problem.simulate.used, simulating)
                inside = box.contains(theta)
                theta = np.concatenate([theta[inside], new])
                rows = summaries if rows is None else np.concatenate([rows[inside], summaries])
                if shared is None:
                    with global_seed(learning):
                        factors = self.learned(theta.astype(np.float32), rows.astype(np.float32), box, learning)
                    shared = factors if self.amortised else None
                factors = shared or factors
                fitted = posterior(factors, self.observed(problem, searching), box, searching, self.first_rows)
                trace.append(TracePoint(problem.simulate.used, fitted.mode, fitted.std))
                box = _truncated(box, fitted)
            note = "all factors share the error of one network, which the width leaves out: it is mostly far too small"
            estimate = Estimate(
                theta=fitted.mode,
                how="maximum of the posterior, the product of a learned factor for each row",
                spread_of="posterior",
                mean=fitted.mean,
                std=fitted.std,
                trace=trace,
                sample=fitted.sample,
                message=note,
                doubt=fitted.doubt,
            )
            estimates.append(estimate)
        return estimates


def _truncated(box: Box, fitted: Posterior) -> Box:
    half = np.maximum(SPREADS * fitted.std, SHRINK * box.width / 2)
    low = np.clip(fitted.mean - half, box.low, np.array(box.high) - 2 * half)
    low = np.maximum(low, box.low)
    return Box(tuple(low), tuple(np.minimum(low + 2 * half, box.high)))


def train(
    network: "nn.Module",
    loss: Callable[["Tensor", "Tensor"], "Tensor"],
    theta: NDArray[np.float32],
    rows: NDArray[np.float32],
    method: Neural,
    rng: np.random.Generator,
) -> None:
    """Bring a network to the least mean loss of theta (n, p) and rows (n, k) on those held out; n of at least 2."""
    import torch

    order = rng.permutation(len(theta))
    theta, rows = torch.as_tensor(theta[order]), torch.as_tensor(rows[order])
    held = max(1, int(HELD_OUT * len(theta)))
    size = min(method.batch_size, len(theta) - held)
    batches = _batches(held, len(theta), size, rng)
    optimiser = torch.optim.Adam(network.parameters(), lr=method.learning_rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, method.steps)
    looks = set(np.linspace(0, method.steps - 1, LOOKS + 1).astype(int)[1:].tolist())
    best, least = copy.deepcopy(network.state_dict()), np.inf
    for step in range(method.steps):
        network.train()
        chosen = torch.as_tensor(next(batches))
        optimiser.zero_grad()
        loss(theta[chosen], rows[chosen]).backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), LARGEST_GRADIENT)
        optimiser.step()
        schedule.step()
        if step not in looks:
            continue
        network.eval()
        with torch.no_grad():
            now = float(loss(theta[:held], rows[:held]))
        if now < least:
            best, least = copy.deepcopy(network.state_dict()), now
    network.load_state_dict(best)
    network.eval()


def _batches(low: int, high: int, size: int, rng: np.random.Generator) -> Iterator[NDArray[np.int64]]:
    """Yield whole batches (size,) of the rows from low to high without end, each time round in another order."""
    while True:
        order = low + rng.permutation(high - low)
        for start in range(0, high - low - size + 1, size):
            yield order[start : start + size]


def logit(theta: "Tensor", box: Box) -> tuple["Tensor", "Tensor"]:
    """Move theta (n, p) from a box to the real line (n, p), with log |d logit / d theta| (n,) up to a constant."""
    import torch

    unit = (theta - torch.tensor(box.low).float()) / torch.tensor(box.width).float()
    unit = unit.clamp(EDGE, 1 - EDGE)
    return unit.logit(), -(unit.log() + (1 - unit).log()).sum(-1)
