"""One inference on a user's own events, from Python as from the command line."""

import html
import json
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.api import agreement
from avobench.api.described import Described, array, description, plain
from avobench.api.joint import Joint, require_measured, tables_in
from avobench.api.progress import Progress, limited, shown
from avobench.bench.cells.budget import MeteredSimulator, asked_of, pose
from avobench.bench.cells.estimates import require_recordable
from avobench.bench.cells.prior_shares import in_shares, raw
from avobench.bench.cells.streams import stream
from avobench.bench.events.checks import NUM_REFERENCE, SHARE, check_events, reference
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder, write_file
from avobench.bench.store.versions import versions
from avobench.effects.pool import Counted
from avobench.methods import Estimate, Method, TracePoint, WeightedSample
from avobench.reports.numbers import in_unit, with_error
from avobench.tables.table import Table, Tables
from avobench.tasks import Task
from avobench.tasks.arguments import checked
from avobench.tasks.contract import twin
from avobench.tasks.errors import BudgetExhausted, InvalidEstimate, UsageError, whole
from avobench.tasks.interpolation import apart
from avobench.tasks.meter import Meter
from avobench.tasks.missing import Recorded
from avobench.tasks.pieces import spread
from avobench.tasks.prior import STEPS, Distributed
from avobench.tasks.region import beside, failing, failures, regions
from avobench.tasks.sample import SampleTask, require_enough

if TYPE_CHECKING:
    from arviz import InferenceData
    from matplotlib.figure import Figure
    from scipy.stats import rv_histogram

    from avobench.diagnosis.fit.fit import Fit
    from avobench.diagnosis.fit.prior import Posterior
    from avobench.diagnosis.schema import GateResult
    from avobench.diagnosis.summary.part import Measured
    from avobench.effects.bank import Bank
    from avobench.effects.model import Model

KIND = "avobench-fit"
"""What the file of a fit says that it is."""
TRIES = 1000
"""So many times more draws than asked for are made of a Gaussian, of which those within the support count."""
AS_PRIOR = 20_000
"""Draws of which a prior is made."""
PAIRED = 2000
"""Draws that the figure of pairs shows."""

VECTORS = ("theta", "mean", "std", "error", "covariance")
"""The arrays of an estimate."""
DOUBTED = 0.001
"""A p-value of the fit of tables or of several data sets below which the answer says that it is doubtful."""
ALL_THERE_ARE = "simulated events that were made before are all there are: leave bank out"
MORE = (8, 4, 2, 1)
"""The efforts of a fit by moments are those of a diagnosis with so many times its limit, until one suffices."""
KEPT = 5
"""One in so many events of the limit is left for the last of them."""
ROOM = 20_000
"""Events for each parameter, on top of the least for the first fit and the tests of a diagnosis, with which fits by
moments of few events ended on development cases."""
REPEATED = 1.1
"""So often the events of a bank may be used on average without a word."""
DEFAULTS = ("avo", "rank-moments")
"""The first of these methods whose packages are installed is the default; `rank-moments` needs none."""


