"""The angle of muons from electron-positron collisions near the Z: two parameters, one asymmetry."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import quad, quad_vec

from avobench.tasks.contract import Box, Discriminator, Task, histogram

M_Z = 90.0
"""Mass of the Z boson as this model rounds it, in GeV."""


@dataclass(frozen=True)
class Weinberg(Task):
    """x = cos A in [-1, 1] with density 3/8 (1 + x^2 + c x), A the muon's polar angle: x (n, 1) float64.

    c = 2 tanh(10 (2 E_beam - M_Z) / M_Z) G_f, the forward-backward asymmetry.

    Parameters: `e_beam`, the beam energy in GeV; `g_f`, the Fermi constant relative to its nominal value. Prior:
    U(43, 47) and U(0, 2), where |c| < 1.67. Support: [42.8, 47.2] and [-0.2, 2.2], where |c| < 1.995; beyond |c| = 2
    the density would be negative. Source: paper, Sections 4.3 and B.1.

    Floor: theta enters through c alone, so no number of events tells apart two theta of equal c. Even with c known
    exactly there remains the posterior variance, summed over both parameters, along the curve c = c(theta). It is the
    squared error that the posterior mean makes on average over the prior's theta on that curve: 0.366 averaged over
    the prior, whose own variance is 1.667. At one theta of the curve an estimate may do better, so single targets are
    to be compared with `posterior_mean` on the same targets. N and n do not enter: 100 000 observed events know c to
    0.005 to 0.008, which adds 0.004 on average over the prior (0.006 with 160 000 simulated events as the only access
    to the model), nearly all of it where |c| is so small that its sign, hence that of E_beam - M_Z / 2, is uncertain.

    Raises ValueError for `num_bins` below 1.
    """

    num_bins: int = 20
    """Equal bins of the summary between -1 and 1."""

    name: ClassVar = "weinberg"
    parameter_names: ClassVar = ("e_beam", "g_f")
    parameter_units: ClassVar = ("GeV", "1")
    source: ClassVar = "Louppe, Hermans, Cranmer 2019, Section 4.3 and Appendix B.1"
    prior: ClassVar = Box((43, 0), (47, 2))
    support: ClassVar = Box((42.8, -0.2), (47.2, 2.2))
    num_features: ClassVar = 1
    feature_names: ClassVar = ("cos_angle",)
    discriminator: ClassVar = Discriminator(hidden=(1000,) * 4)

    def __post_init__(self) -> None:
        if not (isinstance(self.num_bins, int) and self.num_bins >= 1):
            raise ValueError(f"num_bins must be a whole number of at least 1, got {self.num_bins}")

    def asymmetry(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The coefficient c of the density: theta (n, 2) -> (n,)."""
        return 2 * np.tanh(10 * (2 * theta[:, 0] - M_Z) / M_Z) * theta[:, 1]

    def identifiable(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The coefficient c alone: theta (n, 2) -> (n, 1)."""
        return self.asymmetry(theta)[:, None]

    @property
    def identifiable_scale(self) -> NDArray[np.float64]:
        """Differences of c are told as they are: (1,)."""
        return np.ones(1)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 2) -> x (n, 1). Raises ValueError outside the support, or where |c| > 2."""
        self.require_support(theta)
        return sample_cosine(self.asymmetry(theta), rng)[:, None]

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the events in each bin: (n, 1) -> (num_bins,), summing to 1.

        An event outside [-1, 1], which this simulator never makes, counts in no bin: the sum is then below 1.
        """
        return histogram(x, np.linspace(-1, 1, self.num_bins + 1))

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """Posterior variance given c(theta), summed over both parameters; see the class.

        Raises ValueError for a theta whose c no theta of the prior has.
        """
        mean, square = self._posterior_moments(self.asymmetry(theta[None]))[0]
        return max(0.0, float((square - mean**2).sum()))  # rounding, where the curve shrinks to a corner of the prior

    def asymmetry_floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """Expected squared error of the best estimator of c at theta (2,): (1/N + 1/n) / I(c), without n 1 / (N I(c)).

        I(c) is the Fisher information of one event on c, the mean of (d log density / dc)^2.
        """
        c = self.asymmetry(theta[None])[0]
        information = quad(lambda x: 3 / 8 * x**2 / (1 + x**2 + c * x), -1, 1)[0]
        return (1 / num_observations + (0 if num_simulations is None else 1 / num_simulations)) / information

    def density(self, x: NDArray[np.float64], theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The density of cos A at theta (2,): x (n,) within [-1, 1] -> (n,)."""
        return 3 / 8 * (1 + x**2 + self.asymmetry(theta[None])[0] * x)

    def posterior_mean(self, c: ArrayLike) -> NDArray[np.float64]:
        """Mean of theta given c, the best estimate of all who know no more than c: c (...) -> (..., 2).

        Raises ValueError for a c that no theta of the prior has.
        """
        return self._posterior_moments(np.asarray(c, float))[..., 0, :] + [M_Z / 2, 0]

    def _posterior_moments(self, c: NDArray[np.float64]) -> NDArray[np.float64]:
        """First and second moments of (E_beam - M_Z / 2, G_f) given c, under the uniform prior: c (...) -> (..., 2, 2).

        With v = 10 (2 E_beam - M_Z) / M_Z the curve is G_f = c / (2 tanh v), where v has the sign of c and G_f ends at
        the prior's edge. Along it the density in v is proportional to |dG_f / dc| = 1 / (2 tanh |v|), that is, flat in
        s = log sinh |v|. At c = 0 this is the limit of c -> 0, where everything gathers at E_beam = M_Z / 2, G_f = 0.
        """
        largest = self.asymmetry(np.array([self.prior.high]))[0]
        if not (np.abs(c) <= largest).all():
            raise ValueError(f"the prior has |c| of at most {largest:.4f}, got c = {c}")
        tanh_low = np.maximum(np.abs(c) / (2 * self.prior.high[1]), np.finfo(float).tiny)  # a finite s at c = 0
        s_low = np.log(tanh_low) - np.log1p(-(tanh_low**2)) / 2
        s_high = np.log(np.sinh(10 * (2 * self.prior.high[0] - M_Z) / M_Z))

        def moments(share: float) -> NDArray[np.float64]:
            v = np.arcsinh(np.exp(s_low + share * (s_high - s_low)))
            theta = np.stack([np.sign(c) * v * M_Z / 20, np.abs(c) / (2 * np.tanh(v))], axis=-1)
            return np.stack([theta, theta**2], axis=-2)

        return quad_vec(moments, 0, 1, norm="max")[0]


def sample_cosine(c: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Exact draws of density 3/8 (1 + x^2 + c x) on [-1, 1], one per c: (n,) -> (n,). Raises ValueError for |c| > 2.

    |x| has density 3/4 (1 + x^2) whatever c is: uniform with probability 3/4, a uniform's cube root otherwise. Given
    |x|, the sign is positive with probability (1 + x^2 + c |x|) / (2 (1 + x^2)), which is one only for |c| <= 2.
    """
    if not (np.abs(c) <= 2).all():
        raise ValueError(f"the density is negative where |c| > 2, got c = {c[~(np.abs(c) <= 2)][0]}")
    n = len(c)
    size = rng.random(n)
    size = np.where(rng.random(n) < 3 / 4, size, np.cbrt(size))
    return np.where(rng.random(n) < (1 + c * size / (1 + size**2)) / 2, size, -size)
