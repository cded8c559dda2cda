"""The identifiability card: what these data could not have shown, and what it would do to theta unseen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import minimise
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.surrogate import Surrogate, basis
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.schema import Identifiable, Named
from avobench.diagnosis.search.screening import Sample
from avobench.diagnosis.settings import BUDGET, REPORT, TEST
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect


def noncentrality(dof: int, alpha: float) -> float:
    """The noncentrality with which a chi-squared test at level alpha rejects with the power of the card."""
    critical = chi2.isf(alpha, dof)
    return float(brentq(lambda value: ncx2.sf(critical, dof, value) - REPORT.power, 1e-3, 1e4 + 10 * dof))


def card(
    fit: Fit, target: Target, effects: list[Effect], alpha: float, rng: np.random.Generator, effort: Effort
) -> list[Identifiable]:
    """A row for each effect that the model has not, in its plainest shape with middling shape parameters.

    Of several classes of a family that is the first one's. The summary test, at level `alpha`, is that of this fit in
    the metric of its `target`.
    """
    families: dict[tuple, Effect] = {}
    for effect in effects:
        if effect.key not in {one.key for one in fit.model.effects}:
            families.setdefault(effect.key, effect)
    if not families:
        return []
    detection = Detection.of(fit, target, alpha, rng, effort)
    rows, directions = zip(*(detection.row(each, rng) for each in families.values()), strict=True)
    alike = np.array(directions) @ np.array(directions).T > REPORT.rivals
    names = [Named(name=row.name, feature=row.feature) for row in rows]
    rivals = [[name for j, name in enumerate(names) if j != i and alike[i, j]] for i in range(len(rows))]
    return [row.model_copy(update={"rivals": each}) for row, each in zip(rows, rivals, strict=True)]


@dataclass(frozen=True)
class Signal:
    """What an effect of some strength does to the summary, and what is left of that once theta is fitted."""

    whole: float
    """Squared length of the whitened change."""
    kept: float
    """The same of what is left, the noncentrality of the test."""
    noise: float
    """Standard error of `kept` by simulation where nothing is left."""
    error: float
    """The same where as much is left."""
    residual: NDArray[np.float64]
    """What is left, with the noise of simulation (r,)."""
    point: NDArray[np.float64]
    """Where the parameters are then, in the unit cube (P,)."""
    followed: bool
    """Whether that is where the model is known."""


@dataclass(frozen=True)
class Detection:
    """The test of a fitted model, asked which strength of an effect it sees."""

    fit: Fit
    target: Target
    around: Surrogate
    """The model over a wide design around the fit, where its parameters follow what an effect does."""
    need: float
    """The noncentrality that is seen."""
    samples: list[Sample]
    """Events of the fitted model, more of them in each sample."""

    @classmethod
    def of(cls, fit: Fit, target: Target, alpha: float, rng: np.random.Generator, effort: Effort) -> "Detection":
        """Of events of the fitted model there are as many as a test has at its centre, which cost no more of them."""
        measured = max(target.num_events, TEST.few)
        around = fit.reference(target, int(effort.sharpen * measured), rng).surrogate
        most = min(fit.afforded(int(effort.sharpen * measured / 2)), BUDGET.most_events)
        samples = [Sample(fit, target, max(most // part, 1), rng) for part in REPORT.parts]
        need = noncentrality(max(fit.dof, 1), alpha) * (1 + fit.noise)
        return cls(fit, target, around, need, samples)

    def row(self, effect: Effect, rng: np.random.Generator) -> tuple[Identifiable, NDArray[np.float64]]:
        """The row without rivals, and the direction (r,) of what the effect leaves; zero if that is noise.

        The strength is the weakest one that is seen, or that moves theta beyond where the model is known: bisected in
        its logarithm, with the same random numbers at all strengths.
        """
        strength, *shape = effect.parameters
        side = strength.high if strength.high != strength.null else strength.low
        middle = [np.sqrt(p.low * p.high) if p.logarithmic else (p.low + p.high) / 2 for p in shape]
        seed, finished = int(rng.integers(2**63)), self.fit.model.plus(effect).newest_acts_last
        samples = self.samples if finished else self.samples[:-1]  # others ask for new events

        def at(log_share: float, samples: list[Sample] = samples) -> Signal:
            size = strength.null + np.exp(log_share) * (side - strength.null)
            return self.signal(effect, np.array([size, *middle]), samples, seed)

        weak, strong, signal = np.log(REPORT.weakest), 0.0, at(0.0)
        if self.ends(signal):
            for _ in range(REPORT.bisections):
                middling = (weak + strong) / 2
                if self.ends(there := at(middling)):
                    strong, signal = middling, there
                else:
                    weak = middling
        none = np.zeros(self.target.rank)
        if not self.tells(signal) and signal.error > REPORT.unsure * self.need:
            return self._row(effect), none
        row = self._row(effect, signal, float(strength.null + np.exp(strong) * (side - strength.null)))
        plain = at(min(strong + np.log(REPORT.plainer), 0.0), samples[-2:-1])
        if plain.followed and self.detects(plain):
            return row, plain.residual / np.sqrt(plain.kept)
        return row, none

    def ends(self, signal: Signal) -> bool:
        """Whether the test sees a strength, or theta no longer follows it."""
        return self.detects(signal) or not signal.followed

    def detects(self, signal: Signal) -> bool:
        """Whether the test sees a strength, and not the noise of simulation."""
        return signal.kept >= max(self.need, REPORT.shown * signal.noise)

    def tells(self, signal: Signal) -> bool:
        """Whether it is plain that a strength is seen or is not."""
        return abs(signal.kept - self.need) > REPORT.shown * signal.error

    def _row(self, effect: Effect, signal: Signal | None = None, size: float | None = None) -> Identifiable:
        """The row without rivals; with nothing but the name where the simulated events do not tell."""
        model, retained, bias = self.fit.model, None, {}
        if signal is not None:
            if signal.whole > REPORT.shown * signal.noise:
                retained = float(np.clip(signal.kept / signal.whole, 0, 1))
            moved = model.from_cube(signal.point) - model.from_cube(self.around.design.centre)
            bias = dict(zip(model.task.parameter_names, moved.tolist(), strict=False))
        return Identifiable(
            **named(effect.key, model.task.labels).model_dump(),
            retained=retained,
            minimum_detectable=size if signal is not None and self.detects(signal) else None,
            theta_bias=bias,
            theta_bias_at=size,
            rivals=[],
        )

    def signal(self, effect: Effect, phi: NDArray[np.float64], samples: list[Sample], seed: int) -> Signal:
        """What the effect does with parameters phi (q,), by as many events as it takes to tell whether that is seen."""
        for sample in samples:
            events = len(sample.x)
            compared = min(events, REPORT.compared_moves)
            change, scatter = sample.changes(effect, phi[None], events, np.random.default_rng(seed), compared)
            signal = self._after_fit(change[0], float(scatter[0]))
            if self.tells(signal):
                break
        return signal

    def _after_fit(self, change: NDArray[np.float64], scatter: float) -> Signal:
        """What a change (r,) of the mean leaves after a fit; `scatter` is the part of its square by chance."""
        target, s = self.target, self.around
        mean = target.summary.linear(s.coefficients[:1])[0]
        mean = mean + target.cov @ target.whitening @ change / np.sqrt(target.num_events)
        moved = replace(target, mean=mean)
        if self.fit.model.dim:
            fit = minimise(self.fit.model, s, moved)
            point, residual = fit.point, fit.residual
        else:
            point, residual = s.design.centre, change
        t = s.design.to_t(point)
        step = basis(t[None])[0] - basis(np.zeros((1, s.dim)))[0]
        variance = scatter / target.rank + target.num_events * float(step @ s.inverse @ step)
        whole, kept = float(change @ change) - scatter, float(residual @ residual) - variance * self.fit.dof
        noise = np.sqrt(2 * self.fit.dof) * variance
        error = float(np.hypot(noise, 2 * np.sqrt(max(kept, 0) * variance)))
        return Signal(whole, kept, noise, error, residual, point, bool(np.abs(t).max(initial=0) < REPORT.followed))
