"""Neural likelihood estimation with sbi: the density of single events, its logarithm summed over the observation."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.neural import Neural, train
from avobench.methods.problem import Problem
from avobench.methods.product_posterior import LogFactors
from avobench.tasks import Box


@dataclass(frozen=True)
class Nle(Neural):
    """NLE of single events: a conditional density p(x | theta), trained by maximum likelihood.

    Whole numbers, counts or hits, are made continuous by uniform noise within half a unit, observed ones too: the
    density of what results is that of the counts, and nothing of theta is lost. Network: sbi's `likelihood_nn`.
    """

    name: ClassVar[str] = "nle"
    source: ClassVar[str] = "Papamakarios, Sterratt, Murray, AISTATS 2019; sbi, JOSS 5 (2020) 2505"

    model: str = "mdn"
    """The density estimator by its name in sbi, e.g. mdn, maf, nsf. A mixture takes a tenth of a flow's time."""

    def rows(self, problem: Problem, x: NDArray, rng: np.random.Generator) -> NDArray[np.float32]:
        rows = super().rows(problem, x, rng)
        if not np.array_equal(rows, np.rint(rows)):
            return rows
        return rows + rng.uniform(-0.5, 0.5, rows.shape).astype(np.float32)

    def learned(self, theta: NDArray, rows: NDArray, box: Box, rng: np.random.Generator) -> LogFactors:
        import torch
        from sbi.neural_nets import likelihood_nn

        build = likelihood_nn(self.model, hidden_features=self.hidden)
        network = build(torch.as_tensor(theta), torch.as_tensor(rows))
        train(network, lambda theta, x: network.loss(x, theta).mean(), theta, rows, self, rng)
        # The events are draws of one theta, which its network then sees once.
        return lambda theta, x: network.log_prob(x[:, None], theta[None])[:, 0]
