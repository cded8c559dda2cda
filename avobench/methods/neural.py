"""What the adapters of sbi have in common: rounds of simulation, one network a round, trained on tensors in memory.

The networks, their standardisation and their losses are sbi's. The loop is our own, because sbi's data loader hands over
one row at a time and took most of the time: the same optimiser (Adam), held-out share and choice of the best epoch.
"""

import copy
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.contract import Estimate, Method, TracePoint, global_seed
from avobench.methods.problem import Problem
from avobench.methods.product_posterior import Posterior
from avobench.tasks import Box
from avobench.tasks.errors import UsageError

if TYPE_CHECKING:
    from torch import Tensor, nn

HELD_OUT = 0.1
"""Share of the rows by which the best epoch is chosen; sbi's default."""
SHRINK = 0.25
"""Width of a round's box in that of the one before, at least: a posterior from few events may be too narrow."""
SPREADS = 6.0
"""Half the width of a round's box in standard deviations of the posterior before it, at least."""

EDGE = 1e-3
"""Share of a box's width at each end that `logit` leaves out."""


@dataclass(frozen=True)
class Neural(Method):
    """Rounds of simulation with a network each, that learns a factor of the posterior from all events in the round's box.

    The box of the first round is the prior's, later ones are truncated around the posterior of the round before. theta
    is uniform in each, so that events of earlier rounds within the box are drawn as if in this one, and serve again.
    """

    packages: ClassVar = ("sbi",)
    extra: ClassVar = "sbi"

    rounds: int = 1
    """Each with an equal share of the budget; with one, the events know nothing of the observation (amortised)."""
    hidden: int = 64
    """Nodes of a hidden layer."""
    epochs: int = 30
    """Passes over the rows, at most so many; the best one by the held-out rows counts."""
    batch_size: int = 1024
    learning_rate: float = 2e-3
    """Of Adam at the start; it falls to 0 along a cosine."""

    def __post_init__(self) -> None:
        if min(self.rounds, self.hidden, self.epochs, self.batch_size) < 1 or self.learning_rate <= 0:
            raise UsageError(
                f"{self.name} needs rounds, hidden, epochs, batch_size of at least 1 and learning_rate above 0"
            )

    @abstractmethod
    def rows(self, problem: Problem, box: Box, number: int, rng: np.random.Generator) -> tuple[NDArray, NDArray]:
        """theta (n, p), uniform in the box, and what is observed at each (n, k), from at most `number` events."""

    @abstractmethod
    def fitted(self, theta: NDArray, rows: NDArray, problem: Problem, box: Box, rng: np.random.Generator) -> Posterior:
        """The posterior of the whole observation within the box, by a network trained on theta (n, p), rows (n, k)."""

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """As `Method.infer`. Raises BudgetExhausted when the budget is below `min_simulations`."""
        import torch  # noqa: F401 - global_seed seeds what has been imported

        box, trace = problem.prior, []
        theta, rows = np.empty((0, box.dim)), None
        total = max(problem.simulate.remaining, self.min_simulations(box.dim))
        ends = problem.simulate.used + np.linspace(0, total, self.rounds + 1).astype(int)[1:]
        with global_seed(rng):
            for end in ends:
                new, observed = self.rows(problem, box, end - problem.simulate.used, rng)
                inside = box.contains(theta)
                theta = np.concatenate([theta[inside], new])
                rows = observed if rows is None else np.concatenate([rows[inside], observed])
                found = self.fitted(theta.astype(np.float32), rows.astype(np.float32), problem, box, rng)
                trace.append(TracePoint(problem.simulate.used, found.mode, found.std))
                box = _truncated(box, found)
        return Estimate(
            theta=found.mode,
            how="maximum of the posterior, the product of a learned factor for each row",
            spread_of="posterior",
            mean=found.mean,
            std=found.std,
            trace=trace,
        )


def _truncated(box: Box, found: Posterior) -> Box:
    """The box of the next round, within this one."""
    half = np.maximum(SPREADS * found.std, SHRINK * box.width / 2)
    low = np.clip(found.mean - half, box.low, np.array(box.high) - 2 * half)
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
    kept, size = len(theta) - held, min(method.batch_size, len(theta) - held)
    steps = method.epochs * (kept // size)
    optimiser = torch.optim.Adam(network.parameters(), lr=method.learning_rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    best, least = copy.deepcopy(network.state_dict()), np.inf
    for _ in range(method.epochs):
        network.train()
        for chosen in torch.as_tensor(held + rng.permutation(kept)[: kept // size * size]).split(size):
            optimiser.zero_grad()
            loss(theta[chosen], rows[chosen]).backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)  # sbi's default
            optimiser.step()
            schedule.step()
        network.eval()
        with torch.no_grad():
            now = float(loss(theta[:held], rows[:held]))
        if now < least:
            best, least = copy.deepcopy(network.state_dict()), now
    network.load_state_dict(best)


def event_rows(problem: Problem, x: NDArray) -> NDArray[np.float32]:
    """Events (n, d) as a network sees them, (n, k): an image is summed over its cyclic axes, where theta says nothing."""
    if problem.cyclic_axes:
        x = x.reshape(-1, *problem.event_shape).sum(axis=tuple(1 + axis for axis in problem.cyclic_axes))
    return x.reshape(len(x), -1).astype(np.float32)


def logit(theta: "Tensor", box: Box) -> tuple["Tensor", "Tensor"]:
    """theta (n, p) in a box on the whole real line, (n, p), and log |d logit / d theta| (n,) but for a constant."""
    import torch

    unit = (theta - torch.tensor(box.low).float()) / torch.tensor(box.width).float()
    unit = unit.clamp(EDGE, 1 - EDGE)
    return unit.logit(), -(unit.log() + (1 - unit).log()).sum(-1)


def without_edge(box: Box) -> Box:
    """The part of a box in which `logit` is one: beyond it a network would have to extrapolate to infinity."""
    margin = EDGE * box.width
    return Box(tuple(np.array(box.low) + margin), tuple(np.array(box.high) - margin))
