"""Other ways to make FusedStep's update, which PyTorch differentiates: the yardsticks of `make bench-avo`.

Each is made from T networks and called with observed and simulated events, (T, n, d) and (T, m, d).
"""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import Sequential
from torch.nn.functional import prelu

from avobench.methods.discriminator import cross_entropy, input_gradient_penalty
from avobench.methods.fused_step import DECAY, DECAY_SQUARE, EPS


def adam(parameters: Sequence[Tensor], learning_rate: float, implementation: str) -> torch.optim.Adam:
    """PyTorch's, as FusedStep has it; the implementation is "foreach" or "fused"."""
    return torch.optim.Adam(
        parameters, lr=learning_rate, betas=(DECAY, DECAY_SQUARE), eps=EPS, **{implementation: True}
    )


class AutogradStep:
    """One loss for each network, by autograd, and one optimiser for all."""

    def __init__(self, networks: Sequence[Sequential], learning_rate: float, r1: float, implementation: str) -> None:
        self.networks, self.r1 = networks, r1
        self.optimiser = adam([p for network in networks for p in network.parameters()], learning_rate, implementation)

    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        self.optimiser.zero_grad()
        for network, x_real, x_synthetic in zip(self.networks, real, synthetic, strict=True):
            x_real = x_real.detach().requires_grad_(self.r1 > 0)
            logit_real = network(x_real)
            loss = cross_entropy(logit_real, network(x_synthetic))
            if self.r1:
                loss = loss + self.r1 * input_gradient_penalty(logit_real, x_real, "probability")
            loss.backward()
        self.optimiser.step()


class StackedStep:
    """Copies of the networks, stacked along a first axis of T, with one loss that autograd differentiates."""

    def __init__(self, networks: Sequence[Sequential], learning_rate: float, r1: float, implementation: str) -> None:
        self.r1 = r1
        each = zip(*(network.parameters() for network in networks), strict=True)
        self.parameters = [torch.stack(same).detach().requires_grad_() for same in each]
        self.optimiser = adam(self.parameters, learning_rate, implementation)

    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        real = real.detach().requires_grad_(self.r1 > 0)
        logit_real = self.logits(real)
        loss = len(real) * cross_entropy(logit_real, self.logits(synthetic))  # from the mean over networks to the sum
        if self.r1:
            (gradient,) = torch.autograd.grad(torch.sigmoid(logit_real).sum(), real, create_graph=True)
            loss = loss + self.r1 * gradient.square().sum() / real.shape[1]
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()

    def logits(self, x: Tensor) -> Tensor:
        """The logit of each network for its events: (T, n, d) -> (T, n)."""
        *hidden, weight, bias = self.parameters
        for w, b, slope in zip(hidden[::3], hidden[1::3], hidden[2::3], strict=True):
            x = prelu(torch.baddbmm(b[:, None], x, w.mT)[None], slope[:, 0])[0]  # slopes belong to the second axis
        return torch.baddbmm(bias[:, None], x, weight.mT)[..., 0]
