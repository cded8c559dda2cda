"""One update of AVO's discriminators without autograd: the same numbers to rounding, in less time.

With z_l = W_l h_{l-1} + b_l and h_l = s_l z_l, where s_l is 1 for z_l > 0 and PReLU's slope otherwise, let t be the
logit and d = d(t) the probability, of which R1 takes the input gradient. Per observed event that gradient G follows

    e_L = d'(t) w,   u_l = s_l e_l,   e_{l-1} = W_l^T u_l,   G = e_0,

and the penalty's own derivative runs back up it with a_0 = 2 r1 G / n: the derivative in u_l is W_l a_{l-1}, and a_l is
s_l times that. Events and chain then share one product a layer, the gradient in W_l is the sum of
zbar_l h_{l-1}^T + u_l a_{l-1}^T, whose rows stand in common buffers here.

Several networks of one shape are updated together: every tensor has a first axis of T networks, and a product of
matrices is one of T pairs of them.

Why it is not left to autograd: the records of `avo` were made so. A rounding grows over the 800 updates of a run until
other events are simulated. On a processor where the first three records of weinberg come out again to the last bit,
autograd on the stacked networks moved them by 0.011, 0.013 and 0.0002 of the prior's width, up to 0.12 standard errors;
those of poisson and carl moved by 2e-6 to 2e-4, up to 1.2 standard errors.
An update of both networks, with 256 observed and as many simulated events, takes 3.4 ms by hand and 6.6 to 7.9 ms by
autograd, so a run is 3 s shorter.
"""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import Sequential

DECAY = 0.5
"""Adam's decay rate of the mean gradient: less than the default, as is usual where two networks play against each other
(Radford, Metz, Chintala 2016)."""
DECAY_SQUARE = 0.99
"""Adam's decay rate of the mean square, which remembers about a hundred of the some 800 steps of a run."""
EPS = 1e-8
"""Adam's smallest denominator, PyTorch's default."""
BLOCK = 1 << 15
"""Parameters updated at a time: the arrays of them take half a megabyte, which stays in the processor's cache."""


class Layer:
    """A linear layer p -> q of T networks, PReLU's slopes after it unless it is the last, and the buffers of a step.

    Rows of a buffer are n observed and m simulated events and, in `x` and `z_bar`, n more for the chain of R1. What is
    used often is a view made once: of `x` the inputs `x_events` and the a_{l-1} of the penalty, `a`; of `z_bar` the
    derivatives in z, `z_bar_events`, and the chain's `u`.
    """

    def __init__(self, tensors: list[Tensor], gradients: list[Tensor], n: int, m: int, r1: float) -> None:
        self.weight, self.bias = tensors[0], tensors[1][:, None]
        self.weight_t = self.weight.mT
        self.weight_grad, self.bias_grad = gradients[:2]
        t, q, p = self.weight.shape

        def empty(rows: int, columns: int) -> Tensor:
            return self.weight.new_empty(t, rows, columns)

        rows = n + m + (n if r1 else 0)
        self.x, self.x_bar, self.e = empty(rows, p), empty(n + m, p), empty(n, p)
        self.x_events, self.a = self.x[:, : n + m], self.x[:, n + m :]
        self.x_bar_flat, self.e_flat = self.x_bar.view(t, 1, -1), self.e.view(t, -1, 1)
        self.z_bar = empty(rows, q)
        self.z_bar_t, self.z_bar_events, self.u = self.z_bar.mT, self.z_bar[:, : n + m], self.z_bar[:, n + m :]
        if len(tensors) == 3:
            self.slope, self.slope_grad = tensors[2][..., None], gradients[2][..., None]
            self.z, self.s, self.negative, self.u_bar = (empty(k, q) for k in (n + m, n + m, n + m, n))
            self.s_real, self.negative_real = self.s[:, :n], self.negative[:, :n]
            self.z_flat, self.u_bar_flat = self.z.view(t, -1, 1), self.u_bar.view(t, 1, -1)


