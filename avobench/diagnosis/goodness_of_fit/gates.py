"""Tests of a fitted model against the measured events: the summary, dependence, single cells, and a classifier."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2, f, norm

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import settled, sharpen
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import repeats, surrogate
from avobench.diagnosis.goodness_of_fit.regions import dependences
from avobench.diagnosis.schema import GateResult
from avobench.diagnosis.settings import TEST
from avobench.diagnosis.summary.pixels import Pixels
from avobench.diagnosis.summary.target import Target
from avobench.effects.bank import Bank, Given
from avobench.effects.pool import Pool

if TYPE_CHECKING:
    from sklearn.ensemble import HistGradientBoostingClassifier


def summary_gate(fit: Fit, target: Target, rng: np.random.Generator, effort: Effort) -> tuple[GateResult, Fit, Target]:
    """Hansen's J test, with the covariance that the model itself predicts; also the fit in that metric, and its target.

    The statistic is the whitened distance at the best theta. It is chi-squared with as many degrees of freedom as the
    summary has, less those that theta takes up, and one at least: where nothing is free to scatter, a distance is left
    because theta cannot reach the measurement. A model predicts another covariance where theta is another, and too
    small a one for bins that it hardly fills there. So a fit that ends far from where its covariance is from is tested
    anew, with that of where it ended. Of rejected ones the least distance counts, as where the covariance goes with
    theta (L. P. Hansen, J. Heaton and A. Yaron, J. Bus. Econ. Stat. 14 (1996) 262).
    """
    ratio = effort.sharpen if fit.p_value > TEST.hopeless else effort.repeated
    num_events = int(ratio * max(target.num_events, TEST.few))
    plainly_wrong, results = fit.noiseless_q > TEST.plainly * fit.dof, []
    for _ in range(Effort.metrics):
        metric, lacking, distinct = model_metric(fit, target, target.mean, target.num_events, rng, effort.covariance)
        # The fit has found its place: wide designs would only show a quadratic where it is none.
        efficient = sharpen(fit, metric, rng, num_events, least=0.0)
        if efficient.p_value > TEST.hopeless:
            efficient = settled(efficient, metric, rng, num_events, effort.settle)
        dof = max(efficient.dof - round(lacking), 1)
        p_value = distance_p(efficient.q, dof, distinct)
        results.append((GateResult(statistic=efficient.q, dof=dof, p_value=p_value), efficient, metric))
        accepted, moved = p_value > TEST.doubted, efficient.distance_to(fit)
        astray = moved > TEST.strayed if accepted else moved > 1 and len(results) < effort.metrics
        if plainly_wrong or not astray:
            break
        fit = efficient
    return results[-1] if accepted else max(results, key=lambda each: each[0].p_value)


def distance_p(q: float, dof: int, num_events: float) -> float:
    """The p-value of a squared distance q in so many dimensions, by a covariance from so many events.

    By H. Hotelling, Ann. Math. Stat. 2 (1931) 360. The share `dof / num_events` by which such a distance is too large
    is left out, as chi-squared does, where it is small beside the scatter.
    """
    if dof**2 / num_events < TEST.biased * np.sqrt(2 * dof):
        return float(chi2.sf(q, dof))
    freedom = max(num_events - dof + 1, 1)
    return float(f.sf(q * freedom / (num_events * dof), dof, freedom))


def model_metric(
    fit: Fit, target: Target, mean: NDArray[np.float64], num_events: int, rng: np.random.Generator, num_simulated: int
) -> tuple[Target, float, float]:
    """A measured mean (K,) of so many events in the metric that the fitted model itself predicts.

    The covariance is the model's, because that of few measured events is biased where they are fewest. Simulated events
    that were given are few as well, and the mean that is compared is theirs too. The covariance is then that within
    both samples, as in any test of two: the measured one is that of the `target`. The other return values are the
    degrees of freedom that are added where the model makes no events, and the number of distinct events of which the
    covariance is.
    """
    source = fit.model.source()
    simulated = fit.model.simulate(np.tile(fit.params, (num_simulated, 1)), rng, source)
    cov, lacking = target.summary.model_covariance(simulated, num_events)
    distinct = num_simulated / repeats(source)
    if isinstance(fit.model.events, Given):
        given = fit.model.events.num_around(fit.params[: fit.model.num_theta])
        share = given / (given + target.num_events)
        cov, lacking = share * cov + (1 - share) * target.cov, share * lacking
        distinct = 1 / (share**2 / distinct + (1 - share) ** 2 / target.num_events)
    metric = Target.of(target.summary, mean, num_events, cov)
    return metric, float(lacking @ (metric.whitening**2).sum(axis=1)), distinct


def cell_gate(fit: Fit, x: NDArray, rng: np.random.Generator, effort: Effort) -> GateResult:
    """The cell of an image (N, d) that is furthest from what the model expects, among all cells.

    Sums over many cells do not see a few that are faulty. Theta hardly moves a single cell, so no correction for it.
    How often a cell fires is compared as two Poisson counts are: of all, the measured ones are binomial, exactly also
    where they are few (J. Przyborowski and H. Wilenski, Biometrika 31 (1940) 313). The statistic is the largest excess
    or deficit in standard deviations.
    """
    n = int(effort.sharpen * len(x))
    simulated = fit.model.simulate(np.tile(fit.params, (n, 1)), rng)
    measured, expected = np.count_nonzero(x, axis=0), np.count_nonzero(simulated, axis=0)
    both, share = measured + expected, len(x) / (len(x) + n)
    tail = np.minimum(binom.cdf(measured, both, share), binom.sf(measured - 1, both, share))
    least = float(min(2 * tail.min(), 1.0))
    p = -np.expm1((both > 0).sum() * np.log1p(-min(least, 1 - 1e-16)))
    return GateResult(statistic=float(norm.isf(max(least, 1e-300) / 2)), dof=None, p_value=float(p), sides=2)


def dependence_gate(fit: Fit, target: Target) -> GateResult | None:
    """The pair of features, or what all have in common, that is furthest from what the model expects; None for images.

    Among all bins the summary gate does not see a single pair that depends, nor what every feature shows by little.
    The statistic is the largest distance in standard errors. Pairs, however many, and what all have in common share
    the false alarms in equal parts, and all that were looked at count (Z. Sidak, J. Am. Stat. Assoc. 62 (1967) 626).
    Nothing is simulated for it: `fit` is in the metric of `target`, that of the model itself.
    """
    scan = dependences(fit, target)
    if not scan.regions:
        return None
    z, pairs = np.abs(scan.z(fit)), np.array([len(region.features) == 2 for region in scan.regions])
    groups = [group for group in (z[pairs], z[~pairs]) if len(group)]
    each = [-np.expm1(len(group) * np.log1p(-min(2 * norm.sf(group.max()), 1 - 1e-16))) for group in groups]
    return GateResult(statistic=float(z.max()), dof=None, p_value=float(min(1, len(each) * min(each))), sides=2)


Features = Callable[[NDArray], NDArray]


def features_of(target: Target) -> Features:
    """What a classifier sees of events: their features, of images the parts of their summary."""
    if isinstance(target.summary, Pixels):
        return target.summary.vectors
    inner = [edges[np.isfinite(edges)] for edges in target.summary.edges]
    spread = [np.ptp(edges) if len(edges) > 1 else 1.0 for edges in inner]
    return partial(rounded, grain=TEST.grain * np.array(spread))


def rounded(x: NDArray, grain: NDArray[np.float64]) -> NDArray:
    """Events (n, d) to multiples of `grain` (d,): equal values must not differ by how a computer arrives at them."""
    return x if np.issubdtype(x.dtype, np.integer) else np.rint(x / grain) * grain


def trained(x: NDArray, simulated: NDArray, seed: int) -> "HistGradientBoostingClassifier":
    """A classifier of measured (1) against simulated (0) events."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    labels = np.r_[np.ones(len(x)), np.zeros(len(simulated))]
    trees = HistGradientBoostingClassifier(
        max_iter=TEST.trees, max_leaf_nodes=TEST.leaves, learning_rate=0.1, early_stopping=False, random_state=seed
    )
    return trees.fit(np.concatenate([x, simulated]), labels)


