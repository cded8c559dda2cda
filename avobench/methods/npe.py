"""Neural posterior estimation with sbi on a summary of parts of the observation, in one round or in several (TSNPE)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.neural import Neural, logit, train
from avobench.methods.problem import Problem
from avobench.methods.product_posterior import LogFactors
from avobench.tasks import Box

MIN_SETS = 40
"""The least number of simulated observations of a round: with fewer a network knows nothing."""


@dataclass(frozen=True)
class Npe(Neural):
    """NPE on the task's summary: the posterior of theta given the summary of `events_per_set` events.

    The budget does not hold one simulated observation as large as the observed one, so the network learns from small
    ones, and the observation is split into parts as small. Each part has a posterior; the product of their ratios to
    the prior, times the prior, is the posterior of the whole, since parts are independent. Network: sbi's
    `posterior_nn`, of theta on the whole real line by a logit, so that nothing leaks out of the box.
    """

    name: ClassVar[str] = "npe"
    source: ClassVar[str] = "Greenberg, Nonnenmacher, Macke, ICML 2019; sbi, JOSS 5 (2020) 2505"

    first_rows: ClassVar[int] = 4

    model: str = "mdn"
    """The density estimator by its name in sbi, e.g. mdn, maf, nsf."""
    events_per_set: int = 128
    """Events of a simulated observation, and of a part of the observed one."""
    batch_size: int = 64
    learning_rate: float = 1e-3

    def min_simulations(self, num_parameters: int) -> int:
        return MIN_SETS * self.rounds * self.events_per_set

    def simulated(self, problem: Problem, box: Box, number: int, rng: np.random.Generator) -> tuple[NDArray, NDArray]:
        size = self._size(problem)
        theta = box.sample(number // size, rng)
        return theta, np.stack([problem.summary(problem.simulate.repeat(one, size)[0]) for one in theta])

    def observed(self, problem: Problem, rng: np.random.Generator) -> NDArray[np.float32]:
        parts = np.array_split(problem.x_observed, len(problem.x_observed) // self._size(problem))
        return np.stack([problem.summary(part) for part in parts]).astype(np.float32)

    def learned(self, theta: NDArray, rows: NDArray, box: Box, rng: np.random.Generator) -> LogFactors:
        import torch
        from sbi.neural_nets import posterior_nn

        varies = torch.as_tensor(rows.std(axis=0) > 0)  # an empty bin cannot be standardised
        free, inputs = logit(torch.as_tensor(theta), box)[0], torch.as_tensor(rows)[:, varies]
        network = posterior_nn(self.model, hidden_features=self.hidden)(free, inputs)
        train(network, lambda theta, s: network.loss(theta, s).mean(), free.numpy(), inputs.numpy(), self, rng)

        def log_factors(theta: torch.Tensor, summaries: torch.Tensor) -> torch.Tensor:
            free, log_slope = logit(theta[None], box)
            return network.log_prob(free.expand(1, len(summaries), -1), summaries[:, varies])[0] + log_slope

        return log_factors

    def _size(self, problem: Problem) -> int:
        return min(self.events_per_set, len(problem.x_observed))


@dataclass(frozen=True)
class Tsnpe(Npe):
    """Truncated sequential NPE: `npe` in rounds, each in a box around the posterior of the round before."""

    name: ClassVar[str] = "tsnpe"
    source: ClassVar[str] = "Deistler, Goncalves, Macke, NeurIPS 2022; sbi, JOSS 5 (2020) 2505"

    rounds: int = 5
