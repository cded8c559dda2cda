"""The preset `avo`: adversarial variational optimization with replayed events, and a polish that simulates nothing.

It keeps what defines AVO (see `avo.py`): a discriminator trained against observed events, a parametric proposal over
theta moved by a score-function gradient of log(1 - d), a simulator that is only called. What differs from the algorithm
as printed, and what each difference is worth, is in docs/methods.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from avobench.methods.avo_paper import TRACE_POINTS, baseline, require_device
from avobench.methods.contract import Estimate, Method, TracePoint
from avobench.methods.inputs import Inputs
from avobench.methods.polish import Fold, Polished, polish
from avobench.methods.problem import Problem
from avobench.methods.proposal import TruncatedGaussian

if TYPE_CHECKING:
    import torch

MAX_WEIGHT = 5.0
"""Cap on the importance weight of a replayed event."""
LOCAL_ROUNDS = 3
"""Rounds in which the local stage simulates, with a polish after each."""


@dataclass(frozen=True)
class Avo(Method):
    """AVO tuned to reach the statistical limit within the budget.

    1. The adversarial stage plays Algorithm 1 with a replay buffer: every iteration simulates a few fresh events, and
       both players learn from recent ones too, with importance weights for the proposal having moved since.
    2. The polish simulates nothing. The last layer of d is trained to its optimum against the replayed events,
       weighted as if they came from the proposal's mean alone, and the mean follows the natural score-function
       gradient, until both stand still.
    3. The local stage spends the rest of the budget around that mean, no further from it than its standard error, and
       polishes again: events far away tell how the answer moves, events nearby what it is.

    There are two discriminators, each trained on one half of the observed and of the simulated events and used on the
    other: a discriminator knows the events that it was trained on too well, and would bias the answer (cross-fitting).

    All settings of the proposal are in its standardised coordinates (see TruncatedGaussian); a pair of values is the
    first and the last of a geometric schedule.
    """

    name = "avo"
    version = "2"
    packages, extra = ("torch",), "avo"
    source = "after G. Louppe, J. Hermans, K. Cranmer, Adversarial Variational Optimization, AISTATS 2019"
    together = True

    iterations: int = 400
    """Of the adversarial stage; its events are spread evenly over them."""
    hidden: tuple[int, ...] = (64, 64, 64)
    """Nodes of the discriminator's hidden layers."""
    discriminator_steps: int = 2
    """k, updates of each discriminator per iteration."""
    batch_size: int = 256
    """Observed events, and as many replayed ones, in an update of the discriminator."""
    replay: int = 20_000
    """The latest events, from which the discriminator's are drawn."""
    proposal_replay: int = 5_000
    """The latest events, over which the proposal's gradient is averaged."""
    r1: float = 1.0
    """lambda, coefficient of the gradient penalty R1 on the probability d."""
    entropy: float = 1e-3
    """Coefficient of the bonus on the logarithm of the proposal's standard deviations."""
    learning_rate: tuple[float, float] = (1e-3, 1e-4)
    """Of Adam, for the discriminator."""
    proposal_learning_rate: tuple[float, float] = (0.1, 0.005)
    """Of Adam, for psi = (mean in units of std, log std)."""
    initial_std: float = 1.0
    """The prior's own. The proposal starts at the prior's mean."""
    min_std: float = 0.03
    max_std: float = 0.7
    """Bounds of the proposal's standard deviations; the upper one comes down from `initial_std`."""
    whiten: bool = True
    """Show the discriminator decorrelated features of equal variance, rather than only standardised ones."""
    symmetric: bool = True
    """Sum an image over its cyclic axes, along which nothing depends on theta, before the discriminator sees it."""
    cross_fit: bool = True
    """Use each discriminator on the events that the other was trained on, rather than on its own."""
    polish: bool = True
    local_share: float = 0.6
    """Of the budget, kept for the local stage; without the polish there is none."""
    device: Literal["cpu", "cuda"] = field(default="cpu", metadata={"identifies": "unless default"})
    """Where the discriminators are; on another device sums are rounded otherwise, so it is another cell there."""

    def __post_init__(self) -> None:
        counts = (self.iterations, self.discriminator_steps, self.batch_size)
        if min(counts) < 1 or not self.hidden or min(self.hidden) < 1:
            raise ValueError("iterations, steps, batch_size and hidden must be at least 1")
        if min(self.replay, self.proposal_replay) < 2:
            raise ValueError("replay and proposal_replay must be at least 2")
        if min(*self.learning_rate, *self.proposal_learning_rate) <= 0:
            raise ValueError("learning rates must be positive")
        if not 0 < self.min_std <= self.max_std <= self.initial_std:
            raise ValueError("the standard deviations need 0 < min_std <= max_std <= initial_std")
        if min(self.r1, self.entropy) < 0:
            raise ValueError("r1 and entropy must not be negative")
        if not 0 <= self.local_share < 1:
            raise ValueError("local_share must be at least 0 and below 1")
        require_device(self.device)

    def min_simulations(self, num_parameters: int) -> int:
        """Ten events of the adversarial stage for each coefficient of the polish's local quadratic."""
        return int(np.ceil(5 * (num_parameters + 1) * (num_parameters + 2) / (1 - self.local_share)))

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        return self.infer_together([problem], [rng])[0]

    def infer_together(self, problems: Sequence[Problem], rngs: Sequence[np.random.Generator]) -> list[Estimate]:
        """See Method. The networks are stacked; each problem keeps its own random stream, proposal and events."""
        import torch

        from avobench.methods.discriminator import mlp
        from avobench.methods.fused_step import FusedStep

        players = [Player(self, problem, rng) for problem, rng in zip(problems, rngs, strict=True)]
        num_inputs, n = players[0].real.shape[1], players[0].num_adversarial
        networks = [mlp(num_inputs, self.hidden, player.rng).to(self.device) for player in players for _ in range(2)]
        step = FusedStep(networks, self.learning_rate[0], self.r1, "probability", "adam")
        real = torch.from_numpy(np.stack([player.real for player in players])).to(self.device)
        synthetic = torch.empty((len(players), n, num_inputs), device=self.device)

        def train_discriminators(start: int, end: int) -> None:
            """On events of either half, even or odd rows, one network each."""
            draws = np.stack([player.draw(half, start, end) for player in players for half in range(2)], axis=2)
            draws[0] += len(real[0]) * np.repeat(np.arange(len(players)), 2)[:, None]
            draws[1] += n * np.repeat(np.arange(len(players)), 2)[:, None]
            rows_real, rows_synthetic = torch.from_numpy(draws).to(self.device)
            for r, s in zip(rows_real, rows_synthetic, strict=True):
                step(real.view(-1, num_inputs)[r], synthetic.view(-1, num_inputs)[s])

        def log_one_minus_d(start: int, end: int) -> NDArray[np.float64]:
            """f of the events from `start` to `end`, each by the other half's network: (problems, events)."""
            halves = synthetic[:, start:end].unflatten(1, (-1, 2)).transpose(1, 2)  # (problems, half, events, inputs)
            used = halves.flip(1) if self.cross_fit else halves
            f = torch.nn.functional.logsigmoid(-step.logits(used.flatten(0, 1))).unflatten(0, (-1, 2))
            f = f.flip(1) if self.cross_fit else f
            return f.transpose(1, 2).flatten(1).cpu().numpy().astype(np.float64)

        ends = np.unique([even(end) for end in np.linspace(0, n, self.iterations + 1)])
        for iteration, (begin, end) in enumerate(pairwise(ends), 1):
            progress = iteration / (len(ends) - 1)
            for player, events in zip(players, synthetic, strict=True):
                events[begin:end] = torch.from_numpy(player.simulate(player.propose(end - begin)))
            step.learning_rate = geometric(self.learning_rate, progress)
            train_discriminators(even(end - self.replay), end)
            start = even(end - self.proposal_replay)
            for player, f in zip(players, log_one_minus_d(start, end), strict=True):
                player.move(f, start, progress)
        pairs = zip(networks[::2], networks[1::2], strict=True)
        return [player.finish(pair, events) for player, pair, events in zip(players, pairs, synthetic, strict=True)]


