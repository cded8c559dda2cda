"""Neural ratio estimation with sbi: a classifier's log-ratios of single events, summed over the observation."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.methods.neural import Neural, train
from avobench.methods.product_posterior import LogFactors
from avobench.tasks import Box


@dataclass(frozen=True)
class Nre(Neural):
    """NRE-B of single events: which of `atoms` parameters made this event?

    One of them did, the others are those of other events. The classifier learns log p(x | theta) up to a term that does
    not depend on theta, so the sum over the observed events is the log-likelihood. Network: sbi's residual one,
    `classifier_nn("resnet")`.
    """

    name: ClassVar[str] = "nre"
    source: ClassVar[str] = (
        "Durkan, Murray, Papamakarios, ICML 2020; Hermans, Begy, Louppe, ICML 2020; sbi, JOSS 5 (2020) 2505"
    )

    atoms: int = 4
    """Parameters to choose from, for each event."""

    def learned(self, theta: NDArray, rows: NDArray, box: Box, rng: np.random.Generator) -> LogFactors:
        import torch
        from sbi.neural_nets import classifier_nn

        network = classifier_nn("resnet", hidden_features=self.hidden)(torch.as_tensor(theta), torch.as_tensor(rows))

        def loss(theta: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
            shifts = range(min(self.atoms, len(theta)))  # rows are in random order, so a shift pairs at random
            theta = torch.cat([theta.roll(shift, 0) for shift in shifts])
            logits = network(theta, x.repeat(len(shifts), 1)).reshape(len(shifts), -1)
            return (logits.logsumexp(0) - logits[0]).mean()

        train(network, loss, theta, rows, self, rng)
        return lambda theta, x: network(theta.expand(len(x), -1), x)
