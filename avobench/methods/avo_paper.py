"""Adversarial variational optimization (Louppe, Hermans, Cranmer, AISTATS 2019), Algorithm 1.

A discriminator d(x; phi) learns to tell observed from simulated events, while the proposal q(theta | psi) moves to
where the simulated events fool it. The simulator is only called, never differentiated: the proposal's gradient is a
score-function estimate.

The functions come first, in the order of the algorithm, then the settings. A number in a comment at the end of a line
is that of the line of Algorithm 1, as printed.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from avobench.methods.contract import LATER, Estimate, Method, TracePoint
from avobench.methods.device import require_device
from avobench.methods.problem import Problem
from avobench.methods.proposal import TruncatedGaussian

if TYPE_CHECKING:
    import torch

    from avobench.methods.discriminator import Discriminator

TRACE_POINTS = 100
"""Estimates noted on the way: enough for a smooth curve of error against events, and few beside the estimate's cost."""


@dataclass
class State:
    """What an iteration moves, in place: psi of the proposal and phi of the discriminator, each with its RMSProp."""

    psi: "torch.Tensor"
    """Mean and log std (2, p), in the proposal's standardised coordinates."""
    discriminator: "Discriminator"
    rmsprop_psi: "torch.optim.RMSprop"
    rmsprop_phi: "torch.optim.RMSprop"


def algorithm_1(
    problem: Problem, q: TruncatedGaussian, settings: "AvoPaper", rng: np.random.Generator
) -> Iterator[State]:
    """The state before the first iteration and after each, as many as the budget allows."""
    state = initial_state(problem, settings, rng)  # 1
    yield state
    for _ in range(settings.num_iterations(problem)):  # 2
        iterate(state, problem, q, settings, rng)  # 3 to 13
        yield state  # 14


def initial_state(problem: Problem, settings: "AvoPaper", rng: np.random.Generator) -> State:
    """A proposal with the moments of the prior, unless the settings say otherwise, and an untrained discriminator."""
    import torch

    from avobench.methods.discriminator import Discriminator

    start = [[settings.initial_mean], [np.log(settings.initial_std)]]
    psi = torch.tensor(np.broadcast_to(start, (2, problem.prior.dim)).copy())
    d = Discriminator(problem, settings.hidden or problem.discriminator.hidden, rng, settings.device)
    rmsprop_psi = torch.optim.RMSprop([psi], lr=settings.proposal_learning_rate)
    return State(psi, d, rmsprop_psi, torch.optim.RMSprop(d.parameters(), lr=settings.learning_rate))


