"""The preset `avo`: adversarial variational optimization with replayed events, and a polish that simulates nothing.

It keeps what defines AVO (see `avo.py`): a discriminator trained against observed events, a parametric proposal over
theta moved by a score-function gradient of log(1 - d), a simulator that is only called. What differs from the algorithm
as printed, and what each difference is worth, is in docs/methods.md.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from avobench.bench.problem import Problem
from avobench.methods.avo import TRACE_POINTS, baseline
from avobench.methods.base import Estimate, Method, TracePoint
from avobench.methods.inputs import Inputs
from avobench.methods.polish import Fold, polish
from avobench.methods.proposal import TruncatedGaussian

if TYPE_CHECKING:
    import torch

MAX_WEIGHT = 5.0
"""Cap on the importance weight of a replayed event."""


@dataclass(frozen=True)
class Avo(Method):
    """AVO tuned to reach the statistical limit within the budget.

    1. The adversarial stage plays Algorithm 1 with a replay buffer: every iteration simulates a few fresh events, and
       both players learn from recent ones too, with importance weights for the proposal having moved since.
    2. The polish simulates nothing. The last layer of d is trained to its optimum against the replayed events,
       weighted as if they came from the proposal's mean alone, and the mean follows the natural score-function
       gradient, until both stand still.

    There are two discriminators, each trained on one half of the observed and of the simulated events and used on the
    other: a discriminator knows the events that it was trained on too well, and would bias the answer (cross-fitting).

    All settings of the proposal are in its standardised coordinates (see TruncatedGaussian); a pair of values is the
    first and the last of a geometric schedule.
    """

    name = "avo"
    packages, extra = ("torch",), "avo"
    source = "after G. Louppe, J. Hermans, K. Cranmer, Adversarial Variational Optimization, AISTATS 2019"

    iterations: int = 400
    """Of the adversarial stage; the budget is spread evenly over them."""
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
    polish: bool = True

    def __post_init__(self) -> None:
        counts = (self.iterations, self.discriminator_steps, self.batch_size, self.replay, self.proposal_replay)
        if min(counts) < 1 or not self.hidden or min(self.hidden) < 1:
            raise ValueError("iterations, steps, batch_size, replay, proposal_replay and hidden must be at least 1")
        if min(*self.learning_rate, *self.proposal_learning_rate) <= 0:
            raise ValueError("learning rates must be positive")
        if not 0 < self.min_std <= self.max_std <= self.initial_std:
            raise ValueError("the standard deviations need 0 < min_std <= max_std <= initial_std")
        if min(self.r1, self.entropy) < 0:
            raise ValueError("r1 and entropy must not be negative")

    def min_simulations(self, num_parameters: int) -> int:
        """Ten events for each coefficient of the polish's local quadratic."""
        return 10 * (num_parameters + 1) * (num_parameters + 2) // 2

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        import torch

        from avobench.methods.discriminator import log_one_minus_d, mlp, penalised_cross_entropy

        proposal, shape = TruncatedGaussian(problem.prior, problem.support), (2, problem.prior.dim)
        inputs = Inputs(problem, symmetric=self.symmetric, whiten=self.whiten)
        real = torch.from_numpy(inputs(problem.x_observed)).tensor_split(2)
        networks = [mlp(real[0].shape[1], self.hidden, rng) for _ in range(2)]
        updates_d = [torch.optim.Adam(network.parameters(), betas=(0.5, 0.99), fused=True) for network in networks]
        psi = np.stack([np.zeros(shape[1]), np.full(shape[1], np.log(self.initial_std))])
        move = torch.zeros(shape, dtype=torch.float64)  # of psi, the mean's in units of std
        update_q = torch.optim.Adam([move], betas=(0.9, 0.99))

        n = problem.simulate.remaining
        ends = np.linspace(0, n, min(self.iterations, n) + 1).astype(int)
        u, log_q, synthetic = np.empty((n, shape[1])), np.empty(n), torch.empty((n, real[0].shape[1]))
        means = np.empty((len(ends), shape[1]))  # of the proposal, after each iteration
        means[0] = psi[0]

        def simulate(fresh: slice) -> None:
            u[fresh] = proposal.sample(psi, fresh.stop - fresh.start, rng)
            log_q[fresh] = proposal.log_density(psi, u[fresh]).sum(axis=1)
            synthetic[fresh] = torch.from_numpy(inputs(problem.simulate(proposal.to_raw(u[fresh]))))

        def weights(replayed: slice) -> NDArray[np.float64]:
            """Density of the proposal as it is, over that from which an event was drawn; normalised."""
            log_ratio = proposal.log_density(psi, u[replayed]).sum(axis=1) - log_q[replayed]
            weight = np.exp(np.minimum(log_ratio, np.log(MAX_WEIGHT)))
            return weight / weight.sum()

        def train_discriminator(half: int, start: int, end: int) -> None:
            replayed, draws = slice(start + half, end, 2), (self.discriminator_steps, self.batch_size)
            weight = weights(replayed)
            rows_real, rows_synthetic = (
                rng.integers(len(real[half]), size=draws),
                rng.choice(len(weight), draws, p=weight),
            )
            for r, s in zip(rows_real, rows_synthetic, strict=True):
                updates_d[half].zero_grad()
                x = real[half][r], synthetic[replayed][s]
                penalised_cross_entropy(networks[half], *x, self.r1, "probability").backward()
                updates_d[half].step()

        def move_proposal(start: int, end: int, largest_std: float) -> None:
            replayed = slice(start, end)
            weight, score = weights(replayed)[:, None, None], proposal.score(psi, u[replayed])
            f = np.empty(len(score))
            for half in range(2):
                f[half::2] = log_one_minus_d(networks[1 - half], synthetic[start + half : end : 2])
            gradient = (weight * score * (f[:, None, None] - baseline("optimal", score, f, weight))).sum(axis=0)
            std = np.exp(psi[1])
            move.zero_()
            move.grad = torch.from_numpy(np.stack([gradient[0] * std, gradient[1] - self.entropy]))
            update_q.step()
            psi[0] = np.clip(psi[0] + std * move[0].numpy(), proposal.low, proposal.high)
            psi[1] = np.clip(psi[1] + move[1].numpy(), np.log(self.min_std), np.log(largest_std))

        trace = [TracePoint(problem.simulate.used, proposal.to_raw(psi[0]), np.exp(psi[1]) * proposal.scale)]
        num_iterations = len(ends) - 1
        for iteration in range(1, num_iterations + 1):
            progress, end = iteration / num_iterations, ends[iteration]
            update_q.param_groups[0]["lr"] = geometric(self.proposal_learning_rate, progress)
            simulate(slice(ends[iteration - 1], end))
            for half, update_d in enumerate(updates_d):
                update_d.param_groups[0]["lr"] = geometric(self.learning_rate, progress)
                train_discriminator(half, even(end - self.replay), end)
            move_proposal(even(end - self.proposal_replay), end, geometric((self.initial_std, self.max_std), progress))
            means[iteration] = psi[0]
            mean, std = means[iteration - iteration // 4 : iteration + 1].mean(axis=0), np.exp(psi[1])
            if iteration * TRACE_POINTS // num_iterations > (iteration - 1) * TRACE_POINTS // num_iterations:
                trace.append(TracePoint(problem.simulate.used, proposal.to_raw(mean), std * proposal.scale))

        how, message = "mean of the proposal over the last quarter", f"{num_iterations} iterations"
        if self.polish:
            folds = [
                Fold(last_layer(network, x_real), last_layer(network, synthetic[other::2]), u[other::2])
                for network, x_real, other in zip(networks, real[::-1], (1, 0), strict=True)
            ]
            end = polish(folds, mean, std, proposal.low, proposal.high)
            mean, how = end.mean, "mean of the proposal after the polish"
            state = "converged" if end.converged else "did not converge"
            error = ", ".join(f"{e:.3g}" for e in end.error * proposal.scale)
            message += f"; the polish {state} in {end.num_steps} steps, with a standard error of {error}"
            trace.append(TracePoint(problem.simulate.used, proposal.to_raw(mean), std * proposal.scale))
        return Estimate(
            theta=proposal.to_raw(mean),
            how=how,
            spread_of="proposal",
            mean=proposal.to_raw(mean),
            std=std * proposal.scale,
            trace=trace,
            message=message,
        )


def last_layer(network: "torch.nn.Sequential", x: "torch.Tensor") -> NDArray[np.float32]:
    """What the last layer sees, the nodes before it and, for the polish, the inputs too: (n, k) -> (n, nodes + k)."""
    import torch

    with torch.no_grad():
        return torch.cat([torch.cat([network[:-2](rows), rows], dim=1) for rows in x.split(8192)]).numpy()


def even(start: int) -> int:
    """The even row at or before `start`, or 0: even rows are of the first half of the simulated events."""
    return max(0, start) // 2 * 2


def geometric(ends: tuple[float, float], progress: float) -> float:
    """Between the ends at 0 and 1."""
    return ends[0] * (ends[1] / ends[0]) ** progress
