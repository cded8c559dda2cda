"""A statistic of an event, learnt from simulated events: one small network per parameter. Needs PyTorch.

With u drawn around some place and x simulated at u, the network T_i that minimises E[(T_i(x) - u_i)^2] is E[u_i | x],
which near that place is u's mean plus its variance times the score of x. The mean of T over the observed events then
says all that they say about theta, so matching it by simulation (see `polish.py`) is efficient: Jiang, Wu, Zheng, Wong,
Statistica Sinica 27 (2017) 1595; Cranmer, Brehmer, Louppe, PNAS 117 (2020) 30055. Where the networks are not perfect
the match is less precise, and still not biased.

Why one network a parameter: they share nothing, so that a parameter of which an event says little is learnt at its own
pace. In one network with ten outputs the noise of those that say much drowns it: after as many steps, tails were not
found at all (docs/methods.md).
"""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import leaky_relu

NODES = 32
"""Nodes in either hidden layer of a network, which has to tell one parameter only."""
SLOPE = 0.1
"""Slope of the activation below zero, so that no node dies."""
BATCH_SIZE = 1024
"""Events of an update: half as many left one tail in three unfound in as many steps."""
LEARNING_RATE = 8e-3
"""Learning rate of Adam at the beginning of a lesson; it falls linearly to zero."""
MOST_PASSES = 50
"""Most passes over the events in one lesson: with few events, more would learn them by heart."""
ROWS_AT_A_TIME = 8192
"""Events of which the statistic is computed at once, so that the values between the layers stay small."""


class Statistic:
    """T(x) (p,) in two versions, one for each half of the events: each is learnt on one half and used on the other."""

    def __init__(self, num_inputs: int, num_parameters: int, rng: np.random.Generator, device: str = "cpu") -> None:
        generator = torch.Generator().manual_seed(int(rng.integers(2**63)))

        def uniform(inputs: int, *shape: int) -> Tensor:
            drawn = torch.rand((2, *shape), generator=generator) * 2 - 1
            return (drawn / np.sqrt(inputs)).to(device).requires_grad_()

        p, width = num_parameters, num_parameters * NODES
        self.first = [uniform(num_inputs, num_inputs, width), uniform(num_inputs, 1, width)]
        self.second = [uniform(NODES, p, NODES, NODES), uniform(NODES, p, 1, NODES)]
        self.last = [uniform(NODES, p, NODES, 1), uniform(NODES, p, 1, 1)]
        self.p, self.device, self.rng = p, device, rng
        self.adam = torch.optim.Adam([*self.first, *self.second, *self.last], lr=LEARNING_RATE)

    def __call__(self, x: Tensor) -> Tensor:
        """(2, n, k) -> (2, n, p), each half by its own version."""
        n = x.shape[1]
        h = leaky_relu(torch.baddbmm(self.first[1], x, self.first[0]), SLOPE)
        h = h.view(2, n, self.p, NODES).transpose(1, 2).flatten(0, 1)  # (2 p, n, nodes)
        h = leaky_relu(torch.baddbmm(self.second[1].flatten(0, 1), h, self.second[0].flatten(0, 1)), SLOPE)
        t = torch.baddbmm(self.last[1].flatten(0, 1), h, self.last[0].flatten(0, 1))
        return t.view(2, self.p, n).transpose(1, 2)

    def learn(self, x: NDArray[np.float32], u: NDArray[np.float64], num_steps: int) -> None:
        """Train on, by `num_steps` at most, with all events simulated so far: x (n, k) at u (n, p), n even."""
        num_steps = min(num_steps, -(-MOST_PASSES * len(x) // (2 * BATCH_SIZE)))
        spread = u.std(axis=0)
        target = torch.from_numpy(((u - u.mean(axis=0)) / np.where(spread > 0, spread, 1)).astype(np.float32))
        events, target = torch.from_numpy(x).to(self.device), target.to(self.device)
        for step in range(num_steps):
            rows = torch.from_numpy(self.rng.integers(len(x) // 2, size=(2, BATCH_SIZE))) * 2
            rows[1] += 1
            rows = rows.to(self.device)
            loss = (self(events[rows]) - target[rows]).square().mean() * self.p
            self.adam.param_groups[0]["lr"] = LEARNING_RATE * (1 - step / num_steps)
            self.adam.zero_grad()
            loss.backward()
            self.adam.step()

    def of(self, x: NDArray[np.float32]) -> Sequence[NDArray[np.float32]]:
        """The statistic of each half of x (n, k), n even, as learnt on the other half: two arrays of (n / 2, p)."""
        halves = torch.from_numpy(np.stack([x[1::2], x[::2]])).to(self.device)
        with torch.no_grad():
            parts = [self(rows).cpu().numpy() for rows in halves.split(ROWS_AT_A_TIME, dim=1)]
        return np.concatenate(parts, axis=1)