@dataclass(frozen=True)
class Score:
    """A classifier's log odds, as a summary of one number."""

    trees: "HistGradientBoostingClassifier"
    features: Features

    def of(self, x: NDArray) -> NDArray[np.float64]:
        """(n, d) -> (n,)"""
        return self.trees.decision_function(self.features(x)) if len(x) else np.empty(0)  # scikit-learn refuses none

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """weights^T s(x): (n, d), (n, b) -> (b, 1)."""
        return weights.T @ self.of(x)[:, None]

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        """Squared change of each event, in units of the variance: (n, d) twice -> (n,)."""
        a = self.of(before)
        return (a - self.of(after)) ** 2 / max(a.var(), 1e-30)


def classifier_gate(fit: Fit, target: Target, x: NDArray, rng: np.random.Generator, effort: Effort) -> GateResult:
    """Does a classifier, trained on one half of the events x (N, d), tell the other half from simulated ones?

    The statistic is the mean log odds of the second half, less what the model expects, in standard errors; one-sided,
    because a classifier that learned something raises it. Theta was fitted on the same events, to the summary of
    `target`: each event's pull on theta is taken out of the statistic and of its variance, which calibrates the test
    without refits. The halves are not exchanged and averaged: fluctuations that the two halves share by chance raise
    both statistics at once, and their mean is wider than it seems.
    """
    half = len(x) // 2
    training, test = x[:half], x[half:]
    at = np.tile(fit.params, (len(x), 1))
    view, model = features_of(target), fit.model
    if isinstance(model.events, Bank | Pool):
        # They serve the expectation below; a classifier knows again the events that it learned from.
        model = replace(model, events=model.events.fresh)
    score = Score(trained(view(training), view(model.simulate(at[:half], rng)), int(rng.integers(2**31))), view)
    expected = surrogate(fit.model, score, fit.design, int(min(TEST.check_events, effort.sharpen) * len(x)), rng)
    at_fit, slope = expected.at(fit.point)
    g = score.of(test)
    # Where theta moves if the summary of one event is added, in the directions that the data identify.
    inverse = np.linalg.pinv(fit.information[0] * (1 + fit.noise), hermitian=True)
    pull = np.sqrt(target.num_events) * (slope[:, 0] @ inverse @ fit.jacobian.T) @ target.whitening.T  # (K,)
    s = target.summary.project(x, pull)
    share = len(test) / len(x)
    influence = -(s - s.mean())
    influence[half:] += (g - g.mean()) / share
    simulation = expected.variance_at(fit.point) * g.var()
    error = np.sqrt(influence.var() / len(x) + simulation)
    t = float((g.mean() - at_fit[0]) / max(error, 1e-12))  # no error where all events are alike
    return GateResult(statistic=t, dof=None, p_value=float(norm.sf(t)))


