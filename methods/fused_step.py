"""One update of AVO's discriminator without autograd: the same numbers to rounding, in less time.

With z_l = W_l h_{l-1} + b_l and h_l = s_l z_l, where s_l is 1 for z_l > 0 and PReLU's slope otherwise, let t be the
logit and y what R1 takes the input gradient of, d or t. Per observed event that gradient G follows the chain

    e_L = y'(t) w,   u_l = s_l e_l,   e_{l-1} = W_l^T u_l,   G = e_0,

and the penalty's own derivative runs back up it with a_0 = 2 r1 G / n: the derivative in u_l is W_l a_{l-1}, and a_l is
s_l times that. Events and chain then share one product a layer, the gradient in W_l is the sum of
zbar_l h_{l-1}^T + u_l a_{l-1}^T, whose rows stand in common buffers here.
"""

import torch
from torch import Tensor
from torch.nn import Linear, PReLU, Sequential
from torch.nn.utils import parameters_to_vector, vector_to_parameters

ALPHA, EPS = 0.99, 1e-8
"""Of RMSProp, PyTorch's defaults."""
BLOCK = 1 << 15
"""Parameters updated at a time: the four arrays of them take half a megabyte, which stays in the processor's cache."""


class Layer:
    """A linear layer p -> q of the network, PReLU's slope after it unless it is the last, and the buffers of a step.

    Rows of a buffer are n observed and m simulated events and, in `x` and `z_bar`, n more for the chain of R1. What is
    used often is a view made once: of `x` the inputs `x_events` and the a_{l-1} of the penalty, `a`; of `z_bar` the
    derivatives in z, `z_bar_events`, and the chain's `u`.
    """

    def __init__(
        self, linear: Linear, slope: Tensor | None, grad: dict[Tensor, Tensor], n: int, m: int, r1: float
    ) -> None:
        def empty(rows: int, columns: int) -> Tensor:
            return linear.weight.detach().new_empty(rows, columns)

        q, p = linear.weight.shape
        rows = n + m + (n if r1 else 0)
        self.weight, self.weight_t, self.bias = linear.weight, linear.weight.T, linear.bias
        self.weight_grad, self.bias_grad = grad[linear.weight], grad[linear.bias]
        self.x, self.x_bar, self.e = empty(rows, p), empty(n + m, p), empty(n, p)
        self.x_events, self.a = self.x[: n + m], self.x[n + m :]
        self.x_bar_flat, self.e_flat = self.x_bar.view(-1), self.e.view(-1)
        self.z_bar = empty(rows, q)
        self.z_bar_t, self.z_bar_events, self.u = self.z_bar.T, self.z_bar[: n + m], self.z_bar[n + m :]
        if slope is not None:
            self.slope, self.slope_grad = slope, grad[slope][0]
            self.z, self.s, self.negative, self.u_bar = (empty(k, q) for k in (n + m, n + m, n + m, n))
            self.s_real, self.negative_real = self.s[:n], self.negative[:n]
            self.z_flat, self.u_bar_flat = self.z.view(-1), self.u_bar.view(-1)


