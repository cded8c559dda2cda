"""Simulated method of moments on polynomials of ranks, within a hard budget: no network, no adversary.

A feature is told by Legendre polynomials of its rank among the observed events, as in Neyman's smooth test, and a pair
by the product of two ranks. All of them are bounded: no event counts for more than another because it is far off. A
linear regression of theta on them makes one statistic a parameter. Near theta it is the projection of the score on the
polynomials, so that its mean says all that theirs do. It is matched as in `avo`, with the means of the polynomials of
lowest degree, in rounds that narrow.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.methods.contract import Estimate, Method, TracePoint
from avobench.methods.inputs import Inputs
from avobench.methods.leeway import Leeway, doubt_of, leaves_open
from avobench.methods.polish import Fold, Polished, TooFewEvents, kernel_of, narrower, polish_closer, within_reach
from avobench.methods.problem import Problem
from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed

MOST_POLYNOMIALS = 250
"""Polynomials of all features, at most. Of more features the degree is less, and if half of the polynomials were pairs,
there are none."""
LEAST_MATCHED = 8
"""Polynomials of lowest degree that are matched beside the statistic, at least, if there are as many: the noise of few
means could look like information on theta."""
MOST_MATCHED = 32
"""Features of which any are. How the means of more of them move with theta is mostly noise."""
ROWS_AT_A_TIME = 8192
"""Events whose polynomials are held at once: 8 MB."""
SLOPES = 8.0
"""Ratio of the information on a parameter to what noise alone would show, that a round is wide enough for."""
EVENTS_PER_COEFFICIENT = 10
"""Effective number of simulated events near the estimate for each coefficient of the local quadratic, at least."""
MOST_TESTED = 50_000
"""The latest events, at most, by which it is tested whether all polynomials agree: 100 MB of them."""
RIDGE = 1e-4
"""Share of the mean variance of the polynomials that is added to each, for those that are nearly copies of others."""
LEAST_AGREEMENT = 1e-3
"""P-value of the difference of the means of all polynomials, below which the answer is in doubt. A test that many fits
are put to should seldom be wrong."""


class Polynomials:
    """Legendre polynomials of unit variance, of ranks from -1 to 1 as observed events have them: (n, d) -> (n, k)."""

    def __init__(self, observed: NDArray[np.float32], degree: int) -> None:
        d = observed.shape[1]
        pairs = d * (d - 1) // 2 if d * (d - 1) < MOST_POLYNOMIALS else 0
        self.degree = max(min(degree, (MOST_POLYNOMIALS - pairs) // d), 1)
        self.first, self.second = np.triu_indices(d, 1) if pairs else (np.empty(0, int), np.empty(0, int))
        distinct = np.array([len(np.unique(column)) for column in observed.T])
        degrees = np.arange(1, self.degree + 1)
        # of a feature with two values all polynomials are the same
        self.kept = degrees <= np.maximum(distinct - 1, 1)[:, None]
        lowest = max(LEAST_MATCHED // d, 1) if d <= MOST_MATCHED else 0
        self.lowest = np.flatnonzero(np.broadcast_to(degrees <= lowest, self.kept.shape)[self.kept])
        """Those of lowest degree."""

    def __call__(self, ranks: NDArray[np.float32]) -> NDArray[np.float32]:
        each = legvander(ranks, self.degree)[..., 1:] * np.sqrt(2 * np.arange(1, self.degree + 1, dtype=np.float32) + 1)
        return np.hstack([each[:, self.kept], each[:, self.first, 0] * each[:, self.second, 0]])

    def parts(self, ranks: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """The same a part of the events at a time."""
        return (self(ranks[start : start + ROWS_AT_A_TIME]) for start in range(0, len(ranks), ROWS_AT_A_TIME))


@dataclass(frozen=True)
class RankMoments(Method):
    """Where the means of the polynomials that tell theta are the observed ones, by a local quadratic in theta.

    Where that leaves a combination of parameters open, the last round goes to the best point of all that agree, as in
    `avo`. The answer is doubtful where the means of all polynomials together do not agree.
    """

    name: ClassVar[str] = "rank-moments"
    version: ClassVar[str] = "1"
    by_moments: ClassVar[bool] = True
    source: ClassVar[str] = (
        "J. Neyman, Skand. Aktuarietidskr. 20 (1937) 149; D. McFadden, Econometrica 57 (1989) 995; P. Fearnhead, "
        "D. Prangle, J. R. Stat. Soc. B 74 (2012) 419"
    )

    rounds: int = 8
    """Number of rounds of simulation, each with an equal share of the budget, as of `smm`."""
    degree: int = 8
    """Degree of the polynomials of each feature, at most, as in the test of `infer` whether an estimate agrees."""
    shrink: float = 0.5
    """Least width of a round in units of the one before, as of `smm`."""
    errors: float = 5.0
    """Least width of a round in standard errors of the answer before it; more where many means are matched by few
    simulated events. With 3 some fits went astray, and with 10 the means were no quadratic over it, on development
    cases."""
    symmetric: bool = True
    """Sum an image over its cyclic axes, along which nothing depends on theta."""

    def __post_init__(self) -> None:
        if min(self.rounds, self.degree) < 1 or not 0 < self.shrink <= 1 or self.errors <= 0:
            raise ValueError("rank-moments needs rounds and degree of at least 1, 0 < shrink <= 1 and errors above 0")

    def min_simulations(self, num_parameters: int) -> int:
        """The budget that gives each round ten events for each coefficient of the local quadratic."""
        return self.rounds * 5 * (num_parameters + 1) * (num_parameters + 2)

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        return _Rounds(self, problem, rng).estimate()


class _Rounds:
    """The inference of one problem: what it is given, and the events simulated so far."""

    def __init__(self, settings: RankMoments, problem: Problem, rng: np.random.Generator) -> None:
        if len(problem.x_observed) < 2:
            raise UsageError(f"{settings.name} needs at least 2 observed events, got 1: take smm")
        self.settings, self.problem, self.rng = settings, problem, rng
        self.proposal, self.p = TruncatedGaussian(problem.prior, problem.support), problem.prior.dim
        self.inputs = Inputs(problem, symmetric=settings.symmetric, whiten=True)
        self.u = np.empty((0, self.p))
        self.ranks = np.empty((0, self.inputs(problem.x_observed[:1]).shape[1]), np.float32)
        self.trace: list[TracePoint] = []

    def estimate(self) -> Estimate:
        settings, proposal, simulate = self.settings, self.proposal, self.problem.simulate
        # With too little left the simulator refuses a round, rather than an answer being made of next to nothing.
        self.total = max(simulate.remaining, settings.min_simulations(self.p))
        ends = simulate.used + np.linspace(0, self.total, settings.rounds + 1).astype(int)[1:]
        answer, root = Polished(np.zeros(self.p), np.eye(self.p), 0, converged=False), np.eye(self.p)
        leeway, toward = None, np.zeros(self.p)
        for end in ends:
            last = end == ends[-1]
            if last and self.trace and leaves_open(answer, self.problem.prior):  # of many answers the best is elsewhere
                everywhere = self.folds(np.arange(len(self.u)))
                leeway = Leeway(everywhere, self.problem.prior)
                toward = leeway.best(proposal.scale)
                answer, root = self.polish(toward, settings.shrink * np.eye(self.p), toward)
                if isinstance(self.problem.prior, Distributed):  # no box to be averaged over: its moments decide
                    leeway, toward = None, np.zeros(self.p)
            if self.trace:
                root = narrower(root, answer, settings.shrink, self.errors, proposal.widest)
            std = np.sqrt((root**2).sum(axis=1))
            self.simulate(proposal.around(answer.mean, root, end - simulate.used, self.rng))
            answer, root = self.polish(answer.mean, root, toward)
            error = leeway.error(answer.mean) if leeway else answer.error
            self.trace.append(TracePoint(simulate.used, proposal.to_raw(answer.mean), error * proposal.scale))
        covariance = leeway.covariance(answer.mean) if leeway else answer.covariance
        theta = self.trace[-1].theta
        return Estimate(
            theta=theta,
            how="where the simulated means of the polynomials of ranks agree with the observed ones",
            spread_of="proposal",
            mean=theta,
            std=std * proposal.scale,
            trace=self.trace,
            message=f"the last of {settings.rounds} fits {'converged' if answer.converged else 'did not converge'}",
            error=error * proposal.scale,
            covariance=np.outer(proposal.scale, proposal.scale) * covariance,
            doubt="; ".join(filter(None, (self.inputs.doubt, self.doubt(answer, root)))),
        )

    def simulate(self, u: NDArray[np.float64]) -> None:
        """Simulate an event at each u (n, p), and keep it."""
        new = self.inputs.simulated(self.problem.simulate(self.proposal.to_raw(u)))
        if not len(self.u):  # from now on it is known which features the simulator never makes
            observed = self.inputs(self.problem.x_observed)
            self.sorted = np.sort(observed, axis=0)
            self.observed = ranks(self.sorted, observed).astype(np.float32)
            self.polynomials = Polynomials(self.observed, self.settings.degree)
            # over m standard errors a half of the events shows the information m^2 times as well as one error does
            share = len(observed) / (len(observed) + self.total)
            matched = self.p + len(self.polynomials.lowest)
            self.errors = max(self.settings.errors, np.sqrt(2 * SLOPES * matched * share))
        self.u = np.concatenate([self.u, u])
        self.ranks = np.concatenate([self.ranks, ranks(self.sorted, new).astype(np.float32)])

    def polish(
        self, mean: NDArray[np.float64], root: NDArray[np.float64], toward: NDArray[np.float64]
    ) -> tuple[Polished, NDArray[np.float64]]:
        """Where the means agree, from a point (p,) and how far to look (p, p), and how far that is to be believed."""
        narrowing, alone = (self.settings.shrink, self.errors), self.proposal.widest is not None
        rows = within_reach(self.u, mean, root)
        folds = self.folds(rows if len(rows) > 1 else np.arange(len(self.u)))
        return polish_closer(folds, mean, root, self.proposal.bounds, narrowing, toward, alone=alone)

    def folds(self, rows: NDArray[np.int64]) -> list[Fold]:
        """The halves of these simulated events and of all observed ones, by the statistic of the other half."""
        halves = rows[::2], rows[1::2]
        weights = [self.regression(half) for half in halves]
        return [
            Fold(
                self.features(self.observed[k::2], weights[1 - k]),
                self.features(self.ranks[half], weights[1 - k]),
                self.u[half],
            )
            for k, half in enumerate(halves)
        ]

    def features(self, ranks: NDArray[np.float32], weights: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is matched of events with these ranks (n, d): p statistics, and the polynomials of lowest degree."""
        parts = self.polynomials.parts(ranks)
        return np.concatenate([np.hstack([part @ weights, part[:, self.polynomials.lowest]]) for part in parts])

    def regression(self, rows: NDArray[np.int64]) -> NDArray[np.float32]:
        """Coefficients of the linear regression of theta on the polynomials of these events: (k, p)."""
        u, start, sums = self.u[rows] - self.u[rows].mean(axis=0), 0, None
        for part in self.polynomials.parts(self.ranks[rows]):
            beside = np.hstack([part, np.ones((len(part), 1))]).astype(np.float32)
            both = beside.T @ np.hstack([beside, u[start : start + len(part)].astype(np.float32)])
            sums, start = both if sums is None else sums + both, start + len(part)
        k = len(sums) - 1
        mean, n = sums[k, :k].astype(float) / len(rows), len(rows)
        covariance, slopes = sums[:k, :k] / n - np.outer(mean, mean), sums[:k, k + 1 :].astype(float) / n
        covariance[np.diag_indices(k)] += RIDGE * np.trace(covariance) / k
        return np.linalg.solve(covariance, slopes).astype(np.float32)

    def doubt(self, answer: Polished, root: NDArray[np.float64]) -> str:
        """Say why the answer may be wrong, or "": no convergence, no information, or a remaining difference."""
        if doubt := doubt_of(answer, self.problem.prior):
            return doubt
        rows = within_reach(self.u, answer.mean, root)[-MOST_TESTED:]
        real, synthetic = (np.concatenate(list(self.polynomials.parts(of))) for of in (self.observed, self.ranks[rows]))
        fold, coefficients = Fold(real, synthetic, self.u[rows]), (self.p + 1) * (self.p + 2) // 2
        try:
            near = fold.near(answer.mean, kernel_of(root))
        except TooFewEvents:
            near = None
        if near is None or near.spread[0, 0] * EVENTS_PER_COEFFICIENT * coefficients > 1:
            return "too few events were simulated near the estimate to test it"
        misfit, dof = fold.misfit(answer.mean, root), len(fold.shift)
        if chi2.sf(dof * misfit, dof) > LEAST_AGREEMENT:
            return ""
        return f"events simulated at the estimate differ from the observed ones: chi2/ndf is {misfit:.1f} in place of 1"


def ranks(observed: NDArray[np.float32], x: NDArray[np.float32]) -> NDArray[np.float64]:
    """Ranks of x (n, k) among sorted observed numbers (N, k), from -1 below all to 1 above, of equal ones the mean."""
    columns = zip(observed.T, x.T, strict=True)
    places = [np.searchsorted(real, new, "left") + np.searchsorted(real, new, "right") for real, new in columns]
    return np.column_stack(places) / len(observed) - 1
