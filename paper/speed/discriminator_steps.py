"""Other ways to make FusedStep's update, which PyTorch differentiates: the yardsticks of `make bench-avo`.

Each is made from T networks of one shape and called with observed and simulated events, (T, n, d) and (T, m, d). Its
result is that of FusedStep to rounding. Nothing else in this package uses them.
"""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.func import functional_call, grad, stack_module_state, vmap
from torch.nn import Sequential

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


class VmapStep:
    """The networks stacked by `torch.func`: one loss, differentiated by `grad` and mapped over them by `vmap`.

    The parameters are copies, in `parameters` by name with a first axis of T; the networks stay as they are.
    """

    def __init__(self, networks: Sequence[Sequential], learning_rate: float, r1: float, implementation: str) -> None:
        self.network, self.r1 = networks[0], r1
        self.parameters, _ = stack_module_state(list(networks))
        self.optimiser = adam(list(self.parameters.values()), learning_rate, implementation)
        self.gradients = vmap(grad(self.loss))

    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        gradients = self.gradients(self.parameters, real, synthetic)
        for name, parameter in self.parameters.items():
            parameter.grad = gradients[name]
        self.optimiser.step()

    def loss(self, parameters: dict[str, Tensor], real: Tensor, synthetic: Tensor) -> Tensor:
        """Of one network: real (n, d), synthetic (m, d) -> ()."""

        def d_and_logit(x: Tensor) -> tuple[Tensor, Tensor]:
            logit = functional_call(self.network, parameters, (x,))
            return torch.sigmoid(logit).sum(), logit

        if not self.r1:
            return cross_entropy(d_and_logit(real)[1], d_and_logit(synthetic)[1])
        gradient, logit_real = grad(d_and_logit, has_aux=True)(real)
        penalty = gradient.square().sum(dim=1).mean()
        return cross_entropy(logit_real, d_and_logit(synthetic)[1]) + self.r1 * penalty