class FusedStep:
    """Updates a network of Linear and PReLU layers with one logit, in place.

    A step is what `Discriminator.loss`, `backward` and `torch.optim.RMSprop` do together; only sums are in another
    order. All buffers are kept, so nothing is allocated: fresh pages of memory cost as much as a product of small
    matrices. The network's parameters become parts of one vector.
    """

    def __init__(self, network: Sequential, learning_rate: float, r1: float, r1_of: str) -> None:
        self.network, self.learning_rate, self.r1, self.r1_of = network, learning_rate, r1, r1_of
        parameters = list(network.parameters())
        self.flat = parameters_to_vector(parameters).detach()
        vector_to_parameters(self.flat, parameters)
        self.gradient, self.square = torch.zeros_like(self.flat), torch.zeros_like(self.flat)
        scratch = torch.empty_like(self.flat[:BLOCK])
        blocks = [whole.split(BLOCK) for whole in (self.flat, self.gradient, self.square)]
        self.blocks = [(p, g, v, scratch[: len(p)]) for p, g, v in zip(*blocks, strict=True)]
        parts = self.gradient.split([p.numel() for p in parameters])
        self.grad = {p: part.view_as(p) for p, part in zip(parameters, parts, strict=True)}
        self.sizes = (0, 0)

    @torch.no_grad()
    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        """One update from observed and simulated events as the network sees them: float32 (n, d) and (m, d)."""
        n, m = len(real), len(synthetic)
        if self.sizes != (n, m):
            self._prepare(n, m)
        layers, last = self.layers, self.last

        # up: the events
        torch.cat([real, synthetic], out=layers[0].x_events)
        for layer, above in zip(layers, [*layers[1:], last], strict=True):
            torch.addmm(layer.bias, layer.x_events, layer.weight_t, out=layer.z)
            torch.le(layer.z, 0, out=layer.negative)
            torch.mul(layer.negative, layer.slope - 1, out=layer.s).add_(1)
            torch.mul(layer.z, layer.s, out=above.x_events)
        t = torch.mv(last.x_events, last.weight[0]).add_(last.bias)
        d = torch.sigmoid(t)
        t_bar = d / (2 * m)  # derivative of the loss in the logits
        t_bar[:n] = (d[:n] - 1) / (2 * n)

        if self.r1:
            # down the chain to G, and up again
            first, second = torch.ones_like(d[:n]), torch.zeros_like(d[:n])  # derivatives of y in t
            if self.r1_of == "probability":
                first = d[:n] * (1 - d[:n])
                second = first * (1 - 2 * d[:n])
            torch.outer(first, last.weight[0], out=last.e)
            for layer, above in zip(reversed(layers), [last, *reversed(layers[1:])], strict=True):
                torch.mul(above.e, layer.s_real, out=layer.u)
                torch.mm(layer.u, layer.weight, out=layer.e)
            torch.mul(layers[0].e, 2 * self.r1 / n, out=layers[0].a)
            for layer, above in zip(layers, [*layers[1:], last], strict=True):
                torch.mm(layer.a, layer.weight_t, out=layer.u_bar)
                torch.mul(layer.u_bar, layer.s_real, out=above.a)
                layer.u_bar.mul_(layer.negative_real)
                torch.dot(layer.u_bar_flat, above.e_flat, out=layer.slope_grad)
            t_bar[:n] += torch.mv(last.a, last.weight[0]) * second
            last.u[:, 0] = first
        else:
            for layer in layers:
                layer.slope_grad.zero_()

        # down: the events
        last.z_bar_events[:, 0] = t_bar
        torch.mm(last.z_bar_t, last.x, out=last.weight_grad)
        torch.sum(t_bar, dim=0, keepdim=True, out=last.bias_grad)
        torch.outer(t_bar, last.weight[0], out=last.x_bar)
        for layer, above in zip(reversed(layers), [last, *reversed(layers[1:])], strict=True):
            layer.z.mul_(layer.negative)
            layer.slope_grad.add_(torch.dot(above.x_bar_flat, layer.z_flat))
            torch.mul(above.x_bar, layer.s, out=layer.z_bar_events)
            if layer is not layers[0]:
                torch.mm(layer.z_bar_events, layer.weight, out=layer.x_bar)
            torch.mm(layer.z_bar_t, layer.x, out=layer.weight_grad)
            torch.sum(layer.z_bar_events, dim=0, out=layer.bias_grad)

        for p, g, v, root in self.blocks:  # RMSProp
            v.mul_(ALPHA).addcmul_(g, g, value=1 - ALPHA)
            torch.sqrt(v, out=root).add_(EPS)
            p.addcdiv_(g, root, value=-self.learning_rate)

    def _prepare(self, n: int, m: int) -> None:
        """Make the buffers for n observed and m simulated events."""
        self.sizes = n, m
        linears = [layer for layer in self.network if isinstance(layer, Linear)]
        slopes = [layer.weight for layer in self.network if isinstance(layer, PReLU)]
        pairs = zip(linears, [*slopes, None], strict=True)
        *self.layers, self.last = [Layer(linear, slope, self.grad, n, m, self.r1) for linear, slope in pairs]