class Player:
    """What one problem has for itself: its random stream, its proposal, and where its events were simulated."""

    def __init__(self, method: Avo, problem: Problem, rng: np.random.Generator) -> None:
        import torch

        self.method, self.problem, self.rng = method, problem, rng
        self.proposal, p = TruncatedGaussian(problem.prior, problem.support), problem.prior.dim
        self.inputs = Inputs(problem, symmetric=method.symmetric, whiten=method.whiten)
        self.real = self.inputs(problem.x_observed)[: even(len(problem.x_observed))]
        self.psi = np.stack([np.zeros(p), np.full(p, np.log(method.initial_std))])
        self.num_events = even(problem.simulate.remaining)
        self.num_adversarial = even(self.num_events * (1 - method.local_share if method.polish else 1))
        self.u, self.log_q = np.empty((0, p)), np.empty(0)
        self.means = [self.psi[0].copy()]  # of the proposal, after each iteration
        self._move = torch.zeros((2, p), dtype=torch.float64)  # of psi, the mean's in units of std
        self._update = torch.optim.Adam([self._move], betas=(0.9, 0.99))
        self.trace: list[TracePoint] = []
        self._note(self.psi[0], np.exp(self.psi[1]))

    def propose(self, n: int) -> NDArray[np.float64]:
        """Draws from the proposal: (n, p)."""
        return self.proposal.sample(self.psi, n, self.rng)

    def simulate(self, u: NDArray[np.float64]) -> NDArray[np.float32]:
        """Events at u (n, p), as the discriminators see them: (n, k)."""
        self.u = np.concatenate([self.u, u])
        self.log_q = np.append(self.log_q, self.proposal.log_density(self.psi, u).sum(axis=1))
        return self.inputs(self.problem.simulate(self.proposal.to_raw(u)))

    def draw(self, half: int, start: int, end: int) -> NDArray[np.int64]:
        """Rows of observed and of simulated events for the discriminator of that half: (2, steps, batch)."""
        shape, weight = (self.method.discriminator_steps, self.method.batch_size), self._weights(start + half, 2)
        observed = self.rng.integers(len(self.real) // 2, size=shape)
        replayed = self.rng.choice(len(weight), shape, p=weight / weight.sum())
        return np.stack([2 * observed + half, start + 2 * replayed + half])

    def move(self, f: NDArray[np.float64], start: int, progress: float) -> None:
        """One step of the proposal by its score-function gradient over the events since `start`, f (n,) of them."""
        method, proposal, std = self.method, self.proposal, np.exp(self.psi[1])
        weight, score = self._weights(start)[:, None, None], proposal.score(self.psi, self.u[start:])
        weight /= weight.sum()
        gradient = (weight * score * (f[:, None, None] - baseline("optimal", score, f, weight))).sum(axis=0)
        self._update.param_groups[0]["lr"] = geometric(method.proposal_learning_rate, progress)
        self._move.zero_()
        self._move.grad = self._move.new_tensor(np.stack([gradient[0] * std, gradient[1] - method.entropy]))
        self._update.step()
        mean, log_std = self.psi[0] + std * self._move[0].numpy(), self.psi[1] + self._move[1].numpy()
        largest = geometric((method.initial_std, method.max_std), progress)
        self.psi[0] = np.clip(mean, proposal.low, proposal.high)
        self.psi[1] = np.clip(log_std, np.log(method.min_std), np.log(largest))
        self.means.append(self.psi[0].copy())
        if progress * TRACE_POINTS // 1 > len(self.trace) - 1:
            self._note(self.averaged_mean, np.exp(self.psi[1]))

    @property
    def averaged_mean(self) -> NDArray[np.float64]:
        """Of the proposal, over the last quarter of the iterations so far (p,)."""
        return np.mean(self.means[-1 - (len(self.means) - 1) // 4 :], axis=0)

    def finish(self, networks: tuple["torch.nn.Sequential", ...], synthetic: "torch.Tensor") -> Estimate:
        """Polish and local stage, from the events of the adversarial one as the networks saw them."""
        mean, std, how = self.averaged_mean, np.exp(self.psi[1]), "mean of the proposal over the last quarter"
        message = f"{len(self.means) - 1} iterations"
        if self.method.polish:
            folds = []
            for half, network in enumerate(networks):
                other = 1 - half if self.method.cross_fit else half
                x = synthetic.new_tensor(self.real[other::2])
                folds.append(Fold(last_layer(network, x), last_layer(network, synthetic[other::2]), self.u[other::2]))
            answer = polish(folds, mean, std, self.proposal.low, self.proposal.high)
            ends = np.linspace(self.num_adversarial, self.num_events, LOCAL_ROUNDS + 1)[1:]
            for end in map(even, ends if self.method.local_share else ()):
                self._note(answer.mean, std)
                start = len(self.u)
                x = synthetic.new_tensor(self.simulate(self.around(answer, std, end - start)))
                for half, (fold, network) in enumerate(zip(folds, networks, strict=True)):
                    other = 1 - half if self.method.cross_fit else half
                    fold.add(last_layer(network, x[other::2]), self.u[start + other :: 2])
                answer = polish(folds, answer.mean, std, self.proposal.low, self.proposal.high)
            mean, how = answer.mean, "mean of the proposal after the polish"
            state = "converged" if answer.converged else "did not converge"
            error = ", ".join(f"{e:.3g}" for e in answer.error * self.proposal.scale)
            message += f"; the polish {state} in {answer.num_steps} steps, with a standard error of {error}"
        self._note(mean, std)
        last = self.trace[-1]
        return Estimate(last.theta, how, "proposal", last.theta, last.std, trace=self.trace, message=message)

    def around(self, answer: Polished, std: NDArray[np.float64], n: int) -> NDArray[np.float64]:
        """Draws from a Gaussian of the polish's covariance, nowhere wider than std (p,), within the support: (n, p)."""
        variance, axes = np.linalg.eigh(answer.covariance / np.outer(std, std))
        root = std[:, None] * axes * np.sqrt(variance.clip(0, 1))
        u = np.empty((0, len(std)))
        while len(u) < n:
            more = answer.mean + self.rng.standard_normal((n, len(std))) @ root.T
            u = np.concatenate([u, more[((more >= self.proposal.low) & (more <= self.proposal.high)).all(axis=1)]])
        return u[:n]

    def _weights(self, start: int, every: int = 1) -> NDArray[np.float64]:
        """Density of the proposal as it is, over that from which an event was drawn, for every so many since start."""
        log_ratio = self.proposal.log_density(self.psi, self.u[start::every]).sum(axis=1) - self.log_q[start::every]
        return np.exp(np.minimum(log_ratio, np.log(MAX_WEIGHT)))

    def _note(self, mean: NDArray[np.float64], std: NDArray[np.float64]) -> None:
        scale = self.proposal.scale
        self.trace.append(TracePoint(self.problem.simulate.used, self.proposal.to_raw(mean), std * scale))


def last_layer(network: "torch.nn.Sequential", x: "torch.Tensor") -> NDArray[np.float32]:
    """What the last layer sees, the nodes before it and, for the polish, the inputs too: (n, k) -> (n, nodes + k)."""
    import torch

    with torch.no_grad():
        return torch.cat([torch.cat([network[:-2](rows), rows], dim=1) for rows in x.split(8192)]).cpu().numpy()


def even(row: float) -> int:
    """The even row at or before `row`, or 0: even rows are of the first half of the events."""
    return max(0, int(row)) // 2 * 2


def geometric(ends: tuple[float, float], progress: float) -> float:
    """Between the ends at 0 and 1."""
    return ends[0] * (ends[1] / ends[0]) ** progress