def iterate(
    state: State, problem: Problem, q: TruncatedGaussian, settings: "AvoPaper", rng: np.random.Generator
) -> None:
    """One iteration: k updates of the discriminator, then one of the proposal."""
    psi, m, shared = state.psi.numpy(), settings.batch_size, settings.schedule == "shared"

    def simulate(n: int) -> tuple[NDArray[np.float64], NDArray]:
        u = q.sample(psi, n, rng)
        return u, problem.simulate(q.to_raw(u))

    if shared:  # one simulated batch takes the place of those of lines 5 and 10
        u, x = simulate(m)
    for _ in range(settings.discriminator_steps):  # 3
        x_synthetic = x if shared else simulate(m // 2)[1]  # 5; before line 4, which changes nothing but the draws
        x_real = problem.x_observed[rng.integers(len(problem.x_observed), size=len(x_synthetic))]  # 4
        update_discriminator(state, x_real, x_synthetic, settings)  # 6 to 8
    if not shared:
        u, x = simulate(m)  # 10
    f = state.discriminator.log_one_minus_d(x)
    gradient = score_gradient(q.score(psi, u), f, settings.baseline)  # 11
    if settings.entropy:
        gradient += settings.entropy * entropy_gradient(q, psi, u, settings.entropy_gradient)  # 12
    state.psi.grad = state.psi.new_tensor(gradient)
    state.rmsprop_psi.step()  # 13


def update_discriminator(state: State, x_real: NDArray, x_synthetic: NDArray, settings: "AvoPaper") -> None:
    """One step of phi down the gradient of U_d + lambda R1."""
    from avobench.methods.discriminator import cross_entropy, input_gradient_penalty

    d = state.discriminator
    real, synthetic = d.inputs(x_real).requires_grad_(settings.r1 > 0), d.inputs(x_synthetic)
    logit_real, logit_synthetic = d.network(real), d.network(synthetic)
    loss = cross_entropy(logit_real, logit_synthetic)  # 6
    if settings.r1 > 0:
        loss = loss + settings.r1 * input_gradient_penalty(logit_real, real, settings.r1_of)  # 7
    state.rmsprop_phi.zero_grad()
    loss.backward()
    state.rmsprop_phi.step()  # 8


def score_gradient(score: NDArray[np.float64], f: NDArray[np.float64], kind: str) -> NDArray[np.float64]:
    """Gradient of U_g in psi (Equations 11 and 12): score (M, 2, p), f = log(1 - d) (M,) -> (2, p)."""
    return (score * (f[:, None, None] - baseline(kind, score, f))).mean(axis=0)


def baseline(
    kind: str, score: NDArray[np.float64], f: NDArray[np.float64], weight: NDArray[np.float64] | float = 1.0
) -> NDArray[np.float64] | float:
    """The constant per component of psi that is subtracted from f: score (M, 2, p), f (M,), weight (M, 1, 1) -> (2, p).

    The variance of the estimate is least at E[s^2 f] / E[s^2]; Equation 13 prints f^2 (`as_printed`).
    """
    if kind == "none":
        return 0.0
    values = f if kind == "optimal" else f**2
    square = weight * score**2
    return (square * values[:, None, None]).mean(axis=0) / square.mean(axis=0)


def entropy_gradient(
    q: TruncatedGaussian, psi: NDArray[np.float64], u: NDArray[np.float64], kind: str
) -> NDArray[np.float64]:
    """Gradient of the proposal's entropy H in psi (Equation 16): psi (2, p), draws u (M, p) from q -> (2, p)."""
    if kind == "closed_form":
        return q.entropy_gradient(psi)
    log_q = q.log_density(psi, u).sum(axis=1)[:, None, None]
    return (-np.exp(log_q) * (1 + log_q) * q.score(psi, u)).mean(axis=0)


@dataclass(frozen=True)
class AvoPaper(Method):
    """Algorithm 1 with the hyper-parameters as printed; where the print and the mathematics differ, both are settings.

    Defaults are the paper's values and the corrected formulas. The proposal lives in standardised coordinates (see
    TruncatedGaussian); all settings that concern it are in these coordinates.
    """

    name = "avo-paper"
    packages, extra = ("torch",), "avo"
    by_moments = True
    source = "G. Louppe, J. Hermans, K. Cranmer, Adversarial Variational Optimization, AISTATS 2019, Algorithm 1"

    discriminator_steps: int = 1
    """k, updates of the discriminator per iteration."""
    batch_size: int = 32
    """M, events per mini-batch; even."""
    r1: float = 10.0
    """lambda, coefficient of the gradient penalty R1."""
    r1_of: Literal["probability", "logit"] = "probability"
    """What R1 takes the input gradient of: d, as the paper prints, or its logit, as Mescheder et al. 2018 do."""
    entropy: float = 0.0
    """gamma, coefficient of the proposal's entropy; positive values make the proposal tighter."""
    entropy_gradient: Literal["closed_form", "as_printed"] = "closed_form"
    """`as_printed` averages the gradient of -q log q over draws from q, which weights q twice."""
    baseline: Literal["optimal", "as_printed", "none"] = "optimal"
    """E[s^2 f] / E[s^2] per component of the score s, or with f^2 in place of f as in Equation 13, or no baseline."""
    schedule: Literal["as_printed", "shared"] = "as_printed"
    """`as_printed` simulates M/2 events for each update of d and M more for that of q; `shared` simulates M events
    that serve both, beside M observed ones."""
    learning_rate: float = 1e-3
    """Learning rate of RMSProp for the discriminator."""
    proposal_learning_rate: float = 1e-3
    """Learning rate of RMSProp for psi = (mean, log std)."""
    initial_mean: float = 0.0
    initial_std: float = 1.0
    hidden: tuple[int, ...] | None = None
    """Nodes of the discriminator's hidden layers; the task's own network where None."""
    device: Literal["cpu", "cuda"] = field(default="cpu", metadata=LATER)
    """Where the discriminator is; on another device sums are rounded otherwise, so it is another cell there."""

    def __post_init__(self) -> None:
        if self.batch_size < 2 or self.batch_size % 2:
            raise ValueError(f"batch_size must be even and at least 2, got {self.batch_size}")
        if self.discriminator_steps < 1:
            raise ValueError(f"discriminator_steps must be at least 1, got {self.discriminator_steps}")
        if min(self.learning_rate, self.proposal_learning_rate, self.initial_std) <= 0:
            raise ValueError("learning_rate, proposal_learning_rate and initial_std must be positive")
        if self.r1 < 0:
            raise ValueError(f"r1 must not be negative, got {self.r1}")
        if self.hidden is not None and (not self.hidden or min(self.hidden) < 1):
            raise ValueError(f"hidden must be a list of positive layer sizes, got {list(self.hidden)}")
        require_device(self.device)

    @property
    def events_per_iteration(self) -> int:
        if self.schedule == "shared":
            return self.batch_size
        return self.discriminator_steps * self.batch_size // 2 + self.batch_size

    def num_iterations(self, problem: Problem) -> int:
        """The iterations that the remaining budget allows, one at least, which the simulator may refuse."""
        return max(1, problem.simulate.remaining // self.events_per_iteration)

    def min_simulations(self, num_parameters: int) -> int:
        return self.events_per_iteration

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """See Method. The algorithm is `algorithm_1`; this notes how it goes and reads the estimate off psi."""
        q, num_iterations, trace = TruncatedGaussian(problem.prior, problem.support), self.num_iterations(problem), []
        for iteration, state in enumerate(algorithm_1(problem, q, self, rng)):
            psi = state.psi.numpy()
            if iteration * TRACE_POINTS // num_iterations > (iteration - 1) * TRACE_POINTS // num_iterations:
                std = q.mean_and_std(psi)[1] * q.scale
                trace.append(TracePoint(problem.simulate.used, q.to_raw(q.mode(psi)), std))
        mean, std = q.mean_and_std(psi)
        return Estimate(
            theta=q.to_raw(q.mode(psi)),
            how="mode of the final proposal",
            spread_of="proposal",
            mean=q.to_raw(mean),
            std=std * q.scale,
            covariance=np.diag((std * q.scale) ** 2),
            trace=trace,
            message=f"{num_iterations} iterations; the {problem.simulate.remaining} events left are less than one more",
        )


@dataclass(frozen=True)
class AvoPlain(AvoPaper):
    """Algorithm 1 without replay and polish, with settings that were chosen on targets other than the benchmark's."""

    name: ClassVar[str] = "avo-plain"

    batch_size: int = 256
    r1: float = 0.1
    r1_of: Literal["probability", "logit"] = "logit"
    schedule: Literal["as_printed", "shared"] = "shared"
    proposal_learning_rate: float = 5e-3
    hidden: tuple[int, ...] | None = (64, 64)
