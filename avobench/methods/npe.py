"""Neural posterior estimation with sbi on a summary of parts of the observation, in one round or in several (TSNPE)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.neural import Neural, logit, train, without_edge
from avobench.methods.problem import Problem
from avobench.methods.product_posterior import Posterior, posterior
from avobench.tasks import Box

MIN_SETS = 40
"""Simulated observations of the smallest round."""
FIRST_PARTS = 4
"""Parts of the observation from which the search of the posterior begins: each is worth many events."""


@dataclass(frozen=True)
class Npe(Neural):
    """NPE on the task's summary: the posterior of theta given the summary of `events_per_set` events.

    The budget does not hold one simulated observation as large as the observed one, so the network learns from small ones,
    and the observation is split into parts as small. Each part has a posterior; the product of their ratios to the prior,
    times the prior, is the posterior of the whole, since parts are independent. Network: sbi's `posterior_nn`, of theta on the
    whole real line by a logit, so that nothing leaks out of the box.
    """

    name: ClassVar[str] = "npe"
    source: ClassVar[str] = "Greenberg, Nonnenmacher, Macke, ICML 2019; sbi, JOSS 5 (2020) 2505"

    model: str = "mdn"
    """Density estimator by its name in sbi, e.g. mdn, maf, nsf."""
    events_per_set: int = 128
    """Events of a simulated observation, and of a part of the observed one."""
    epochs: int = 150
    batch_size: int = 64
    learning_rate: float = 1e-3

    def min_simulations(self, num_parameters: int) -> int:
        """Forty simulated observations a round."""
        return MIN_SETS * self.rounds * self.events_per_set

    def rows(self, problem: Problem, box: Box, number: int, rng: np.random.Generator) -> tuple[NDArray, NDArray]:
        size = self._size(problem)
        theta = box.sample(number // size, rng)
        return theta, np.stack([problem.summary(problem.simulate.repeat(one, size)[0]) for one in theta])

    def fitted(self, theta: NDArray, rows: NDArray, problem: Problem, box: Box, rng: np.random.Generator) -> Posterior:
        import torch
        from sbi.neural_nets import posterior_nn

        parts = np.array_split(problem.x_observed, len(problem.x_observed) // self._size(problem))
        observed = np.stack([problem.summary(part) for part in parts]).astype(np.float32)
        varies = rows.std(axis=0) > 0  # an empty bin cannot be standardised
        rows, observed = rows[:, varies], observed[:, varies]
        free = logit(torch.as_tensor(theta), box)[0]
        build = posterior_nn(self.model, hidden_features=self.hidden, z_score_x="independent")
        network = build(free, torch.as_tensor(rows))
        train(network, lambda theta, s: network.loss(theta, s).mean(), free.numpy(), rows, self, rng)

        def log_factors(theta: torch.Tensor, summaries: torch.Tensor) -> torch.Tensor:
            free, log_slope = logit(theta, box)
            return network.log_prob(free[None], summaries)[0] + log_slope

        return posterior(log_factors, observed, without_edge(box), rng, FIRST_PARTS)

    def _size(self, problem: Problem) -> int:
        return min(self.events_per_set, len(problem.x_observed))


@dataclass(frozen=True)
class Tsnpe(Npe):
    """Truncated sequential NPE: `npe` in rounds, theta uniform in a box truncated around the posterior of the round before."""

    name: ClassVar[str] = "tsnpe"
    source: ClassVar[str] = "Deistler, Goncalves, Macke, NeurIPS 2022; sbi, JOSS 5 (2020) 2505"

    rounds: int = 4
