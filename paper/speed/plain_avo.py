"""A plain AVO, the yardstick of `make bench-avo`: as one writes it first with PyTorch, after the authors' public code.

The gradient of log q is autograd's, one draw of theta at a time, with loops over draws and parameters. The algorithm is
that of `AvoPaper(schedule="shared")`: M simulated events serve both updates.
"""

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch.distributions import Normal
from torch.nn import Linear, Module, PReLU, Sequential, Sigmoid


class PlainAvo:
    """A state of the algorithm and its step; `simulate` maps theta (M, p) to x (M, d), in standardised coordinates."""

    def __init__(
        self,
        x_observed: NDArray,
        simulate: Callable[[NDArray], NDArray],
        num_parameters: int,
        hidden: tuple[int, ...],
        batch_size: int,
        rng: np.random.Generator,
        r1: float = 10.0,
        learning_rate: float = 1e-3,
    ) -> None:
        self.mean = torch.zeros(num_parameters, requires_grad=True)
        self.log_std = torch.zeros(num_parameters, requires_grad=True)
        self.discriminator = _network(x_observed.shape[1], hidden)
        self.update_d = torch.optim.RMSprop(self.discriminator.parameters(), lr=learning_rate)
        self.update_q = torch.optim.RMSprop([self.mean, self.log_std], lr=learning_rate)
        self.x_observed = torch.as_tensor(x_observed, dtype=torch.float32)
        self.simulate, self.batch_size, self.r1, self.rng = simulate, batch_size, r1, rng

    def step(self) -> None:
        """One update of the discriminator and one of the proposal, from M simulated events."""
        theta = self._proposal().sample((self.batch_size,))
        x = torch.as_tensor(self.simulate(theta.numpy()), dtype=torch.float32)
        self._update_discriminator(x)
        self._update_proposal(theta, x)

    def _proposal(self) -> Normal:
        return Normal(self.mean, self.log_std.exp())

    def _update_discriminator(self, x: torch.Tensor) -> None:
        rows = torch.from_numpy(self.rng.integers(len(self.x_observed), size=self.batch_size))
        real = self.x_observed[rows].requires_grad_()
        d_real, d_synthetic = self.discriminator(real), self.discriminator(x)
        cross_entropy = torch.nn.BCELoss()
        loss = cross_entropy(d_real, torch.ones_like(d_real))
        loss = loss + cross_entropy(d_synthetic, torch.zeros_like(d_synthetic))
        (gradient,) = torch.autograd.grad(d_real.sum(), real, create_graph=True)
        loss = loss / 2 + self.r1 * gradient.pow(2).sum(dim=1).mean()
        self.update_d.zero_grad()
        loss.backward()
        self.update_d.step()

    def _update_proposal(self, theta: torch.Tensor, x: torch.Tensor) -> None:
        psi = [self.mean, self.log_std]
        log_q = self._proposal().log_prob(theta).sum(dim=1)
        scores = [torch.autograd.grad(one, psi, retain_graph=True) for one in log_q]
        with torch.no_grad():
            f = (1 - self.discriminator(x)).log()
            above, below = ([torch.zeros_like(p) for p in psi] for _ in range(2))
            for score, value in zip(scores, f, strict=True):
                for i, s in enumerate(score):
                    above[i] += s.pow(2) * value
                    below[i] += s.pow(2)
            for i, p in enumerate(psi):
                p.grad = torch.zeros_like(p)
                for score, value in zip(scores, f, strict=True):
                    p.grad += score[i] * (value - above[i] / below[i]) / self.batch_size
        self.update_q.step()


def _network(num_features: int, hidden: tuple[int, ...]) -> Module:
    widths = (num_features, *hidden)
    layers = [layer for pair in zip(widths, hidden, strict=False) for layer in (Linear(*pair), PReLU())]
    return Sequential(*layers, Linear(widths[-1], 1), Sigmoid())
