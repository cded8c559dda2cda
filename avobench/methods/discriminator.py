"""The discriminator d(x; phi) of AVO. The only module here that needs PyTorch as it loads."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import Flatten, Linear, Module, PReLU, Sequential
from torch.nn.functional import logsigmoid, softplus

from avobench.methods.problem import Problem


def mlp(num_inputs: int, hidden: tuple[int, ...], rng: np.random.Generator) -> Sequential:
    """A multilayer perceptron with PReLU activations: (n, num_inputs) -> one logit each (n,)."""
    widths = (num_inputs, *hidden)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**63)))
        layers = [layer for pair in zip(widths, hidden, strict=False) for layer in (Linear(*pair), PReLU())]
        return Sequential(*layers, Linear(widths[-1], 1), Flatten(0))


def penalised_cross_entropy(
    network: Module, real: torch.Tensor, synthetic: torch.Tensor, r1: float, r1_of: str
) -> torch.Tensor:
    """U_d, plus r1 times the mean squared gradient of d, or of its logit, in the real inputs: a scalar.

    Paper, Equation 6 and Algorithm 1; the gradient is in x, not in phi: Mescheder, Geiger, Nowozin 2018, Eq. 9.
    """
    real = real.requires_grad_(r1 > 0)
    logit_real, logit_synthetic = network(real), network(synthetic)
    loss = (softplus(-logit_real).mean() + softplus(logit_synthetic).mean()) / 2
    if r1 > 0:
        output = torch.sigmoid(logit_real) if r1_of == "probability" else logit_real
        (gradient,) = torch.autograd.grad(output.sum(), real, create_graph=True)
        loss = loss + r1 * gradient.square().sum(dim=1).mean()
    return loss


@torch.no_grad()
def log_one_minus_d(network: Module, inputs: torch.Tensor) -> NDArray[np.float64]:
    """f = log(1 - d), what the proposal minimises: inputs (n, k) -> (n,)."""
    return logsigmoid(-network(inputs)).cpu().numpy().astype(np.float64)


class Discriminator(Module):
    """An MLP with PReLU activations and one logit, on float32 inputs standardised by the observed events.

    Its parameters are drawn on the CPU and then moved to `device`, so they do not depend on it.
    """

    def __init__(
        self, problem: Problem, hidden: tuple[int, ...], rng: np.random.Generator, device: str = "cpu"
    ) -> None:
        super().__init__()
        self.device = device
        d = problem.x_observed.shape[1]
        self.shift, self.scale = np.zeros(d, np.float32), np.ones(d, np.float32)
        if problem.discriminator.standardise:
            self.shift = problem.x_observed.mean(axis=0).astype(np.float32)
            std = problem.x_observed.std(axis=0).astype(np.float32)
            self.scale = np.where(std > 0, std, np.float32(1))
        self.network = mlp(d, hidden, rng).to(device)

    def inputs(self, x: NDArray) -> torch.Tensor:
        """x as the network sees it: (n, d) of any dtype -> float32 (n, d)."""
        return torch.from_numpy((x.astype(np.float32) - self.shift) / self.scale).to(self.device)

    def loss(self, x_real: NDArray, x_synthetic: NDArray, r1: float, r1_of: str) -> torch.Tensor:
        """See `penalised_cross_entropy`; x of any dtype (n, d)."""
        return penalised_cross_entropy(self.network, self.inputs(x_real), self.inputs(x_synthetic), r1, r1_of)

    def log_one_minus_d(self, x: NDArray) -> NDArray[np.float64]:
        """f(x) = log(1 - d(x)), what the proposal minimises: (n, d) -> (n,)."""
        return log_one_minus_d(self.network, self.inputs(x))
