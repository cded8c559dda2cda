"""The preset `avo`: adversarial variational optimization with replayed events, and a polish that simulates nothing.

It keeps what defines AVO (see `avo_paper.py`): a discriminator, a proposal over theta moved by a score-function
gradient of log(1 - d), a simulator that is only called. Differences from the printed algorithm, and what each is worth,
are in docs/methods.md.

`Inference` is the algorithm, for one problem, and `phases` its order; its settings, `Avo`, follow. How many problems'
networks are trained in one batch is the affair of `stacked_discriminators.py`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.methods.avo_paper import TRACE_POINTS, baseline
from avobench.methods.contract import LATER, Estimate, Method, TracePoint
from avobench.methods.device import require_device
from avobench.methods.divergence import Contrast, minimise
from avobench.methods.inputs import Inputs
from avobench.methods.leeway import Leeway, doubt_of, leaves_open
from avobench.methods.polish import Fold, Polished, TooFewEvents, narrower, polish_closer, within_reach
from avobench.methods.problem import Problem
from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks.errors import UsageError
from avobench.tasks.prior import Distributed

if TYPE_CHECKING:
    import torch

    from avobench.methods.stacked_discriminators import Game

MAX_WEIGHT = 5.0
"""Cap on the importance weight of a replayed event, so that no few of them outweigh all others."""
LOCAL_ROUNDS = (0.15, 0.3, 1.0)
"""Shares of the events of the local phase after each of its rounds: two that aim, and one that measures."""
AGAIN = (0.4, 0.5, 0.6, 0.7, 0.8)
"""With `refine`, shares of the events of the local phase after each of the further rounds that aim, which come before
the last one while the answer moves on. Of nine development targets of `slcp` seven ended more than 100 floors off
without such rounds, and four with them."""
MOVES_ON = 0.7
"""Distance between the last two answers from which there is such a round: in widths of the round, a parameter. Where
three rounds are enough it is 0.1 to 0.2, and where they are not 1 to 4."""
LEAST_TAUGHT = 1000
"""Events near the answer from which the statistic is learnt from these alone: about one batch."""
EVENTS_PER_COEFFICIENT = 10
"""Least number of events of the adversarial phase for each coefficient of the polish's local quadratic."""
MOST_MISFIT = 5.0
"""Squared difference of means, in units of their variance and averaged over features, from which the answer is in
doubt. Chance makes it exceed 2 in one run of a million with 64 features and 100 000 events."""
ROWS_AT_A_TIME = 8192
"""Events of which the last layer's inputs are computed at once, so that the values between the layers stay small."""
MOST_INPUTS = 32
"""Largest number of inputs that are matched themselves beside the statistic. How the means of more of them move with
theta is mostly noise, so then one weighted sum a parameter is matched."""

CLOSER = 2.0
"""An answer is looked at again over a width that is so many times smaller. With Student's t quoted errors were else a
third of what they should be: the slope there is not that over ten errors."""
LARGER = 1.5
"""Factor by which errors are larger in the closer look, from which those of the first one were too small."""

KNOWN = 400
"""Observed events for each feature, with the learnt ones among them, from which they tell its covariance. With 40, as
elsewhere, 2 000 events of a Gaussian had a width that was too small by half of its error, and an error by a sixth, on
development draws."""

FEW = 8
"""With at most so many, statistic and inputs, the squares of the inputs stand beside them where the score is learnt."""