@dataclass(frozen=True)
class ExtendedModel:
    """A fitted model, the task alone or with effects, and all tests of it.

    The metric of a target is the covariance in which chi-squared is taken.
    """

    fit: Fit
    """The fit in the metric of the target, in which models are compared."""
    efficient: Fit
    """The fit in the metric that the model itself predicts, with more events; reported if the model is right."""
    metric: Target
    """The target in that metric."""
    gates: dict[str, GateResult]

    @classmethod
    def of(
        cls,
        fit: Fit,
        target: Target,
        x: NDArray | None,
        rng: np.random.Generator,
        effort: Effort,
        affordable: Callable[[str], AbstractContextManager] = nullcontext,
    ) -> "ExtendedModel":
        """A fitted model with all tests of it by the measured events x (N, d); of tables that of the summary.

        The classifier may be left out, where `affordable` takes it that the simulated events end.
        """
        gate, efficient, metric = summary_gate(fit, target, rng, effort)
        gates = {"summary": gate}
        if x is None:
            return cls(fit, efficient, metric, gates)
        if fit.model.task.event_shape:
            gates["cells"] = cell_gate(efficient, x, rng, effort)
        shares = TEST.image_shares if "cells" in gates else TEST.shares
        if dependence := dependence_gate(efficient, metric):
            gates["dependence"], shares = dependence, TEST.dependent_shares
        with affordable("the test by a classifier"):
            gates["classifier"] = classifier_gate(efficient, metric, x, rng, effort)
        return cls(
            fit,
            efficient,
            metric,
            {name: gate.model_copy(update={"share": dict(shares)[name]}) for name, gate in gates.items()},
        )

    @property
    def p_value(self) -> float:
        """The p-value of all tests together; 1 before any."""
        return min([1.0, *(gate.p_value / gate.share for gate in self.gates.values())])


@dataclass(frozen=True)
class Correction:
    """Simulated events of the final model and weights that make them look like measured ones.

    A description of the disagreement, and not a cause.
    """

    x: NDArray
    """(n, d)"""
    weights: NDArray[np.float64]
    """(n,), of mean 1."""


def correction(fit: Fit, target: Target, x: NDArray, rng: np.random.Generator) -> Correction:
    """Odds of a classifier between measured events x (N, d) and as many simulated ones, for as many others."""
    simulated = fit.model.simulate(np.tile(fit.params, (2 * len(x), 1)), rng)
    training, weighted = simulated[: len(x)], simulated[len(x) :]
    view = features_of(target)
    trees = trained(view(x), view(training), int(rng.integers(2**31)))
    odds = np.exp(np.clip(trees.decision_function(view(weighted)), -10, 10))
    return Correction(weighted, odds / odds.mean())
