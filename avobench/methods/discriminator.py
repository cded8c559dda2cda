"""The discriminator d(x; phi) of AVO: its network, and what it minimises. Needs PyTorch as it loads."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import Flatten, Linear, Module, PReLU, Sequential
from torch.nn.functional import logsigmoid, softplus

from avobench.methods.inputs import origin
from avobench.methods.problem import Problem


def mlp(num_inputs: int, hidden: tuple[int, ...], rng: np.random.Generator) -> Sequential:
    """A multilayer perceptron with PReLU activations: (n, num_inputs) -> one logit each (n,)."""
    widths = (num_inputs, *hidden)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**63)))
        layers = [layer for pair in zip(widths, hidden, strict=False) for layer in (Linear(*pair), PReLU())]
        return Sequential(*layers, Linear(widths[-1], 1), Flatten(0))


def cross_entropy(logit_real: torch.Tensor, logit_synthetic: torch.Tensor) -> torch.Tensor:
    """U_d, the mean of -y log d - (1 - y) log(1 - d) over as much of either class (Equation 6): (n,), (m,) -> ()."""
    return (softplus(-logit_real).mean() + softplus(logit_synthetic).mean()) / 2


def input_gradient_penalty(logit_real: torch.Tensor, real: torch.Tensor, r1_of: str) -> torch.Tensor:
    """R1, the mean squared gradient in the real inputs (n, k) of d, or of its logit (n,) with `r1_of="logit"`.

    In x, not in phi as Algorithm 1 prints it: Mescheder, Geiger, Nowozin 2018, Equation 9. The result can be
    differentiated in phi.
    """
    output = torch.sigmoid(logit_real) if r1_of == "probability" else logit_real
    (gradient,) = torch.autograd.grad(output.sum(), real, create_graph=True)
    return gradient.square().sum(dim=1).mean()


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
        self.origin = np.zeros(d)
        if problem.discriminator.standardise:
            self.origin = origin(problem.x_observed)
            x = problem.x_observed - self.origin if self.origin.any() else problem.x_observed
            self.shift = x.mean(axis=0).astype(np.float32)
            std = x.std(axis=0).astype(np.float32)
            self.scale = np.where(std > 0, std, np.float32(1))
        self.network = mlp(d, hidden, rng).to(device)

    def inputs(self, x: NDArray) -> torch.Tensor:
        """x as the network sees it: (n, d) of any dtype -> float32 (n, d)."""
        x = x - self.origin if self.origin.any() else x
        return torch.from_numpy((x.astype(np.float32) - self.shift) / self.scale).to(self.device)

    def log_one_minus_d(self, x: NDArray) -> NDArray[np.float64]:
        """f(x) = log(1 - d(x)), what the proposal minimises: (n, d) -> (n,)."""
        with torch.no_grad():
            return logsigmoid(-self.network(self.inputs(x))).cpu().numpy().astype(np.float64)
