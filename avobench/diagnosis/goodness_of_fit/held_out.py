"""How large the gap is on held-out events, and whether an added effect makes it smaller."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.goodness_of_fit.gates import model_metric
from avobench.diagnosis.schema import Gap
from avobench.diagnosis.settings import TEST
from avobench.diagnosis.summary.joint import StackedSummary
from avobench.diagnosis.summary.part import Measured, Part
from avobench.diagnosis.summary.table import TableSummary
from avobench.diagnosis.summary.target import Target


@dataclass(frozen=True)
class HeldOut:
    """Measured events that no fit has seen, by their summary."""

    target: Target
    """What models are fitted to: other events of the same measurement."""
    mean: NDArray[np.float64]
    """The mean summary of the held-out events (K,)."""
    num_events: int

    @classmethod
    def of(cls, target: Target, x: Measured) -> "HeldOut":
        """Of what was kept aside."""
        if isinstance(x, Part):
            return cls(target, *x.seen_by(target.summary))
        return cls(target, target.summary.mean(x)[0], len(x))

    def gap(self, fit: Fit, rng: np.random.Generator, num_simulated: int) -> Gap:
        """Chi-squared per degree of freedom between a fitted model and these events, in the metric of the summary gate.

        1 is what is expected if the model is true: scatter of these events, and of the fit by measurement and
        simulation. A covariance of `num_simulated` events is not the true one, and bins with few events do not scatter
        as Gaussians do. How large chi-squared is of events of the model, and how far it scatters, is therefore taken
        from as many other ones.
        """
        metric, *_ = model_metric(fit, self.target, self.mean, self.num_events, rng, num_simulated)
        others = fit.model.simulate(np.tile(fit.params, (num_simulated, 1)), rng)
        mean, variance = null_moments(metric, others)
        share = self.num_events / self.target.num_events
        ndf = max(mean * (1 + fit.noise * share) + fit.num_identified * share, 1.0)
        variance *= (ndf / mean) ** 2 if mean > 0 else 0
        r = metric.whiten(self.mean - fit.predicted)
        q = float(r @ r)
        low, high = interval(q, ndf, max(variance, 2.0))
        return Gap(value=q / ndf, low=low / ndf, high=high / ndf)

    def shrank(self, new: Fit, old: Fit) -> bool:
        """True if the gap is smaller with one fit than with another, by more than chance brings about.

        Both are compared with the same events, whose scatter they share but for that along the difference d of the two:
        chi-squared differs by 2 |d| times a normal deviate more than it should, of variance 1 from these events and
        their share of those that were fitted from the fits.
        """
        after, before = self._residual(new), self._residual(old)
        error = np.sqrt(1 + (1 + new.noise + old.noise) * self.num_events / self.target.num_events)
        scatter = 2 * float(np.linalg.norm(before - after)) * error
        return float(before @ before - after @ after) > TEST.shrunk * scatter

    def _residual(self, fit: Fit) -> NDArray[np.float64]:
        """Measured minus fitted mean, whitened for so many events: (r,)."""
        return np.sqrt(self.num_events) * ((self.mean - fit.predicted) @ self.target.whitening)


def null_moments(metric: Target, x: NDArray) -> tuple[float, float]:
    """Mean and variance of chi-squared of n events of a model, from other events x (m, d) of it; n is the metric's.

    With whitened vectors z of covariance S, chi-squared of a mean of n has the variance 2 tr(S^2) plus that of |z|^2
    over n. That of tables, and of several data sets, is taken as that of Gaussians.
    """
    if isinstance(metric.summary, TableSummary | StackedSummary):
        return float(metric.rank), metric.summary.chi_squared_variance(metric.rank, metric.num_events)
    whitened = metric.whitening.T @ metric.summary.covariance(x) @ metric.whitening
    some = x[: TEST.scattered]
    z = metric.summary.moments(some, np.eye(len(some))) @ metric.whitening
    length = ((z - z.mean(axis=0)) ** 2).sum(axis=1)
    mean = float(np.trace(whitened))
    return mean, 2 * mean**2 / metric.rank + float(length.var()) / metric.num_events


def interval(q: float, mean: float, variance: float) -> tuple[float, float]:
    """The 95 % interval, by both tails, of the expectation of a chi-squared that was measured to be q.

    Without a gap it has the `mean` and the `variance` given; a gap raises its mean by the noncentrality, and its
    variance by four times as much. In between it is a scaled chi-squared of the same two moments (P. B. Patnaik,
    Biometrika 36 (1949) 202).
    """

    def above(at: float) -> float:
        """Probability to see more than q where `at` is expected."""
        spread = variance + 4 * (at - mean) if at > mean else variance * (at / mean) ** 2
        return float(chi2.sf(2 * at * q / spread, 2 * at**2 / spread))

    if q <= 0:
        return 0.0, 0.0
    ends = []
    for tail in (TEST.tail, 1 - TEST.tail):
        low = high = mean
        while above(low) > tail:
            low /= 2
        while above(high) < tail:
            high *= 2
        ends.append(float(brentq(lambda at, tail=tail: above(at) - tail, low, high)) if low < high else mean)
    return ends[0], ends[1]