class Inference:
    """The inference of one problem: what it is given, and the state that its three phases move."""

    def __init__(self, settings: "Avo", problem: Problem, rng: np.random.Generator) -> None:
        import torch

        from avobench.methods.discriminator import mlp
        from avobench.methods.statistic import Statistic

        if len(problem.x_observed) < 2:
            raise UsageError(f"{settings.name} needs at least 2 observed events, got 1: take smm")
        # what is given
        self.settings, self.problem, self.rng = settings, problem, rng
        self.proposal, p = TruncatedGaussian(problem.prior, problem.support), problem.prior.dim
        self.inputs = Inputs(
            problem, symmetric=settings.symmetric, whiten=settings.whiten, quantiles=settings.inputs == "quantiles"
        )
        self.real = self.inputs(problem.x_observed)[: even(len(problem.x_observed))]
        # with too little left the simulator refuses an iteration, rather than an answer being made of next to nothing
        self.num_events = even(max(problem.simulate.remaining, settings.min_simulations(p)))
        self.num_adversarial = even(round(self.num_events * (1 - settings.local_share if settings.polish else 1)))
        # the state: the two discriminators, the proposal, and the events simulated so far
        self.networks = [mlp(self.real.shape[1], settings.hidden, rng) for _ in range(2)]
        self.psi = np.stack([np.zeros(p), np.full(p, np.log(settings.initial_std))])
        self.start = self.psi.copy()
        self.u, self.log_q = np.empty((0, p)), np.empty(0)  # where they were simulated, and how probable that was
        self.synthetic = np.empty((self.num_events, self.real.shape[1]), np.float32)  # as the networks see their events
        self.statistic: Statistic | None = None
        self.moved = np.inf  # by the last polish, in widths of the round, a parameter
        self.divergence = np.nan  # of Jensen and Shannon, from the observed events, where it was minimised
        self.linear: list[NDArray[np.float32]] = []  # of many inputs, the sums (k, p) that tell theta, a half each
        # what is noted on the way
        self.means = [self.psi[0].copy()]  # of the proposal, after each iteration
        self.trace: list[TracePoint] = []
        self._move = torch.zeros((2, p), dtype=torch.float64)  # of psi, the mean's in units of std
        self._adam = torch.optim.Adam([self._move], betas=(0.9, 0.99))
        if settings.polish and settings.learns:
            self.statistic = Statistic(self.real.shape[1], p, rng, settings.device)
        self.note(self.psi[0], np.exp(self.psi[1]))

    def phases(self) -> "Game":
        """The algorithm. Yields what the discriminators learn from, is sent log(1 - d), returns the estimate."""
        from avobench.methods.stacked_discriminators import Lesson

        # the adversarial phase: both players learn from events simulated at draws from the proposal
        for turn in self.settings.turns(self.num_adversarial):
            fresh = self.simulate(self.draws(turn.end - turn.begin))
            self.synthetic[turn.begin : turn.end] = fresh
            rows = np.stack([self.draw(half, turn) for half in range(2)], axis=2)
            f = yield Lesson(fresh, rows, slice(turn.judge_from, turn.end), turn.learning_rate)
            self.move_proposal(f, turn)
        mean, std = self.averaged_mean, np.exp(self.psi[1])
        if not self.settings.polish:
            estimate = self.estimate(mean, std, "mean of the proposal over the last quarter")
            return replace(estimate, doubt=self.inputs.doubt)
        self.real = self.inputs(self.problem.x_observed)[: len(self.real)]  # without what is never simulated

        # the polish: the proposal's mean goes where simulated events are like the observed ones in what tells theta
        answer, root = self.polish(self.u.mean(axis=0), np.diag(self.u.std(axis=0)), 0, learn=True)

        # the local phase: more events around the answer, and a polish again
        leeway, toward = None, np.zeros_like(answer.mean)
        for num_events in self.rounds():
            start, last, before = len(self.u), num_events == self.num_events, answer.mean
            if last and leaves_open(answer, self.problem.prior):  # many answers, of which the best is elsewhere
                leeway = Leeway(self.matched(), self.problem.prior)
                toward = leeway.best(self.proposal.scale)
                local = self.settings.shrink * np.eye(len(toward))
                answer, root = self.polish(toward, local, toward, learn=False)
                if isinstance(self.problem.prior, Distributed):  # no box to be averaged over: its moments decide
                    leeway, toward = None, np.zeros_like(answer.mean)
            root = narrower(root, answer, self.settings.shrink, self.settings.errors, self.proposal.widest)
            std = np.sqrt((root**2).sum(axis=1))
            self.note(answer.mean, std)
            width = 1 / self.settings.errors if last else 1  # far events tell how phi moves with theta, near ones where
            self.synthetic[start:num_events] = self.simulate(
                self.proposal.around(answer.mean, width * root, num_events - start, self.rng)
            )
            answer, root = self.polish(answer.mean, root, toward, learn=not last)  # near events have nothing to teach
            step = np.linalg.solve(root, answer.mean - before)
            self.moved = np.sqrt(np.mean(step**2)) if answer.converged else np.inf

        state = "converged" if answer.converged else "did not converge"
        error = self.proposal.scale * (leeway.error(answer.mean) if leeway else answer.error)
        errors = ", ".join(f"{e:.3g}" for e in error)
        comment = f"; the polish {state} in {answer.num_steps} steps, with a standard error of {errors}"
        if self.settings.matched == "divergence":
            comment += f"; the divergence there is {self.divergence:.3g} of at most {np.log(2):.3g}"
        estimate = self.estimate(answer.mean, std, "mean of the proposal after the polish", comment)
        covariance = np.outer(self.proposal.scale, self.proposal.scale) * (
            leeway.covariance(answer.mean) if leeway else answer.covariance
        )
        doubt = "; ".join(filter(None, (self.inputs.doubt, self.doubt(answer, root))))
        return replace(estimate, error=error, covariance=covariance, doubt=doubt)

    def rounds(self) -> Iterator[int]:
        """How many events there are after each round of the local phase; it asks for each how far the answer moved.

        With `refine` rounds that aim come before the last one, which measures, for as long as the answer moves on.
        """
        begin, local = self.num_adversarial, self.num_events - self.num_adversarial
        for share in LOCAL_ROUNDS if self.settings.local_share else ():
            end = even(round(begin + share * local))
            if self.settings.refine and end == self.num_events:
                for again in AGAIN:
                    if self.moved <= MOVES_ON:
                        break
                    if (more := even(round(begin + again * local))) > len(self.u):
                        yield more
            if end > len(self.u):  # of a small share of a small budget there may be no event for a round
                yield end

    def draws(self, n: int) -> NDArray[np.float64]:
        """Draws from the proposal, but for a share that is drawn as at the start: (n, p). See `Avo.wide_share`."""
        wide = self.rng.random(n)[:, None] < self.settings.wide_share
        now, first = (self.proposal.sample(psi, n, self.rng) for psi in (self.psi, self.start))
        return np.where(wide, first, now)

    def simulate(self, u: NDArray[np.float64]) -> NDArray[np.float32]:
        """Events at u (n, p), as the discriminators see them: (n, k)."""
        self.u = np.concatenate([self.u, u])
        now, first = (self.proposal.log_density(psi, u).sum(axis=1) for psi in (self.psi, self.start))
        share = self.settings.wide_share
        with np.errstate(divide="ignore"):
            self.log_q = np.append(self.log_q, np.logaddexp(np.log1p(-share) + now, np.log(share) + first))
        return self.inputs.simulated(self.problem.simulate(self.proposal.to_raw(u)))

    def draw(self, half: int, turn: "Turn") -> NDArray[np.int64]:
        """Rows of observed and of simulated events for the discriminator of that half: (2, steps, batch)."""
        shape = (self.settings.discriminator_steps, self.settings.batch_size)
        weight = self.weights(turn.learn_from + half, 2)
        observed = self.rng.integers(len(self.real) // 2, size=shape)
        replayed = self.rng.choice(len(weight), shape, p=weight / weight.sum())
        return np.stack([2 * observed + half, turn.learn_from + 2 * replayed + half])

    def move_proposal(self, f: NDArray[np.float64], turn: "Turn") -> None:
        """One step of the proposal by its score-function gradient over the events to be judged, f (n,) of them."""
        settings, proposal, std = self.settings, self.proposal, np.exp(self.psi[1])
        weight = self.weights(turn.judge_from)[:, None, None]
        score = proposal.score(self.psi, self.u[turn.judge_from :])
        weight /= weight.sum()
        gradient = (weight * score * (f[:, None, None] - baseline("optimal", score, f, weight))).sum(axis=0)
        self._adam.param_groups[0]["lr"] = geometric(settings.proposal_learning_rate, turn.progress)
        self._move.zero_()
        self._move.grad = self._move.new_tensor(np.stack([gradient[0] * std, gradient[1] - settings.entropy]))
        self._adam.step()
        mean, log_std = self.psi[0] + std * self._move[0].numpy(), self.psi[1] + self._move[1].numpy()
        largest = geometric((settings.initial_std, settings.max_std), turn.progress)
        self.psi[0] = np.clip(mean, proposal.low, proposal.high)
        self.psi[1] = np.clip(log_std, np.log(settings.min_std), np.log(largest))
        self.means.append(self.psi[0].copy())
        if turn.progress * TRACE_POINTS // 1 > len(self.trace) - 1:
            self.note(self.averaged_mean, np.exp(self.psi[1]))

    def weights(self, start: int, every: int = 1) -> NDArray[np.float64]:
        """Importance weights of every so many events since `start`: the density of the proposal now over that then."""
        log_ratio = self.proposal.log_density(self.psi, self.u[start::every]).sum(axis=1) - self.log_q[start::every]
        return np.exp(np.minimum(log_ratio, np.log(MAX_WEIGHT)))

    @property
    def averaged_mean(self) -> NDArray[np.float64]:
        """The mean of the proposal, averaged over the last quarter of the iterations so far (p,)."""
        return np.mean(self.means[-1 - (len(self.means) - 1) // 4 :], axis=0)

    @property
    def unseen_halves(self) -> tuple[int, int]:
        """The half of the events on which each network is used: the one that it was not trained on if cross-fitted."""
        return (1, 0) if self.settings.cross_fit else (0, 1)

    def polish(
        self, mean: NDArray[np.float64], root: NDArray[np.float64], toward: NDArray[np.float64] | float, *, learn: bool
    ) -> tuple[Polished, NDArray[np.float64]]:
        """Polish from the mean (p,) and the root (p, p) of the proposal's covariance, on all events simulated so far.

        Where they leave a combination of parameters open it goes toward a point (p,), or toward the prior's mean.
        """
        if learn and self.settings.learns:
            rows = self.taught(mean, root)
            self.statistic.learn(self.synthetic[rows], self.u[rows], self.settings.statistic_steps)
            if self.synthetic.shape[1] > MOST_INPUTS:
                self.linear = [regression(self.synthetic[half : len(self.u) : 2], self.u[half::2]) for half in range(2)]
        shrink, errors = self.settings.shrink, self.settings.errors
        bounds, widest, looks = self.proposal.bounds, self.proposal.widest, (shrink, errors / CLOSER)
        closer = partial(polish_closer, toward=toward, larger=LARGER, alone=widest is not None)
        if self.settings.matched != "divergence":
            return closer(self.matched(), mean, root, bounds, looks)
        begin = [mean]
        if np.isnan(self.divergence):  # where the simulator is wrong the adversary begins nearer than the moments
            answer, root = closer(self.matched(), mean, root, bounds, looks)
            root, begin = narrower(root, answer, shrink, errors, widest), [answer.mean, self.averaged_mean]
        contrasts = self.contrasts()
        minima = [minimise(contrasts, start, root, bounds, toward) for start in begin]
        best = min(minima, key=lambda each: (not each.answer.converged, each.divergence))
        self.divergence = best.divergence
        return best.answer, root

    def taught(self, mean: NDArray[np.float64], root: NDArray[np.float64]) -> NDArray[np.int64]:
        """The rows from which the statistic is learnt: as many of either half of the events, in turn.

        They are all events so far or, with `refine` and once the answer stays, those that the polish from there uses.
        """
        rows = np.arange(len(self.u))
        if not self.settings.refine or self.moved > MOVES_ON:
            return rows
        near = within_reach(self.u, mean, root)
        first, second = near[near % 2 == 0], near[near % 2 == 1]
        n = min(len(first), len(second))
        if 2 * n < LEAST_TAUGHT:
            return rows
        return np.stack([first[len(first) - n :], second[len(second) - n :]], axis=1).ravel()

    def matched(self) -> list[Fold]:
        """The features whose means the polish matches, of all events simulated so far."""
        if self.settings.learns:
            return self.folds(self.learnt, (1, 0))
        return self.folds(self.layers, self.unseen_halves)

    def learnt(self, x: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """The statistic and the inputs of each half of x (n, k): two arrays of (n / 2, p + k).

        Where the mean of the inputs says all that there is, as on poisson, the statistic by itself says a quarter less.
        """
        inputs = [x[1::2], x[::2]]
        if x.shape[1] > MOST_INPUTS:
            inputs = [half @ weights for half, weights in zip(inputs, self.linear, strict=True)]
        return [np.hstack(parts) for parts in zip(self.statistic.of(x), inputs, strict=True)]

    def contrasts(self) -> list[Contrast]:
        """The halves of all events simulated so far, each with a discriminator and a statistic of the other half."""

        def features(x: NDArray[np.float32]) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
            """What the score and what the discriminator is made of, for the half on which each network is used."""
            p = self.problem.prior.dim
            learnt = [np.hstack([phi, phi[:, p:] ** 2]) if phi.shape[1] <= FEW else phi for phi in self.learnt(x)]
            return [(phi, np.hstack([last, phi])) for phi, last in zip(learnt, self.layers(x), strict=True)]

        observed, simulated = self.real, self.synthetic[: len(self.u)]
        unseen = zip(features(observed), features(simulated), strict=True)
        trained = zip(features(swapped(observed)), features(swapped(simulated)), strict=True)
        contrasts = []
        for half, (real, synthetic), (own_real, own_synthetic) in zip((1, 0), unseen, trained, strict=True):
            phi, psi = zip(real, synthetic, strict=True)
            training = own_real[1], own_synthetic[1]
            contrasts.append(Contrast(phi, psi, training, self.u[half::2], self.u[1 - half :: 2]))
        return contrasts

    def doubt(self, answer: Polished, root: NDArray[np.float64]) -> str:
        """Say why the answer may be wrong, or "": no convergence, no information, or a remaining difference.

        The discriminators' last layers have many more means than there are parameters, and the polish has made no use
        of them: where theta is right they all agree with the observed ones (Hansen's test).
        """
        if doubt := doubt_of(answer, self.problem.prior):
            return doubt
        try:
            misfit = max(fold.misfit(answer.mean, root) for fold in self.folds(self.layers, self.unseen_halves))
        except TooFewEvents:
            return "too few events were simulated near the estimate to test it"
        if misfit < MOST_MISFIT:
            return ""
        return f"events simulated at the estimate differ from the observed ones: chi2/ndf is {misfit:.0f} in place of 1"

    def folds(
        self, phi: Callable[[NDArray[np.float32]], Sequence[NDArray[np.float32]]], halves: tuple[int, int]
    ) -> list[Fold]:
        """Folds of all events by phi, which makes the features of either half of events (n, k), in their order."""
        real, synthetic = phi(self.real), phi(self.synthetic[: len(self.u)])
        return [Fold(*of, self.u[half::2], KNOWN) for *of, half in zip(real, synthetic, halves, strict=True)]

    def layers(self, x: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """What each discriminator's last layer sees of the half of x (n, k) on which it is used, or the inputs."""
        halves = [x[half::2] for half in self.unseen_halves]
        if self.settings.matched == "inputs":  # no network then, as in smm
            return halves
        return [last_layer(network, half) for network, half in zip(self.networks, halves, strict=True)]

    def note(self, mean: NDArray[np.float64], std: NDArray[np.float64]) -> None:
        scale = self.proposal.scale
        self.trace.append(TracePoint(self.problem.simulate.used, self.proposal.to_raw(mean), std * scale))

    def estimate(self, mean: NDArray[np.float64], std: NDArray[np.float64], how: str, comment: str = "") -> Estimate:
        """The estimate from the mean and std (p,) of the proposal, in its coordinates."""
        self.note(mean, std)
        last, message = self.trace[-1], f"{len(self.means) - 1} iterations{comment}"
        return Estimate(
            *(last.theta, how, "proposal", last.theta, last.std, self.trace),
            message=message,
            covariance=np.diag(last.std**2),
        )


class Turn(NamedTuple):
    """An iteration of the adversarial phase. Its rows are those of the simulated events, all even."""

    begin: int
    """The first event simulated in it."""
    end: int
    """The row after the last event simulated in it."""
    learn_from: int
    """The first event that the discriminators may learn from."""
    judge_from: int
    """The first event over which the proposal's gradient is averaged."""
    progress: float
    """Share of the iterations that are done with this one, 1 in the last."""
    learning_rate: float
    """Learning rate of the discriminators."""


def regression(x: NDArray[np.float32], u: NDArray[np.float64]) -> NDArray[np.float32]:
    """Coefficients (k, p) of the linear regression of u (n, p) on x (n, k)."""
    x, u = x - x.mean(axis=0), (u - u.mean(axis=0)).astype(np.float32)
    return np.linalg.pinv(x.T @ x, hermitian=True) @ (x.T @ u)


def swapped(x: NDArray[np.float32]) -> NDArray[np.float32]:
    """Events x (n, k), n even, with the two halves in each other's place."""
    return x.reshape(-1, 2, x.shape[1])[:, ::-1].reshape(x.shape)


def last_layer(network: "torch.nn.Sequential", x: NDArray[np.float32]) -> NDArray[np.float32]:
    """The nodes before the last layer and the inputs beside them: (n, k) -> (n, nodes + k)."""
    import torch

    device = next(network.parameters()).device
    with torch.no_grad():
        parts = torch.from_numpy(x).to(device).split(ROWS_AT_A_TIME)
        return torch.cat([torch.cat([network[:-2](rows), rows], dim=1) for rows in parts]).cpu().numpy()


def even(row: float) -> int:
    """The even row at or before `row`, or 0: even rows are of the first half of the events."""
    return max(0, int(row)) // 2 * 2


def geometric(ends: tuple[float, float], progress: float) -> float:
    """A geometric schedule, from the first end at progress 0 to the other at 1."""
    return ends[0] * (ends[1] / ends[0]) ** progress


@dataclass(frozen=True)
class Avo(Method):
    """AVO tuned to reach the statistical limit within the budget.

    1. The adversarial phase plays Algorithm 1 with a replay buffer: every iteration simulates a few fresh events, and
       both players learn from recent ones too, with importance weights for the proposal having moved since.
    2. The polish simulates nothing. A statistic is learnt from the simulated events, and the proposal's mean follows
       the natural gradient until the means of the statistic and of the inputs agree with the observed ones.
    3. The local phase spends the rest of the budget around that mean, no further from it than its standard error, and
       polishes again: events far away tell how the answer moves, events nearby what it is.

    Where the events leave a combination of parameters open, the last round goes to the best point of all that agree
    with them (`leeway.py`).

    There are two discriminators, each trained on one half of the observed and of the simulated events and used on the
    other: a discriminator knows the events that it was trained on too well, and would bias the answer (cross-fitting).

    All settings of the proposal are in its standardised coordinates (see TruncatedGaussian); a pair of values is the
    first and the last of a geometric schedule.
    """

    name = "avo"
    version = "6"
    packages, extra = ("torch",), "avo"
    by_moments = True
    source = "after G. Louppe, J. Hermans, K. Cranmer, Adversarial Variational Optimization, AISTATS 2019"
    together = True

    iterations: int = 400
    """Number of iterations of the adversarial phase, over which its events are spread evenly."""
    hidden: tuple[int, ...] = (64, 64, 64)
    """Nodes of the discriminator's hidden layers."""
    discriminator_steps: int = 2
    """k, updates of each discriminator per iteration."""
    batch_size: int = 256
    """Observed events, and as many replayed ones, in an update of the discriminator."""
    replay: int = 20_000
    """Number of latest events from which those of the discriminator are drawn."""
    proposal_replay: int = 5_000
    """Number of latest events over which the proposal's gradient is averaged."""
    r1: float = 1.0
    """lambda, coefficient of the gradient penalty R1 on the probability d."""
    entropy: float = 1e-3
    """Coefficient of the bonus on the logarithm of the proposal's standard deviations."""
    learning_rate: tuple[float, float] = (1e-3, 1e-4)
    """Learning rate of Adam for the discriminator."""
    proposal_learning_rate: tuple[float, float] = (0.1, 0.005)
    """Learning rate of Adam for psi = (mean in units of std, log std)."""
    initial_std: float = 1.0
    """Standard deviation at the start, that of the prior. The proposal starts at the prior's mean."""
    wide_share: float = 0.5
    """Share of the events of the adversarial phase that is drawn from the first proposal throughout. Where the proposal
    has gone astray, as it does with ten parameters, the polish finds the way back from them."""
    min_std: float = 0.03
    max_std: float = 0.7
    """Bounds of the proposal's standard deviations; the upper one comes down from `initial_std`."""
    whiten: bool = True
    """Show the discriminator decorrelated features of equal variance, rather than only standardised ones."""
    inputs: Literal["quantiles", "values"] = "quantiles"
    """Show the discriminator each feature on the scale on which the observed events are Gaussian, or as it is. Where
    tails are heavy, or a wide prior makes events far from all observed ones, values would show nothing else."""
    symmetric: bool = True
    """Sum an image over its cyclic axes, along which nothing depends on theta, before the discriminator sees it."""
    cross_fit: bool = True
    """Use each discriminator on the events that the other was trained on, rather than on its own."""
    polish: bool = True
    """Whether to polish the estimate, and to simulate more events around it."""
    matched: Literal["statistic", "layers", "inputs", "divergence"] = "statistic"
    """What the polish matches the mean of: the learnt statistic with the inputs, the discriminators' last layers with
    the inputs, or the inputs alone; with "divergence" it minimises the Jensen-Shannon divergence (`divergence.py`)."""
    statistic_steps: int = 500
    """Updates of the learnt statistic before each polish. On six development targets each, and before the inputs were
    matched beside it, 800 had mean ratios to the floor of 1.9 and 2.1 (`warped-10`, `warped-5`), and 500 of 1.6 and 2.2
    in three quarters of the time."""
    shrink: float = 0.35
    """Least width of a round of the local phase in units of the one before: a first answer may be far off."""
    errors: float = 10.0
    """Least width of a round of the local phase in standard errors of the answer before it."""
    local_share: float = 0.7
    """Share of the budget that is kept for the local phase; without the polish there is none."""
    refine: bool = field(default=True, metadata=LATER)
    """Aim again while the answer moves on, and once it stays learn the statistic from the events that the polish uses,
    without those far off."""
    device: Literal["cpu", "cuda"] = field(default="cpu", metadata=LATER)
    """Where the discriminators are; on another device sums are rounded otherwise, so it is another cell there."""

    def __post_init__(self) -> None:
        counts = (self.iterations, self.discriminator_steps, self.batch_size)
        if min(counts) < 1 or not self.hidden or min(self.hidden) < 1:
            raise ValueError("iterations, steps, batch_size and hidden must be at least 1")
        if min(self.replay, self.proposal_replay) < 2:
            raise ValueError("replay and proposal_replay must be at least 2")
        if min(*self.learning_rate, *self.proposal_learning_rate) <= 0:
            raise ValueError("learning rates must be positive")
        if not 0 < self.min_std <= self.max_std <= self.initial_std:
            raise ValueError("the standard deviations need 0 < min_std <= max_std <= initial_std")
        if min(self.r1, self.entropy) < 0:
            raise ValueError("r1 and entropy must not be negative")
        if not 0 <= self.local_share < 1:
            raise ValueError("local_share must be at least 0 and below 1")
        if self.matched == "divergence" and not self.cross_fit:
            raise ValueError("matched=divergence needs cross_fit=true")
        require_device(self.device)

    @property
    def learns(self) -> bool:
        """Whether a statistic is learnt from the simulated events."""
        return self.matched in ("statistic", "divergence")

    def min_simulations(self, num_parameters: int) -> int:
        """The budget that gives the adversarial phase ten events for each coefficient of the polish's quadratic."""
        coefficients = (num_parameters + 1) * (num_parameters + 2) // 2
        return int(np.ceil(EVENTS_PER_COEFFICIENT * coefficients / (1 - self.local_share)))

    def turns(self, num_events: int) -> Iterator[Turn]:
        """The iterations of the adversarial phase, over which `num_events` events are spread."""
        ends = np.unique([even(end) for end in np.linspace(0, num_events, self.iterations + 1)]).tolist()
        for iteration, (begin, end) in enumerate(pairwise(ends), 1):
            progress = iteration / (len(ends) - 1)
            learn_from, judge_from = even(end - self.replay), even(end - self.proposal_replay)
            yield Turn(begin, end, learn_from, judge_from, progress, geometric(self.learning_rate, progress))

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        return self.infer_together([problem], [rng])[0]

    def infer_together(self, problems: Sequence[Problem], rngs: Sequence[np.random.Generator]) -> list[Estimate]:
        from avobench.methods.stacked_discriminators import StackedDiscriminators, play

        inferences = [Inference(self, problem, rng) for problem, rng in zip(problems, rngs, strict=True)]
        discriminators = StackedDiscriminators(
            [inference.networks for inference in inferences],
            [inference.real for inference in inferences],
            inferences[0].num_adversarial,
            r1=self.r1,
            cross_fit=self.cross_fit,
            device=self.device,
        )
        return play([inference.phases() for inference in inferences], discriminators)