class FusedStep:
    """Updates networks of one shape, made of Linear and PReLU layers with one logit, in place.

    A step is what the gradient of `cross_entropy` + r1 `input_gradient_penalty` (methods/discriminator.py) and Adam do
    for each network; only sums are in another order. All buffers are kept, so nothing is allocated: fresh pages of
    memory cost as much as a product of small matrices. The networks' parameters become parts of one vector, in which
    those of one layer follow each other.
    """

    def __init__(self, networks: Sequence[Sequential], learning_rate: float, r1: float) -> None:
        self.learning_rate, self.r1, self.num_steps = learning_rate, r1, 0
        each = list(zip(*(network.parameters() for network in networks), strict=True))
        self.flat = torch.cat([torch.stack(same).detach().flatten() for same in each])
        self.gradient, mean, square = (torch.zeros_like(self.flat) for _ in range(3))
        self.tensors, self.gradients = [], []
        for whole, views in ((self.flat, self.tensors), (self.gradient, self.gradients)):
            parts = whole.split([len(same) * same[0].numel() for same in each])
            views += [part.view(len(same), *same[0].shape) for part, same in zip(parts, each, strict=True)]
        for same, stacked in zip(each, self.tensors, strict=True):
            for parameter, part in zip(same, stacked, strict=True):
                parameter.data = part
        scratch = torch.empty_like(self.flat[:BLOCK])
        blocks = [whole.split(BLOCK) for whole in (self.flat, self.gradient, mean, square)]
        self.blocks = [(p, g, m, v, scratch[: len(p)]) for p, g, m, v in zip(*blocks, strict=True)]
        self.sizes = (0, 0)

    @torch.no_grad()
    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        """One update from observed and simulated events as the networks see them: (T, n, d) and (T, m, d)."""
        if self.sizes != (real.shape[1], synthetic.shape[1]):
            self._prepare(real.shape[1], synthetic.shape[1])
        d = self._events_up(real, synthetic)
        self._cross_entropy(d)
        if self.r1:
            self._penalty(d[:, : real.shape[1]])
        else:
            for layer in self.layers:
                layer.slope_grad.zero_()
        self._events_down()
        self._adam()

    def _events_up(self, real: Tensor, synthetic: Tensor) -> Tensor:
        """Pass events up the networks, to d of the observed and the simulated ones (T, n + m, 1)."""
        layers, last = self.layers, self.last
        torch.cat([real, synthetic], dim=1, out=layers[0].x_events)
        for layer, above in zip(layers, [*layers[1:], last], strict=True):
            torch.baddbmm(layer.bias, layer.x_events, layer.weight_t, out=layer.z)
            torch.le(layer.z, 0, out=layer.negative)
            torch.mul(layer.negative, layer.slope - 1, out=layer.s).add_(1)
            torch.mul(layer.z, layer.s, out=above.x_events)
        return torch.sigmoid(torch.baddbmm(last.bias, last.x_events, last.weight_t))

    def _cross_entropy(self, d: Tensor) -> None:
        """Set the derivative of U_d in the logits."""
        (n, m), t_bar = self.sizes, self.last.z_bar_events
        torch.div(d, 2 * m, out=t_bar)
        torch.div(d[:, :n] - 1, 2 * n, out=t_bar[:, :n])

    def _penalty(self, d: Tensor) -> None:
        """Add the derivative of R1: from d of the observed events (T, n, 1) down the chain to G, and up again."""
        (n, _), layers, last = self.sizes, self.layers, self.last
        first = d * (1 - d)  # derivatives of d in the logit
        second = first * (1 - 2 * d)
        torch.mul(first, last.weight, out=last.e)
        for layer, above in zip(reversed(layers), [last, *reversed(layers[1:])], strict=True):
            torch.mul(above.e, layer.s_real, out=layer.u)
            torch.bmm(layer.u, layer.weight, out=layer.e)
        torch.mul(layers[0].e, 2 * self.r1 / n, out=layers[0].a)
        for layer, above in zip(layers, [*layers[1:], last], strict=True):
            torch.bmm(layer.a, layer.weight_t, out=layer.u_bar)
            torch.mul(layer.u_bar, layer.s_real, out=above.a)
            layer.u_bar.mul_(layer.negative_real)
            torch.bmm(layer.u_bar_flat, above.e_flat, out=layer.slope_grad)
        last.z_bar_events[:, :n] += torch.bmm(last.a, last.weight_t) * second
        last.u.copy_(first)

    def _events_down(self) -> None:
        """Pass the derivatives in the logits down to all parameters."""
        layers, last = self.layers, self.last
        t_bar = last.z_bar_events
        torch.bmm(last.z_bar_t, last.x, out=last.weight_grad)
        torch.sum(t_bar, dim=1, out=last.bias_grad)
        torch.mul(t_bar, last.weight, out=last.x_bar)
        for layer, above in zip(reversed(layers), [last, *reversed(layers[1:])], strict=True):
            layer.z.mul_(layer.negative)
            layer.slope_grad.baddbmm_(above.x_bar_flat, layer.z_flat)
            torch.mul(above.x_bar, layer.s, out=layer.z_bar_events)
            if layer is not layers[0]:
                torch.bmm(layer.z_bar_events, layer.weight, out=layer.x_bar)
            torch.bmm(layer.z_bar_t, layer.x, out=layer.weight_grad)
            torch.sum(layer.z_bar_events, dim=1, out=layer.bias_grad)

    def _adam(self) -> None:
        """Take a step of Adam (Kingma, Ba 2015), with its corrections for having begun at zero."""
        self.num_steps += 1
        rate = self.learning_rate / (1 - DECAY**self.num_steps)
        correction = 1.0 - DECAY_SQUARE**self.num_steps
        for p, g, m, v, root in self.blocks:
            v.mul_(DECAY_SQUARE).addcmul_(g, g, value=1 - DECAY_SQUARE)
            torch.sqrt(v, out=root).div_(correction**0.5).add_(EPS)
            p.addcdiv_(m.lerp_(g, 1 - DECAY), root, value=-rate)

    @torch.no_grad()
    def logits(self, x: Tensor) -> Tensor:
        """The logits of events as the networks see them: (T, n, d) -> (T, n)."""
        *layers, last = self._layers(self.tensors)
        for weight, bias, slope in layers:
            x = torch.baddbmm(bias[:, None], x, weight.mT)
            x.addcmul_(x.clamp(max=0), slope[..., None] - 1)
        return torch.baddbmm(last[1][:, None], x, last[0].mT)[..., 0]

    @staticmethod
    def _layers(tensors: list[Tensor]) -> list[list[Tensor]]:
        """Weight, bias and slope of every layer; the last has no slope."""
        return [tensors[i : i + 3] for i in range(0, len(tensors), 3)]

    def _prepare(self, n: int, m: int) -> None:
        """Make the buffers for n observed and m simulated events."""
        self.sizes = n, m
        pairs = zip(self._layers(self.tensors), self._layers(self.gradients), strict=True)
        *self.layers, self.last = [Layer(*pair, n, m, self.r1) for pair in pairs]
