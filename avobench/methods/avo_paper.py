"""Adversarial variational optimization (Louppe, Hermans, Cranmer, AISTATS 2019), Algorithm 1.

A discriminator d(x; phi) learns to tell observed from simulated events, while the proposal q(theta | psi) moves to
where the simulated events fool it. The simulator is only called, never differentiated: the proposal's gradient is a
score-function estimate.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.methods.contract import Estimate, Method, TracePoint
from avobench.methods.problem import Problem
from avobench.methods.proposal import TruncatedGaussian

TRACE_POINTS = 100


@dataclass(frozen=True)
class AvoPaper(Method):
    """Algorithm 1 with the hyper-parameters as printed; where the print and the mathematics differ, both are settings.

    Defaults are the paper's values and the corrected formulas. The proposal lives in standardised coordinates (see
    TruncatedGaussian); all settings that concern it are in these coordinates.
    """

    name = "avo-paper"
    packages, extra = ("torch",), "avo"
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
    """Of RMSProp, for the discriminator."""
    proposal_learning_rate: float = 1e-3
    """Of RMSProp, for psi = (mean, log std)."""
    initial_mean: float = 0.0
    initial_std: float = 1.0
    hidden: tuple[int, ...] | None = None
    """Nodes of the discriminator's hidden layers; the task's own network where None."""
    device: Literal["cpu", "cuda"] = field(default="cpu", metadata={"identifies": "unless default"})
    """Where the discriminator is; on another device sums are rounded otherwise, so it is another cell there."""
    step: Literal["autograd", "fused"] = field(default="autograd", metadata={"identifies": "unless default"})
    """How the discriminator is updated: by PyTorch, or by hand in less time, with sums in another order (FusedStep)."""

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

    def min_simulations(self, num_parameters: int) -> int:
        return self.events_per_iteration

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        import torch

        from avobench.methods.discriminator import Discriminator
        from avobench.methods.fused_step import FusedStep

        proposal = TruncatedGaussian(problem.prior, problem.support)
        shape = (2, problem.prior.dim)
        psi = torch.tensor(np.broadcast_to([[self.initial_mean], [np.log(self.initial_std)]], shape).copy())
        discriminator = Discriminator(problem, self.hidden or problem.discriminator.hidden, rng, self.device)
        if self.step == "fused":
            fused = FusedStep([discriminator.network], self.learning_rate, self.r1, self.r1_of)
        else:
            update_d = torch.optim.RMSprop(discriminator.parameters(), lr=self.learning_rate)
        update_q = torch.optim.RMSprop([psi], lr=self.proposal_learning_rate)

        def simulate(n: int) -> tuple[NDArray[np.float64], NDArray]:
            u = proposal.sample(psi.numpy(), n, rng)
            return u, problem.simulate(proposal.to_raw(u))

        def train_discriminator(x_synthetic: NDArray) -> None:
            rows = rng.integers(len(problem.x_observed), size=len(x_synthetic))
            x_real = problem.x_observed[rows]
            if self.step == "fused":
                fused(discriminator.inputs(x_real)[None], discriminator.inputs(x_synthetic)[None])
                return
            update_d.zero_grad()
            discriminator.loss(x_real, x_synthetic, self.r1, self.r1_of).backward()
            update_d.step()

        def trace_point() -> TracePoint:
            std = proposal.mean_and_std(psi.numpy())[1] * proposal.scale
            return TracePoint(problem.simulate.used, proposal.to_raw(proposal.mode(psi.numpy())), std)

        # With less than one iteration left the simulator refuses it, rather than an estimate being made of nothing.
        num_iterations = max(1, problem.simulate.remaining // self.events_per_iteration)
        trace = [trace_point()]
        for iteration in range(1, num_iterations + 1):
            if self.schedule == "shared":
                u, x = simulate(self.batch_size)
                for _ in range(self.discriminator_steps):
                    train_discriminator(x)
            else:
                for _ in range(self.discriminator_steps):
                    train_discriminator(simulate(self.batch_size // 2)[1])
                u, x = simulate(self.batch_size)
            gradient = self._proposal_gradient(proposal, psi.numpy(), u, discriminator.log_one_minus_d(x))
            psi.grad = torch.from_numpy(gradient)
            update_q.step()
            if iteration * TRACE_POINTS // num_iterations > (iteration - 1) * TRACE_POINTS // num_iterations:
                trace.append(trace_point())

        mean, std = proposal.mean_and_std(psi.numpy())
        return Estimate(
            theta=proposal.to_raw(proposal.mode(psi.numpy())),
            how="mode of the final proposal",
            spread_of="proposal",
            mean=proposal.to_raw(mean),
            std=std * proposal.scale,
            trace=trace,
            message=f"{num_iterations} iterations; the {problem.simulate.remaining} events left are less than one more",
        )

    def _proposal_gradient(
        self, proposal: TruncatedGaussian, psi: NDArray[np.float64], u: NDArray[np.float64], f: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Gradient of U_g + gamma H in psi (Equations 11 to 13 and 16): u (M, p), f = log(1 - d) (M,) -> (2, p)."""
        score = proposal.score(psi, u)
        gradient = (score * (f[:, None, None] - baseline(self.baseline, score, f))).mean(axis=0)
        if self.entropy:
            if self.entropy_gradient == "closed_form":
                gradient += self.entropy * proposal.entropy_gradient(psi)
            else:
                log_q = proposal.log_density(psi, u).sum(axis=1)[:, None, None]
                gradient += self.entropy * (-np.exp(log_q) * (1 + log_q) * score).mean(axis=0)
        return gradient


def require_device(device: str) -> None:
    """Raise ValueError unless PyTorch finds the device, "cpu" or "cuda", on this machine."""
    if device == "cuda":
        import torch

        if not torch.cuda.is_available():
            raise ValueError("PyTorch finds no CUDA device on this machine; leave device at cpu")


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