@dataclass(frozen=True, repr=False)
class Inference:
    """What a method found for the parameters of a task behind a set of events; shows itself in a notebook."""

    task: Task
    """The task; without its simulator where the fit was read from a file."""
    method: str
    """The name of the method."""
    estimate: Estimate
    num_events: int | None
    """The number of observed events; None of tables that do not tell it."""
    num_simulations: int
    """The number of simulated events that it took."""
    seconds: float
    seed: int
    warnings: tuple[str, ...] = ()
    """What may be wrong with the events, a sentence each."""
    others: tuple[Mapping[str, float], ...] = ()
    """Other answers by name of the parameter, mirror images of `theta`, at which simulated events agree as well."""
    versions: Mapping[str, Any] = field(default_factory=versions)
    """The versions of Python and of the packages with which it was made."""
    quoted: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    """Value and spread of each parameter, (p,) twice, as a file has them; None where the task tells them."""
    measured: str = ""
    """What was observed, in words, where it is not events alone."""

    @property
    def theta(self) -> dict[str, float]:
        """The best fit by name of the parameter, in raw units."""
        return dict(zip(self.task.parameter_names, self._quoted[0].tolist(), strict=True))

    @property
    def std(self) -> dict[str, float]:
        """The standard errors by name of the parameter where the method knows them, else the spread of `spread_of`."""
        return dict(zip(self.task.parameter_names, self._quoted[1].tolist(), strict=True))

    @property
    def std_of(self) -> str:
        """What `std` is: "standard error", "posterior" or "proposal"."""
        return "standard error" if self.estimate.error is not None else self.estimate.spread_of

    @property
    def doubt(self) -> str:
        """Why the answer should not be trusted as it is, in words; empty where nothing speaks against it."""
        return self.estimate.doubt

    @property
    def _quoted(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Value and spread of each parameter: (p,) twice. An integer is whole."""
        if self.quoted is not None:
            return self.quoted
        estimate = self.estimate
        return self.task.quoted(estimate.theta, estimate.std if estimate.error is None else estimate.error)

    def to_frame(self) -> pd.DataFrame:
        """One row per parameter: value, std, unit, and the ends of its prior."""
        (value, std), prior = self._quoted, self.task.prior
        columns = {"value": value, "std": std, "unit": self.task.parameter_units}
        columns |= {"prior_low": prior.low, "prior_high": prior.high}
        return pd.DataFrame(columns, index=pd.Index(self.task.parameter_names, name="parameter"))

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trace, of plain numbers and texts."""
        return {
            "task": self.task.name,
            "method": self.method,
            "theta": self.theta,
            "std": {name: value if np.isfinite(value) else None for name, value in self.std.items()},
            "std_of": self.std_of,
            "units": dict(zip(self.task.parameter_names, self.task.parameter_units, strict=True)),
            "how": self.estimate.how,
            "message": self.estimate.message,
            "doubt": self.doubt,
            "others": list(map(dict, self.others)),
            "left_open": self.left_open,
            "warnings": list(self.warnings),
            "num_events": self.num_events,
            "measured": self.measured or f"{self.num_events} events",
            "num_simulations": self.num_simulations,
            "seconds": self.seconds,
            "seed": self.seed,
            "versions": dict(self.versions),
        }

    def save(self, path: str | Path) -> Path:
        """Write all of it, as JSON, to a file that `avobench.load` reads.

        Raises UsageError where there is no such folder, StoreError where the disk does not take it.
        """
        path = Path(path)
        require_folder(path.parent, make=False)
        estimate = {each.name: getattr(self.estimate, each.name) for each in fields(Estimate)}
        estimate |= {name: plain(estimate[name]) for name in VECTORS}
        estimate["trace"] = [[int(n), plain(theta), plain(std)] for n, theta, std in self.estimate.trace]
        estimate["sample"] = None if self.estimate.sample is None else list(map(plain, self.estimate.sample))
        estimate["discarded"] = int(self.estimate.discarded)
        content = {"kind": KIND, **self.to_dict(), "described": description(self.task), "estimate": estimate}
        write_file(path, (json.dumps(content, indent=1) + "\n").encode())
        return path

    @classmethod
    def of(cls, content: dict[str, Any]) -> "Inference":
        """The fit that `save` wrote. Raises AttributeError, KeyError, TypeError or ValueError for what is none."""
        arguments = dict(content["estimate"])
        arguments |= {name: array(arguments[name]) for name in VECTORS}
        arguments["trace"] = [TracePoint(n, array(theta), array(std)) for n, theta, std in arguments["trace"]]
        arguments["sample"] = arguments["sample"] and WeightedSample(*map(array, arguments["sample"]))
        task, estimate = Described(content["described"]), Estimate(**arguments)
        if not estimate.theta.shape == estimate.std.shape == (task.prior.dim,):
            raise ValueError("the estimate has another number of parameters")
        names = ("method", "num_events", "num_simulations", "seconds", "seed", "versions")
        kept = {name: content[name] for name in names}
        kept |= {"warnings": tuple(content["warnings"]), "others": tuple(content.get("others", ()))}
        kept["measured"] = content.get("measured", "")
        names = task.parameter_names
        value, std = (np.array([content[what][name] for name in names], float) for what in ("theta", "std"))
        return cls(task, estimate=estimate, quoted=(value, std), **kept)

    @property
    def samples_of(self) -> str:
        """What `samples` draws from: "posterior", "proposal", or "sampling distribution of the estimate"."""
        if self.estimate.sample is not None:
            return "posterior"
        return self.estimate.spread_of if self.estimate.error is None else "sampling distribution of the estimate"

    @property
    def covariance(self) -> pd.DataFrame:
        """The covariance (p, p) of what `samples_of` says, by the names of the parameters.

        It has what was added to `std` when the answer was made whole, or moved to where the simulator works. Raises
        UsageError where the method does not tell how its parameters are correlated.
        """
        estimate, sample = self.estimate, self.estimate.sample
        moved = np.diag((estimate.theta - self._quoted[0]) ** 2)
        if sample is not None:
            away = sample.theta - sample.weights @ sample.theta
            values = (sample.weights * away.T) @ away + moved
        elif estimate.covariance is not None:
            values = estimate.covariance + moved
        elif len(self._quoted[1]) == 1:
            values = self._quoted[1][:, None] ** 2
        else:
            raise UsageError(f"{self.method} does not tell how the errors of the parameters are correlated")
        names = pd.Index(self.task.parameter_names, name="parameter")
        return pd.DataFrame(values, index=names, columns=self.task.parameter_names)

    @property
    def left_open(self) -> list[str]:
        """A sentence for each combination of parameters of which the events tell next to nothing."""
        try:
            covariance = self.covariance.to_numpy()
        except UsageError:
            covariance = np.diag(self._quoted[1] ** 2)
        return agreement.left_open(self.task, self.estimate.theta, covariance)

    def samples(self, n: int = 4000, seed: int = 0) -> pd.DataFrame:
        """Draws (n, p) of the parameters, a column each; `samples_of` says from what.

        Of a posterior they are drawn again from the points that the method has. The sampling distribution of the
        estimate, and a proposal, is a Gaussian with `covariance` within the support. Draws of an integer are whole.
        Raises UsageError where the method does not tell how its parameters are correlated, or no finite spread.
        """
        n, rng, sample = whole("n", n, 1), np.random.default_rng(seed), self.estimate.sample
        if sample is not None:
            draws = sample.theta[rng.choice(len(sample.theta), n, p=sample.weights / sample.weights.sum())]
            draws = self.task.at_whole(draws, rng)  # as its events were made
        else:
            draws = self._gaussian(n, rng)
            draws = np.where(self.task.is_integer, np.rint(draws), draws)
        return pd.DataFrame(draws, columns=self.task.parameter_names)

    def _gaussian(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        estimate, covariance = self.estimate, self.covariance.to_numpy()
        if not np.isfinite(covariance).all():
            raise UsageError(f"{self.method} tells no finite spread of the parameters")
        centre, std = self._quoted[0] if estimate.error is not None else estimate.mean, np.sqrt(np.diag(covariance))
        units = np.outer(std, std)
        correlation = np.divide(covariance, units, out=np.eye(len(std)), where=units > 0)
        draws = np.empty((0, len(std)))
        for _ in range(TRIES):
            new = centre + std * rng.multivariate_normal(np.zeros(len(std)), correlation, n, check_valid="ignore")
            draws = np.concatenate([draws, new[self.task.support.contains(new)]])
            if len(draws) >= n:
                return draws[:n]
        raise UsageError(f"less than one in {TRIES} draws of {self.samples_of} lies within the support")

    def to_inference_data(self, n: int = 4000, seed: int = 0) -> "InferenceData":
        """The draws of `samples` for ArviZ, as one chain of the group `posterior`.

        The attribute `samples_of` says what they are draws of. Raises UsageError as `samples` does, and where no
        ArviZ below version 1 is installed.
        """
        try:
            from arviz import InferenceData, from_dict
        except ImportError as error:
            raise UsageError("to_inference_data needs ArviZ below version 1: pip install 'arviz<1'") from error
        draws = {name: column.to_numpy()[None] for name, column in self.samples(n, seed).items()}
        data: InferenceData = from_dict(draws, attrs={"samples_of": self.samples_of, "method": self.method})
        return data

    def as_prior(self, seed: int = 0) -> dict[str, "rv_histogram"]:
        """What is known of each parameter now, as the prior of a task that new events are fitted with.

        It is what `samples` draws from, smoothed where a method has few points of it; correlations are left out. A task
        made with it has the support of this one where no other is given, since it takes events beyond a prior to tell
        what new ones say. Raises UsageError as `samples` does, and for integers, whose prior must be one of whole
        numbers.
        """
        from scipy.stats import rv_histogram

        if self.task.is_integer.any():
            raise UsageError("as_prior is for real numbers; give an integer a prior such as scipy.stats.randint")
        draws, sample = self.samples(AS_PRIOR, seed).to_numpy(), self.estimate.sample
        if sample is not None:  # a kernel density by Scott's rule
            width = (sample.weights.sum() ** 2 / (sample.weights**2).sum()) ** (-1 / (draws.shape[1] + 4))
            draws = draws + width * draws.std(axis=0) * np.random.default_rng(seed).normal(size=draws.shape)
            draws = draws[self.task.support.contains(draws)]
        shares = np.linspace(0, 1, STEPS + 1)
        of_each = zip(self.task.parameter_names, np.quantile(draws, shares, axis=0).T, strict=True)
        prior = {name: rv_histogram((np.ones(STEPS), edges), density=False) for name, edges in of_each}
        support = self.task.support
        for law, *ends in zip(prior.values(), support.low, support.high, strict=True):
            law.within = tuple(ends)
        return prior

    def plot(self, name: str = "trace") -> "Figure":
        """The figure "trace" or "pairs".

        The first is the estimate of each parameter against the number of simulated events: one band is the spread that
        the method had at that point, the other the error that is quoted. The second shows the draws of `samples`, each
        parameter and each pair. Raises UsageError for another name.
        """
        from avobench.reports import fits

        if name == "trace":
            return fits.draw(self.task, self.estimate, self._quoted[1], self.std_of)
        if name == "pairs":
            return fits.pairs(self.samples(PAIRED), self.samples_of)
        raise UsageError(f"there is no figure '{name}'; a fit has trace, pairs")

    def __str__(self) -> str:
        """A line for each parameter, a doubt where there is one, other answers, and what the fit took."""
        rows = zip(self.theta.items(), self._quoted[1], self.task.parameter_units, self.task.is_integer, strict=True)
        lines = [
            f"{name} = {f'{value:.0f} ± {std:.2g}' if whole else with_error(value, std)}{in_unit(unit)}"
            for (name, value), std, unit, whole in rows
        ]
        doubt = [f"doubtful: {self.doubt}"] if self.doubt else []
        notes = [f"note: {note}" for note in (*self.left_open, *self.warnings, self.estimate.message) if note]
        return "\n".join([*lines, *doubt, *self._as_well, self.how, *notes])

    @property
    def _as_well(self) -> list[str]:
        return [
            "as good: " + ", ".join(f"{name} = {value:.4g}" for name, value in other.items()) for other in self.others
        ]

    @property
    def how(self) -> str:
        """A line that says how the numbers came about."""
        return (
            f"{self.method} on {self.measured or f'{self.num_events} events'}: {self.estimate.how} ± {self.std_of}; "
            f"{self.num_simulations} simulated events, {self.seconds:.1f} s"
        )

    __repr__ = __str__  # what a prompt shows; of all fields it would be pages

    def _repr_html_(self) -> str:
        table = self.to_frame().to_html(float_format=lambda value: f"{value:.5g}", border=0)
        doubt = f"<p><strong>doubtful</strong>: {html.escape(self.doubt)}</p>" if self.doubt else ""
        more = "".join(f"<p>{html.escape(line)}</p>" for line in (*self._as_well, *self.left_open))
        return f"<p>{html.escape(f'{self.task.name}, {self.how}')}</p>{doubt}{table}{more}"


@checked
@limited
def infer(
    task: Task | str | Joint,
    x: ArrayLike | Table | Tables | Sequence[Table] | None = None,
    method: Method | str | None = None,
    *,
    budget: int = 160_000,
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    drop_invalid: bool = False,
    progress: Progress | bool | None = None,
    bank: str | Path | None = None,
    jobs: int | None = None,
    seconds: float | None = None,
) -> Inference:
    """Infer the parameters of a task behind observed events, in this process unless `seconds` is given.

    Parameters
    ----------
    task
        A task, or its name, `module:Class`, `path/to/file.py:Class`, or the path of a model.json; or several data sets
        with what was measured, by `avobench.joint`, without `x`; or simulated events of `avobench.bank`.
    x
        Observed events (N, d), or (N,) where an event is one number; or published tables. Of tables, of several data
        sets, and from events that were simulated before, theta is found by `smm`: from means of summaries, by the fit
        with which a diagnosis begins. From events that were simulated before also `npe`, `nle` and `nre` find it, and
        "abc", which is rejection by sets of these events with a regression adjustment.
    method
        A method, or its name, such as "avo", "abc-smc" or "bolfi". By default it is `avo` where PyTorch is
        installed, and otherwise `rank-moments`, which needs no more than the base install.
    budget
        Simulated events, at most; of `avobench.bank` all that there are. A twentieth of them at most goes into a check
        of events and simulator, and a tenth is held back: fresh events at the estimate are compared with the observed
        ones, and at its mirror images.
    seed
        Of all that is random. The same seed gives the same estimate.
    settings
        Of the method, where it is given by name.
    drop_invalid
        Leave out rows that hold NaN or infinite values.
    progress
        Is told now and then the method, the simulated events so far, and the budget. By default a bar on a terminal, or
        a line in a notebook, shows them; False shows nothing.
    jobs
        Processes that make events, for a simulator that takes its time; the method itself works in one. By default the
        simulator runs in this process. With `jobs` each piece of a request has a random stream of its own: the estimate
        is another one then, and the same for any number of them.
    seconds
        Works in a process of its own, with one thread, and ends it after so long; the task is sent there. `progress`
        is called there too, so a notebook shows none.
    bank
        Folder of simulated events that a diagnosis or a fit kept, which are used before any is made, and into which
        those that are made come. `smm`, the default then, uses all near its fit. Other methods use those at the same
        thetas: `npe`, `nle` and `nre` draw these from the prior, the same ones for any data.

    Raises
    ------
    UsageError
        If there is no such task or method, if the events are not those of the task, or the budget is too small.
    SimulatorError
        If the simulator fails; SupportError, BudgetExhausted or InvalidEstimate if the method does.
    ProcessEnded
        If the process took longer than `seconds`, or was ended by what it ran.
    """
    budget, seed = whole("budget", budget, 1), whole("seed", seed, 0)
    jobs = None if jobs is None else whole("jobs", jobs, 1)
    require_measured(task, x)
    by_moments = method in (None, "smm") and not settings
    task = task if isinstance(task, Joint) else registry.task_of(task)
    sample = isinstance(task, SampleTask)
    if sample and not task.prior.dim:
        what = "say at which each event was made, by `theta` or --theta-columns, or use diagnose"
        raise UsageError(f"there is no theta to infer: {what}")
    several = isinstance(task, Joint) or tables_in(x) is not None
    if several and not by_moments:
        what = "tables and several data sets"
        raise UsageError(f"{what} are fitted by smm, without settings: leave method and settings out")
    # The lines through the whole prior, which smm has elsewhere, bend where a simulator begins to fail.
    if by_moments and (several or task.missing or sample or bank is not None or (failing(task) and method == "smm")):
        return moments(task, x, budget, seed, drop_invalid, progress, bank, jobs)
    if sample and bank is not None:
        raise UsageError(ALL_THERE_ARE)
    if method == "abc":
        if not sample or settings:
            raise UsageError("abc is for avobench.bank, without settings; of a simulator take abc-smc")
        return by_rejection(task, x, seed, drop_invalid, progress)
    if method is None:
        method = next(name for name in DEFAULTS if registry.missing_package(registry.load("method", name)) is None)
    if isinstance(method, str):
        method = registry.build("method", method, dict(settings or {}))
    elif settings:
        raise UsageError("settings are for a method given by name; give them to the class otherwise")
    for kind, subject in (("task", task), ("method", method)):
        registry.require_packages(kind, subject)
    if sample and not method.from_prior:
        raise UsageError(f"{method.name} needs events at thetas of its own; of a bank take smm, abc, npe, nle or nre")
    return by_method(task, x, method, budget, seed, drop_invalid, progress, bank, jobs)


def by_method(
    task: Task,
    x: Any,
    method: Method,
    budget: int,
    seed: int,
    drop_invalid: bool,
    progress: Progress | bool | None,
    folder: str | Path | None,
    jobs: int | None,
) -> Inference:
    """Infer theta from events x by a method, with events of a `folder`, or of a sample, where there is one."""
    sample = isinstance(task, SampleTask)
    before = beside(task)
    source: Bank | Counted = Counted(task if sample else spread(task, jobs))
    if sample or folder is not None:
        from avobench.diagnosis.checks import bank_of

        source = bank_of(task, Meter(), seed, jobs or 1, folder and Path(folder))
        budget = min(budget, int(task.sizes.sum())) if sample else budget
    least = method.min_simulations(task.prior.dim)
    if budget < least:
        raise UsageError(f"a budget of {budget} is too small for {method.name} on {task.name}: at least {least}")
    checks = Counted(drawing(task, source))
    made = partial(reference, task, checks, min(budget // SHARE, budget - least))
    x_observed, warnings = check_events(
        task, x, drop_invalid=drop_invalid, diagnosis=False, made=(lambda: task.events) if sample else made
    )
    start = time.perf_counter()
    words, drawn = (task.name, method.name), drawing(task, source)
    recorded = Recorded(task, x_observed)
    x_observed = recorded.events(x_observed)
    posed = in_shares(recorded.task(drawn), method)
    remaining, asked = budget - checks.meter.used, most_asked(task, method, budget, checks.meter)
    with shown(progress) as tell:

        def metered(what: str, task: Task, limit: int, reserve: int, before: int) -> MeteredSimulator:
            """A simulator of `limit` events with a stream of its own, `before` which so many were made."""

            def report(used: int) -> None:
                tell(method.name, before + used, budget)

            return MeteredSimulator(task, limit, stream(seed, what, *words), progress=report, reserve=reserve)

        # Events that are made in place of failed ones come out of what the test has, where more fail than expected.
        simulate = metered("simulator", posed, asked, remaining - asked, checks.meter.used)
        problem = pose(posed, x_observed, simulate)
        estimate = method.infer(problem, stream(seed, "method", *words))
        require_recordable(estimate, problem, simulate.used)
        estimate = with_shift(restricted(raw(estimate, posed), task), task)
        fresh, rng = recorded.task(drawing(task, source, aside=True)), stream(seed, "test", *words)
        held = remaining - max(simulate.used, asked)
        held = min(held, task.num_aside * 3 // 2) if sample else held
        tests = asked_of(task, held, checks.meter)
        test = metered("agreement", fresh, tests, held - tests, checks.meter.used + simulate.used)
        estimate, others = compare_with_fresh(recorded.task(task), estimate, x_observed, test, simulate.used, rng)
    seconds = time.perf_counter() - start
    if isinstance(source, Counted):
        used = sum(each.used - each.failed for each in (checks.meter, simulate, test))
    else:
        used = source.meter.used - source.meter.failed
    used += beside(task) - before
    if sample and (repeats := drawn.simulate.repeats) > REPEATED:
        warnings.append(f"the events of the bank were used {repeats:.2g} times each, so that errors are too small")
    warnings += failures(task, estimate.theta, estimate.std if estimate.error is None else estimate.error)
    return Inference(task, method.name, estimate, len(x_observed), used, seconds, seed, tuple(warnings), others)


def most_asked(task: Task, method: Method, budget: int, checks: Meter) -> int:
    """How many events a method may ask for of a budget of which the `checks` have spent a part.

    A tenth of the budget is held back for the test of the answer, and what is made in place of failed events takes of
    that too. Raises UsageError where too few are left for the method.
    """
    least, remaining = method.min_simulations(task.prior.dim), budget - checks.used
    held = min(budget // agreement.SHARE, remaining - least)
    if (most := asked_of(task, remaining, checks)) < least:
        raise UsageError(
            f"a budget of {budget} is too small for {method.name} on {task.name}, whose events fail and are made "
            f"again: allow {int(1.2 * budget * least / max(most, 1)) + 1}"
        )
    return max(asked_of(task, remaining - held, checks), least)


def doubted(estimate: Estimate, doubt: str) -> Estimate:
    """The estimate with one more doubt."""
    return replace(estimate, doubt="; ".join(filter(None, (estimate.doubt, doubt))))


def with_shift(estimate: Estimate, task: Task) -> Estimate:
    """The estimate with what a bank of few thetas may shift it by, in its errors, and as a doubt where that is more."""
    std = estimate.std if estimate.error is None else estimate.error
    moved, doubt = apart(task, estimate.theta, std)
    estimate = doubted(estimate, doubt)
    if estimate.error is None:
        return estimate
    covariance = None if estimate.covariance is None else estimate.covariance + np.outer(moved, moved)
    return replace(estimate, error=np.hypot(std, moved), covariance=covariance)


def by_rejection(
    task: SampleTask, x: Any, seed: int, drop_invalid: bool, progress: Progress | bool | None
) -> Inference:
    """Infer theta behind events x by ABC with sets of the events of a sample. Raises UsageError."""
    from avobench.effects.bank import Given
    from avobench.methods.rejection import ROUNDS, SETS, rejection

    x_observed, warnings = check_events(task, x, drop_invalid=drop_invalid, diagnosis=False, made=lambda: task.events)
    start, words, recorded = time.perf_counter(), (task.name, "abc"), Recorded(task, x_observed)
    num, sets = len(task.events), ROUNDS * SETS
    x_observed, posed = recorded.events(x_observed), recorded.task(task)
    with shown(progress) as tell:
        rng = stream(seed, "method", *words)
        estimate = rejection(task, posed, x_observed, rng, lambda made: tell("abc", num * made // sets, num))
    estimate = with_shift(estimate, task)
    aside = recorded.task(drawing(task, Given(task, Meter()), aside=True))
    test = MeteredSimulator(aside, task.num_aside * 3 // 2, stream(seed, "agreement", *words))
    estimate, others = compare_with_fresh(posed, estimate, x_observed, test, num, stream(seed, "test", *words))
    seconds = time.perf_counter() - start
    return Inference(task, "abc", estimate, len(x_observed), num, seconds, seed, tuple(warnings), others)


def drawing(task: Task, source: "Bank | Counted", aside: bool = False) -> Task:
    """A twin of a task whose events are those of its source: of a bank each once, or those that it keeps aside."""
    if isinstance(source, Counted):
        return source.task
    return twin(task, simulate=source.fresh if aside else source.session())


def restricted(estimate: Estimate, task: Task) -> Estimate:
    """The estimate without what a posterior has outside of the region where the simulator of a task works.

    Events were made at its edge there. Without these thetas it is the posterior of the prior within the region.
    """
    sample, learnt_regions = estimate.sample, regions(task)
    if sample is None or not learnt_regions:
        return estimate
    weights = sample.weights * np.all([region.contains(sample.theta) for region in learnt_regions], axis=0)
    if not weights.sum() > 0:
        raise InvalidEstimate(f"the posterior lies where the simulator of {task.name} fails: widen the prior")
    weights = weights / weights.sum()
    mean = weights @ sample.theta
    std = np.sqrt(weights @ (sample.theta - mean) ** 2)
    theta = estimate.theta if learnt_regions[0].contains(estimate.theta[None])[0] else mean
    return replace(estimate, theta=theta, mean=mean, std=std, sample=WeightedSample(sample.theta, weights))


def compare_with_fresh(
    task: Task,
    estimate: Estimate,
    x_observed: NDArray,
    simulate: MeteredSimulator,
    num_fitted: int,
    rng: np.random.Generator,
) -> tuple[Estimate, tuple[dict[str, float], ...]]:
    """The estimate with a doubt where fresh events at it differ from the observed ones, and what else fits as well.

    Two thirds of the budget of `simulate` are spent at the estimate, and the rest at its mirror images.
    """
    theta, error = task.quoted(estimate.theta, estimate.std if estimate.error is None else estimate.error)
    num = simulate.budget - simulate.budget // 3
    doubt = agreement.doubt_of(task, theta, x_observed, simulate, num, rng)
    if doubt:
        return doubted(estimate, doubt), ()
    others = agreement.as_good(task, theta, error, x_observed, simulate, simulate.remaining, num_fitted, rng)
    return estimate, tuple(dict(zip(task.parameter_names, other.tolist(), strict=True)) for other in others)


def by_effort(
    model: "Model", part: Any, meter: Meter, rng: np.random.Generator
) -> tuple["GateResult", "Fit", "Posterior | None"]:
    """The test and the fit of a model to what was measured, with as much effort as the meter allows.

    The third is what the fit and a prior that is not uniform say together, where that can be told.

    Where the fit does not describe what was measured, theta is looked for again, as far as simulated events allow.

    That of a diagnosis leaves room for a search, which is not asked for here. So those of some times the limit are
    tried first, and then the least. What one has simulated the next one uses. Raises UsageError where even the least is
    too much, with a number of simulated events for each set of events that suffices.
    """
    from avobench.diagnosis.effort import effort_for, first_fit_events, full_effort
    from avobench.diagnosis.fit.descent import refine
    from avobench.diagnosis.fit.null import best_null, fit_null
    from avobench.diagnosis.fit.prior import with_prior
    from avobench.diagnosis.goodness_of_fit.gates import summary_gate
    from avobench.effects.catalogue import domain

    spent, task = meter.used, model.task
    least = full_effort(task, domain(task), len(part)).scaled(0)
    needed = first_fit_events(least, task, len(part)) + spent
    limits = [more * meter.limit for more in MORE if more * meter.limit >= needed] if meter.limit else [None]
    efforts = [effort_for(task, domain(task), limit, len(part), spent) for limit in limits]
    efforts += [] if limits[-1:] in ([None], [meter.limit]) else [least]
    for effort in efforts:
        again = deepcopy(rng)
        try:
            with meter.keeping(0 if effort is efforts[-1] or meter.limit is None else meter.limit // KEPT):
                fit, target = fit_null(model, part, again, effort, None)
                gate, fit = summary_gate(fit, target, again, effort)[:2]
        except BudgetExhausted:
            continue
        break
    else:
        calls = max(len(task.tasks), 1)  # of several data sets, an event of each
        given, enough = calls * meter.limit, calls * max(2 * meter.limit, needed + ROOM * task.prior.dim)
        raise UsageError(f"{given} simulated events are too few for a fit by smm; allow {enough}")
    if gate.p_value < DOUBTED:  # a theta that is missed looks like a disagreement
        with suppress(BudgetExhausted):
            second = summary_gate(best_null([fit], target, again, effort.sure), target, again, effort)[:2]
            gate, fit = max((gate, fit), second, key=lambda each: each[0].p_value)
    if not isinstance(task.prior, Distributed):
        return gate, fit, None
    num_events = max(effort.least, int(effort.rounds * len(part)))

    def repeated(start: NDArray[np.float64]) -> "Fit":
        refined = refine(model, target, start, 0.005, again, num_events=num_events)
        return summary_gate(refined, target, again, effort)[1]

    return gate, fit, with_prior(fit, task.prior, repeated)


def moments(
    task: Task | Joint,
    x: Any,
    budget: int,
    seed: int,
    drop_invalid: bool,
    progress: Progress | bool | None,
    folder: str | Path | None,
    jobs: int | None,
) -> Inference:
    """Infer theta from events or tables x, or several data sets, by the means of their summaries. Raises UsageError."""
    from avobench.diagnosis.checks import Checks
    from avobench.effects.bank import Bank
    from avobench.effects.model import Model

    start, tables = time.perf_counter(), tables_in(x)
    joint, task = (task, task.task) if isinstance(task, Joint) else (None, task)
    before, sample, calls = beside(task), isinstance(task, SampleTask), len(joint.sets) if joint else 1
    if sample and folder is not None:
        raise UsageError(ALL_THERE_ARE)
    size = NUM_REFERENCE if joint or tables or not hasattr(x, "__len__") else len(x)
    limit = None if sample else budget // calls
    checks = Checks(task, size, limit, seed=seed, jobs=jobs or 1, folder=folder and Path(folder))
    if joint:
        part, warnings = checks.joint(joint.sets, drop_invalid=drop_invalid)
    else:
        part, warnings = (checks.tables(tables), []) if tables else checks.events(x, drop_invalid=drop_invalid)
    parts = part.sets if joint else (part,)
    meter = checks.bank.meter
    with shown(progress) as tell:
        meter.progress = lambda used: tell("smm", calls * used, budget)
        source = checks.bank if isinstance(checks.bank, Bank) else Bank(task, meter, seed)
        gate, fit, posterior = by_effort(
            Model(task, events=source), part, meter, stream(seed, "method", task.name, "smm")
        )
    require_enough(task, fit.params, sum(map(len, parts)))
    theta, std, width = fit.params, fit.std, task.support.width
    covariance = fit.point_covariance * np.outer(width, width)
    if posterior:
        (theta, covariance), std = posterior, np.sqrt(np.diag(posterior.covariance))
    elif isinstance(task.prior, Distributed):
        names = ", ".join(one for one, law in zip(task.parameter_names, task.prior.laws, strict=True) if law)
        warnings.append(
            f"the prior of {names} counts by its ends alone, as theta moves too far with it for what the fit knows: "
            "allow more simulated events, or fit one set of events without bank by avo or abc-smc"
        )
    doubt = f"the fit and what was measured disagree: p = {gate.p_value:.2g}" if gate.p_value < DOUBTED else ""
    if fit.undecided and not doubt:  # its slopes do not stand out of the noise of simulation
        doubt = "too few simulated events to tell how well theta is known: errors may be far too large"
    how = f"where the means of the summaries agree, chi-squared {gate.statistic:.1f}, dof {gate.dof}"
    used = calls * (meter.used - meter.failed) + beside(task) - before
    trace = [TracePoint(used, theta, std)]
    warnings += failures(task, theta, std)
    estimate = Estimate(theta, how, "proposal", theta, std, trace, error=std, covariance=covariance, doubt=doubt)
    estimate = with_shift(estimate, task)
    seconds = time.perf_counter() - start
    num_events, measured = count_and_words(parts)
    return Inference(task, "smm", estimate, num_events, used, seconds, seed, tuple(warnings), measured=measured)


def count_and_words(parts: "Sequence[Measured]") -> tuple[int | None, str]:
    """How many events were measured, if each part tells it, and what it is in words."""
    from avobench.diagnosis.summary.published import TablePart

    tables = [part.tables for part in parts if isinstance(part, TablePart)]
    alone = sum(len(part) for part in parts if not isinstance(part, TablePart))
    numbers = [each.num_events for each in tables]
    of_tables = None if None in numbers else sum(numbers)
    words = [f"{alone} events"] * (len(tables) < len(parts))
    if number := sum(len(each.tables) for each in tables):
        size = "" if of_tables is None else f" ({of_tables} events)"
        bins = sum(len(each.values) for each in tables)
        words.append(f"{number} table{'s' * (number > 1)} of {bins} bin{'s' * (bins > 1)}{size}")
    return None if of_tables is None else alone + of_tables, ", ".join(words)
