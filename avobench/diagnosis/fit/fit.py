"""What a fit is: the best parameters of a model for a target, and what may be said of them."""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from avobench.diagnosis.fit.surrogate import Design, ReferenceModel, Surrogate, basis_slope, quadratic, surrogate
from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.target import Target
from avobench.effects.model import Model


@dataclass(frozen=True)
class Fit:
    """The best parameters of a model for a target."""

    model: Model
    point: NDArray[np.float64]
    """Parameters in the unit cube (P,)."""
    residual: NDArray[np.float64]
    """Measured minus simulated mean, whitened: (r,)."""
    jacobian: NDArray[np.float64]
    """Derivative of the simulated mean, whitened, with respect to the cube coordinates: (r, P)."""
    jacobian_noise: NDArray[np.float64]
    """What simulation adds to jacobian^T jacobian: (P, P)."""
    slope_error: float
    """The error of a slope by simulation, all summaries taken together, over the design: about sqrt(6 r N / n)."""
    noise: float
    """Variance that simulation adds, in units of that of the measurement."""
    predicted: NDArray[np.float64]
    """Simulated mean (K,)."""
    num_events: int
    """The number of events that were simulated for it."""
    design: Design
    """The design of the surrogate that the fit was made with."""

    @property
    def params(self) -> NDArray[np.float64]:
        """(P,)"""
        return self.model.from_cube(self.point)

    @property
    def q(self) -> float:
        """N r^T C^+ r, divided by what simulation adds to its variance."""
        return float(self.residual @ self.residual) / (1 + self.noise)

    @cached_property
    def _directions(self) -> tuple[NDArray[np.float64], ...]:
        """Directions of the parameters with the squared slope of the summary along each, how large simulation alone
        hardly ever makes it, and the squared length of their whole range: (P, P), and (P,) thrice.

        The noise of the slopes adds to their square, the more the more summaries there are. It is taken out, in the
        coordinates of the design, where it is much the same in all directions. It is chi-squared: of few summaries its
        tail is far longer than that of a Gaussian.
        """
        axes = self.design.axes
        slopes, noise = self.jacobian @ axes, axes.T @ self.jacobian_noise @ axes
        values, vectors = np.linalg.eigh(slopes.T @ slopes - noise)
        r = max(len(self.residual), 1)
        by_chance = (chi2.isf(norm.sf(FIT.clear), r) / r - 1) * np.einsum("ik,ij,jk->k", vectors, noise, vectors)
        back = vectors.T @ np.linalg.inv(axes)
        whole_range = 1 / np.maximum((np.linalg.inv(back) ** 2).sum(axis=0), 1e-30)
        return back, values, by_chance, whole_range

    @cached_property
    def information(self) -> tuple[NDArray[np.float64], int]:
        """Fisher information in cube coordinates (P, P), and its rank: how many directions the data identify.

        A direction counts only if its slope stands out of the simulation's noise.
        """
        back, values, by_chance, whole_range = self._directions
        clear = (values > by_chance) & (values * whole_range > FIT.identified**2)
        return (back[clear].T * values[clear]) @ back[clear] / (1 + self.noise), int(clear.sum())

    @property
    def sure_information(self) -> NDArray[np.float64]:
        """The Fisher information (P, P) without as much of it as noise of the slopes hardly ever shows by chance."""
        back, values, by_chance, _ = self._directions
        return (back.T * np.maximum(values - by_chance, 0)) @ back / (1 + self.noise)

    @property
    def undecided(self) -> bool:
        """True if a direction may be identified, but its slope does not stand out of the simulation's noise."""
        _, values, by_chance, whole_range = self._directions
        return bool(((values < by_chance) & ((values + by_chance) * whole_range > FIT.identified**2)).any())

    @property
    def noiseless_q(self) -> float:
        """An unbiased estimate of the Q that endless simulation would give, to compare models with."""
        return float(self.residual @ self.residual) - self.noise * self.dof

    @property
    def noiseless_q_error(self) -> float:
        """Standard error of `noiseless_q` by simulation."""
        return float(np.sqrt(2 * self.dof * self.noise**2 + 4 * max(self.noiseless_q, self.dof) * self.noise))

    @property
    def far(self) -> bool:
        """True if its distance is many times what its degrees of freedom explain."""
        return self.noiseless_q > FIT.far * self.dof

    def distance_to(self, other: "Fit") -> float:
        """How far the point of another fit lies, in standard errors of all parameters together, of either fit."""
        moved = self.point - other.point
        squares = [moved @ np.linalg.solve(fit.point_covariance, moved) for fit in (self, other)]
        return float(np.sqrt(max(squares)))

    def clearly_below(self, other: "Fit") -> bool:
        """True if it is closer to the events than another fit, by more than simulation explains."""
        error = np.hypot(self.noiseless_q_error, other.noiseless_q_error)
        return bool(self.noiseless_q < other.noiseless_q - FIT.worse * error)

    @property
    def num_identified(self) -> int:
        return self.information[1]

    @property
    def dof(self) -> int:
        return len(self.residual) - self.num_identified

    @property
    def p_value(self) -> float:
        """The chi-squared p-value of `q`, with one degree of freedom at least."""
        return float(chi2.sf(self.q, max(self.dof, 1)))

    @cached_property
    def point_covariance(self) -> NDArray[np.float64]:
        """The covariance of the cube coordinates (P, P); where the data say less than the range, that of the range.

        The fit follows slopes to which simulation adds noise, so that it scatters by more than the information says.
        """
        values, vectors = np.linalg.eigh(self.information[0])
        directions = vectors[:, values > 12]
        noise = directions.T @ self.jacobian_noise @ directions / (1 + self.noise)
        followed = directions @ np.linalg.inv(np.diag(values[values > 12]) + noise)
        return (vectors / np.maximum(values, 12)) @ vectors.T + followed @ noise @ followed.T

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard errors of the parameters (P,), linearised."""
        spread = np.sqrt(np.diag(self.point_covariance))
        above, below = (self.model.from_cube(np.clip(self.point + s * spread, 0, 1)) for s in (1, -1))
        moved = np.clip(self.point + spread, 0, 1) - np.clip(self.point - spread, 0, 1)
        return (above - below) / np.maximum(moved, 1e-12) * spread

    @property
    def at_bound(self) -> NDArray[np.int_]:
        """1 for parameters that ended within half a thousandth of the upper end of their range, -1 for the lower."""
        return (self.point > 1 - 5e-4).astype(int) - (self.point < 5e-4)

    def with_slopes_of(self, other: "Fit") -> "Fit":
        """The same fit with the derivatives of another one close to it, which knows them better."""
        fields = ("jacobian", "jacobian_noise", "slope_error", "design")
        return replace(self, **{name: getattr(other, name) for name in fields})

    def follow(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far the parameters move, in cube coordinates (P,), if the whitened mean of the data moves by `change`."""
        return np.linalg.pinv(self.information[0], hermitian=True) @ self.jacobian.T @ change / (1 + self.noise)

    @cached_property
    def reach(self) -> NDArray[np.float64]:
        """Directions of whitened means (r, k) that a change of the parameters can make."""
        _, vectors = np.linalg.eigh(self.information[0])
        return np.linalg.qr(self.jacobian @ vectors[:, self.model.dim - self.num_identified :])[0]

    def projector(self) -> NDArray[np.float64]:
        """Projects whitened means (r, r) onto what no change of the parameters can make."""
        return np.eye(len(self.residual)) - self.reach @ self.reach.T

    def next_design(self, least: float = 0.0, ratio: float = 1.0, most: float = 0.0) -> Design:
        """A design around the fit for `ratio` times its events, with `least` and `most` as in `around`."""
        return self.around(max(FIT.min_sigmas, self.slope_error / np.sqrt(ratio) / FIT.slope_noise), least, most)

    def afforded(self, num_events: int) -> int:
        """So many events of the model, or fewer where each takes many simulated ones, as of rare events."""
        events = self.model.events
        if events is None or not self.model.effects:
            return num_events
        before = events.meter.used
        self.model.simulate(np.tile(self.params, (FIT.probed, 1)), np.random.default_rng(0))
        return int(num_events * min(1.0, FIT.dear * FIT.probed / max(events.meter.used - before, 1)))

    def reference(self, target: Target, num_events: int, rng: np.random.Generator) -> ReferenceModel:
        """The model with a surrogate by so many events over a wide design around the fit."""
        make = partial(surrogate, self.model, target, num_events=self.afforded(num_events), rng=rng)
        return ReferenceModel(self.model, quadratic(make, self.around(FIT.reference_sigmas), target))

    def around(self, sigmas: float, least: float = 0.0, most: float = 0.0) -> Design:
        """A design along the directions of the Fisher information, so many standard errors wide to either side.

        At most as wide as the model can bear, see `Model.reach`, of theta `most` of its range if that is more, and
        `least` of that at least.
        """
        reach, p = self.model.reach(self.point), self.model.num_theta
        reach[:p] = np.maximum(reach[:p], most)
        values, vectors = np.linalg.eigh(self.information[0] * np.outer(reach, reach))
        half = np.clip(sigmas / np.sqrt(np.maximum(values, 1e-9)), max(least, 1e-4), 1)
        return Design(self.point, reach[:, None] * vectors * half)


def fit_at(model: Model, s: Surrogate, target: Target, u: NDArray[np.float64]) -> Fit:
    """What a surrogate says of the point u (P,) of its design."""
    terms = target.summary.linear(np.vstack(s.at(u)))
    mean, slope = terms[0], terms[1:]
    back, steps = np.linalg.inv(s.design.axes), basis_slope(s.design.to_t(u))
    return Fit(
        model=model,
        point=u,
        residual=target.whiten(target.mean - mean),
        jacobian=target.whiten(slope).T,
        jacobian_noise=target.num_events * target.rank * back.T @ steps.T @ s.inverse @ steps @ back,
        slope_error=float(
            np.sqrt(target.num_events * target.rank * np.diag(s.inverse)[1 : model.dim + 1].sum() / max(model.dim, 1))
        ),
        noise=target.num_events * s.variance_at(u),
        predicted=mean,
        num_events=s.num_events,
        design=s.design,
    )
