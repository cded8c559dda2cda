"""Independent coordinates with one parameter each, warped and mixed: tasks that a mean of the events does not solve."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from avobench.tasks.contract import Box, Discriminator, Task, histogram

KINDS = ("scale", "correlation", "tail", "mean")
"""The kinds of what the parameters of `Warped` set, over and over in this order."""
SPREAD = 0.8
"""Standard deviation of a coordinate of z at theta = 0; sinh then stretches the tails of x to ten times its core."""
NARROW = 0.5
"""Width, in units of SPREAD, of the core of a coordinate with a tail."""
WIDE = 2.0
"""Width of its tail. An event says 40 % of what it would if it were known which of the two it is from."""
REACH = 12.0
"""Reach of the quadrature over the tail's density, in units of SPREAD: six standard deviations of the wide Gaussian."""
NODES = 2001
"""Nodes of that quadrature by the trapezoidal rule, exact to rounding from some 200 on."""


@dataclass(frozen=True)
class Mixed(Task):
    """x = R sinh(z), with independent parts of z that each have one parameter: x (n, d) float64.

    With independent standard Gaussians e, and s = SPREAD, a parameter theta of each kind sets

    - mean: z = s (theta + e);
    - scale: z = s exp(theta) e;
    - correlation: z = s (e1, r e1 + sqrt(1 - r^2) e2), two coordinates with r = tanh(theta);
    - tail: z = s WIDE e with probability (1 + tanh(theta)) / 2, else z = s NARROW e.

    R is the orthonormal matrix of the discrete cosine transform, which mixes all coordinates in about equal parts.
    Of the four kinds only the mean moves the mean of x. Prior: U(-0.7, 0.7) each. Support: [-1, 1] each.

    Floor: z = arcsinh(R^T x), so x says as much as z, and the parts of z are independent: the Fisher information is
    diagonal, for one event 1 for a mean, 2 for a scale, 1 + r^2 for a correlation, and for a tail with share w
    (dw/dtheta)^2 times the integral of (wide - narrow)^2 / density. Their inverses are summed; N observed events leave
    1 / N of that, and a method that knows the model only through n simulated events adds 1 / n.
    """

    kinds: ClassVar[tuple[str, ...]]
    """The one of KINDS that each parameter sets."""

    by_default: ClassVar = False
    parameter_names: ClassVar[tuple[str, ...]]
    source: ClassVar = "this project; the floor is exact, as the map from z to x can be inverted"
    discriminator: ClassVar = Discriminator()

    def __init_subclass__(cls, p: int = 0, kinds: tuple[str, ...] = (), family: str = "", **rest: object) -> None:
        super().__init_subclass__(**rest)
        if not p:
            return
        cls.name, cls.kinds = f"{family}-{p}", tuple(kinds[i % len(kinds)] for i in range(p))
        cls.parameter_names = tuple(f"{kind}{i + 1}" for i, kind in enumerate(cls.kinds))
        cls.parameter_units = ("1",) * p
        cls.prior, cls.support = Box((-0.7,) * p, (0.7,) * p), Box((-1.0,) * p, (1.0,) * p)
        cls.num_features = p + cls.kinds.count("correlation")
        at_center = 1 / information(cls.kinds, np.zeros(p))
        cls.floor_shares = tuple((at_center / at_center.sum()).tolist())

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, p) -> x (n, d). Raises ValueError outside the support."""
        self.require_support(theta)
        columns = []
        for kind, t in zip(self.kinds, theta.T, strict=True):
            e = rng.standard_normal(len(theta))
            if kind == "mean":
                columns.append(t + e)
            elif kind == "scale":
                columns.append(np.exp(t) * e)
            elif kind == "tail":
                columns.append(np.where(rng.random(len(theta)) < (1 + np.tanh(t)) / 2, WIDE, NARROW) * e)
            else:
                r = np.tanh(t)
                columns += [e, r * e + np.sqrt(1 - r**2) * rng.standard_normal(len(theta))]
        return np.sinh(SPREAD * np.stack(columns, axis=1)) @ rotation(self.num_features).T

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the events in each of 30 bins of arcsinh of each feature, overflow included: (n, d) -> (32 d,)."""
        return histogram(np.arcsinh(x), np.linspace(-6, 6, 31), overflow=True)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """The sum of the inverse informations times 1 / N, and 1 / n more with n simulated events."""
        per_event = float((1 / information(self.kinds, theta)).sum())
        return per_event / num_observations + (0 if num_simulations is None else per_event / num_simulations)


def information(kinds: tuple[str, ...], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fisher information of one event on each parameter (p,), of which each has its own part of z."""
    of = {"mean": lambda t: 1.0, "scale": lambda t: 2.0, "correlation": lambda t: 1 + np.tanh(t) ** 2, "tail": _tail}
    return np.array([of[kind](t) for kind, t in zip(kinds, theta, strict=True)])


def _tail(theta: float) -> float:
    z, share = np.linspace(-REACH, REACH, NODES), (1 + np.tanh(theta)) / 2
    wide, narrow = gaussian(z, WIDE), gaussian(z, NARROW)
    integrand = (wide - narrow) ** 2 / (share * wide + (1 - share) * narrow)
    return float((2 * share * (1 - share)) ** 2 * integrand.sum() * (z[1] - z[0]))


def gaussian(z: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """Density of N(0, width^2)."""
    return np.exp(-((z / width) ** 2) / 2) / (width * np.sqrt(2 * np.pi))


def rotation(d: int) -> NDArray[np.float64]:
    """R: the orthonormal discrete cosine transform (d, d)."""
    return dct(np.eye(d), norm="ortho", axis=0)


class Warped2(Mixed, p=2, kinds=KINDS, family="warped"):
    """A scale and a correlation."""


class Warped5(Mixed, p=5, kinds=KINDS, family="warped"):
    """Two scales, a correlation, a tail and a mean."""


class Warped10(Mixed, p=10, kinds=KINDS, family="warped"):
    """Three scales, three correlations, two tails and two means."""


class Warped20(Mixed, p=20, kinds=KINDS, family="warped"):
    """Five of each kind."""


class Means2(Mixed, p=2, kinds=("mean",), family="means"):
    """The control of Warped2: two parameters, of which the means of x tell nearly all."""


class Means5(Mixed, p=5, kinds=("mean",), family="means"):
    """The control of Warped5."""


class Means10(Mixed, p=10, kinds=("mean",), family="means"):
    """The control of Warped10."""


class Means20(Mixed, p=20, kinds=("mean",), family="means"):
    """The control of Warped20."""
