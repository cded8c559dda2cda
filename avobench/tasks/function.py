"""A task from a plain function, for whoever has a simulator and wants an answer."""

import math
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy, deepcopy
from functools import cached_property
from traceback import walk_tb
from typing import Any, get_args
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.arguments import box_of, checked, distinct
from avobench.tasks.contract import NAME, Box, Kind, ParameterKind, Task, histogram
from avobench.tasks.errors import SimulatorError, UsageError, raised, shown
from avobench.tasks.prior import Distributed, Ends
from avobench.tasks.region import FAILURES, Failed, Region
from avobench.tasks.weights import chosen, named

Simulate = Callable[[NDArray[np.float64], np.random.Generator], ArrayLike]
"""theta (n, p), a generator -> one event per row: (n, d), or (n,) where an event is one number."""

NUM_BINS = 20
"""Bins of each feature in the summary, as many as the benchmark's weinberg task has."""
FIRST = 50
"""So often a simulator that may fail is tried until it makes its first events."""
QUICK = 1.0
"""A simulator that takes fewer seconds for its first events is asked for them again by the same generator."""
NUM_REFERENCE = 4000
"""Events over the prior from which the bins of the summary are taken: 200 a bin."""


class FunctionTask(Task):
    """A task whose simulator is a function; made by `task`."""

    source = "a function of the user's own"
    reference: NDArray | None = None
    """Events (n, d) by which the summary is binned."""
    repeats: bool = True
    """Whether it makes the same events of the same generator, as far as a quick one was asked."""

    def __init__(
        self,
        function: Simulate,
        name: str,
        prior: Mapping[str, Ends],
        support: Mapping[str, tuple[float, float]],
        units: Mapping[str, str],
        feature_names: Sequence[str],
        kinds: Mapping[str, Kind | ParameterKind],
        feature_units: Mapping[str, str],
        per_theta: bool,
        failed: Failed,
        missing: Sequence[str],
    ) -> None:
        self.function, self.name, self.per_theta, self.failed = function, name, per_theta, failed
        self.feature_names = tuple(feature_names)
        self.parameter_names = tuple(prior)
        self.parameter_units = tuple(units.get(parameter, "1") for parameter in prior)
        prior_kinds = {name: kind for name, kind in kinds.items() if name in prior and kind in get_args(ParameterKind)}
        self.prior = box_of(prior, [name for name, kind in prior_kinds.items() if kind == "integer"])
        both = zip(prior.items(), self.prior.low, self.prior.high, strict=True)
        ends = {name: getattr(given, "within", (low, high)) for (name, given), low, high in both}
        self.support = Box(*zip(*(support.get(parameter, ends[parameter]) for parameter in prior), strict=True))
        if not self.support.contains_all(np.array([self.prior.low, self.prior.high])):
            raise ValueError(f"the support of {name} must hold its prior")
        kinds = {name: kind for name, kind in kinds.items() if name not in prior_kinds}
        if "integer" in prior_kinds.values():
            self.parameter_kinds = tuple(prior_kinds.get(parameter, "continuous") for parameter in prior)
            ends = np.array([self.prior.low, self.prior.high, self.support.low, self.support.high])
            broken = (ends != np.rint(ends)).any(axis=0) & self.is_integer
            if broken.any():
                name = self.parameter_names[broken.argmax()]
                raise ValueError(f"{name} is an integer, so its prior and its support must end at whole numbers")
        # Another number of rows than of parameters, so that none is taken for one.
        x = self._first(self.prior.dim + 1, may_lack=bool(missing))
        self.num_features, self.dtype = x.shape[1], x.dtype
        if feature_names and len(feature_names) != self.num_features:
            raise ValueError(f"an event has {self.num_features} features, {len(feature_names)} names were given")
        self.missing = tuple(self.labels.index(name) for name in missing if name in self.labels)
        if missing and self.dtype.kind != "f":
            raise ValueError("a value that is missing is NaN, which whole numbers do not have: return them as floats")
        for given, what in ((kinds, "kinds"), (feature_units, "feature_units"), (missing, "missing")):
            if unknown := [feature for feature in given if feature not in self.labels]:
                raise ValueError(f"{what} names '{unknown[0]}'; the features are {', '.join(self.labels)}")
        if feature_units:
            self.feature_units = tuple(feature_units.get(feature, "1") for feature in self.labels)
        if kinds:
            if wrong := [kind for kind in kinds.values() if kind not in get_args(Kind)]:
                raise ValueError(f"a feature is one of {', '.join(get_args(Kind))}, not {wrong[0]}")
            plain = dict(zip(self.labels, self.kinds_of_features, strict=True))
            self.feature_kinds = tuple((plain | dict(kinds)).values())
            counts = set(self.feature_kinds) == {"count"} and not missing
            self.dtype = np.dtype(np.int64 if counts else np.float64)
            self._of_their_kinds(x)

    @property
    def parts(self) -> tuple[object, ...]:
        """The function, and what was declared about its parameters and events."""
        declared = (self.prior, self.support, self.parameter_names, self.parameter_units, self.feature_names)
        if self.feature_kinds or self.feature_units:
            declared += (self.feature_kinds, self.feature_units)
        if self.parameter_kinds:
            declared += (self.parameter_kinds,)
        if self.per_theta:
            declared += ("per theta",)
        if self.failed != "raise":
            declared += (self.failed,)
        if self.missing:
            declared += (f"missing {self.missing}",)
        return (self.function, repr(declared))

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of `task`, beside the function, that make this task again: of plain numbers, texts and laws."""
        prior, support = (
            dict(zip(self.parameter_names, zip(box.low, box.high, strict=True), strict=True))
            for box in (self.prior, self.support)
        )
        if isinstance(self.prior, Distributed):
            prior |= {name: law for name, law in zip(prior, self.prior.laws, strict=True) if law is not None}
        arguments = {"prior": prior, "support": support, "units": dict(zip(prior, self.parameter_units, strict=True))}
        arguments |= {"features": self.feature_names, "name": self.name}
        kinds = dict(zip(self.labels, self.feature_kinds, strict=bool(self.feature_kinds)))
        kinds |= dict(zip(self.parameter_names, self.parameter_kinds, strict=bool(self.parameter_kinds)))
        units = dict(zip(self.labels, self.feature_units, strict=bool(self.feature_units)))
        arguments |= {"missing": tuple(self.labels[j] for j in self.missing)} if self.missing else {}
        return arguments | {"kinds": kinds, "feature_units": units, "per_theta": self.per_theta, "failed": self.failed}

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row: theta (n, p) -> (n, d). Raises ValueError outside the support."""
        self.require_support(theta)
        x = self._events(theta, rng) if self.region is None else self.region.simulate(theta, rng)
        return self._of_their_kinds(x) if self.feature_kinds else x

    @cached_property
    def region(self) -> Region | None:
        """Where the simulator works, learnt when it is first asked for; None where it may not fail."""
        return None if self.failed == "raise" else self.region_of(None)

    def region_of(self, learnt: Mapping[str, Any] | None) -> Region:
        """The region as it was `learnt` before, see `Region.learnt`; None tries the simulator."""
        return Region(self, self._events, self.per_theta, learnt)

    def quoted(
        self, theta: NDArray[np.float64], error: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As of any task; and theta outside of the region is quoted at its edge, where its events were made."""
        if self.region is not None:
            within = self.region.within(np.atleast_2d(theta)).reshape(theta.shape)
            theta, error = within, np.hypot(error, theta - within)
        return super().quoted(theta, error)

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """Shares of the events in bins of each feature: (n, d) -> (k,).

        The bins hold equal shares of the reference events, or over the prior where there are none.
        """
        return np.concatenate([histogram(x[:, [j]], edges, overflow=True) for j, edges in enumerate(self._edges)])

    def _first(self, n: int, may_lack: bool) -> NDArray:
        """A few events at the centre of the prior; where they may fail, of the first theta drawn that makes some."""
        rng = np.random.default_rng(0)
        theta = np.vstack([self.prior.center, self.prior.sample(FIRST, rng)])
        for k, one in enumerate(super().quoted(theta, np.zeros_like(theta))[0]):
            began, given = time.monotonic(), deepcopy(rng)
            try:
                x = self._events(np.tile(one, (n, 1)), rng)
                if time.monotonic() - began < QUICK:
                    self.repeats = np.array_equal(x, self._events(np.tile(one, (n, 1)), given), equal_nan=True)
            except FAILURES:
                if self.failed == "raise" or k == FIRST:
                    raise
            else:
                if self.failed == "raise" or may_lack or np.isfinite(x).all():
                    return x
        raise ValueError(f"it made no finite events at {FIRST + 1} thetas of its prior")

    def _events(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        if self.per_theta:
            nodes, which, counts = np.unique(theta, axis=0, return_inverse=True, return_counts=True)
            calls = zip(nodes, counts.tolist(), strict=True)
            x = np.concatenate([self._array(self.function(node, n, rng), n) for node, n in calls])
            return x[np.argsort(np.argsort(which, kind="stable"))]
        return self._array(self.function(theta, rng), len(theta))

    def _array(self, x: ArrayLike, n: int) -> NDArray:
        """What the function returned as n events (n, d), copied. Raises ValueError for what are no numbers.

        Raises SimulatorError for another number of events, and UsageError for a table without a column of a feature.
        """
        if np.ma.is_masked(x):
            raise ValueError("it returned masked values, which are no events")
        if hasattr(x, "columns"):
            # The first table names the features, so that measured columns in another order are found by name.
            self.feature_names = self.feature_names or named(x)
            x = chosen(x, self.feature_names)
        made = np.asarray(x)
        if made.dtype.kind == "c":
            raise ValueError("it returned complex numbers; return their real part, or both parts as features")
        if made.ndim not in (1, 2) or len(made) != n:
            got, p = f"events of shape {made.shape}" if made.ndim else shown(x), self.prior.dim
            due, first = f"theta of shape ({n}, {p}); return an event for each row", "theta[:, 0]"
            if self.per_theta:
                due, first = f"one theta of shape ({p},) and n = {n}; return n events", "theta[0]"
            raise SimulatorError(
                f"the function of {self.name} returned {got} for {due}, as ({n},) or ({n}, d), where {first} is the "
                "first parameter"
            )
        made = made[:, None] if made.ndim == 1 else made
        return made.astype(np.int64 if made.dtype.kind in "bui" else np.float64)

    def _of_their_kinds(self, x: NDArray) -> NDArray:
        """Events (n, d) in the type of the task. Raises ValueError for a count that is none."""
        counts = x[:, [kind == "count" for kind in self.feature_kinds]]
        broken = ((counts < 0) | (counts != np.rint(counts))) & ~np.isnan(counts)
        if broken.any():
            wrong = counts[broken][0]
            raise ValueError(f"{self.name} makes {wrong:g} where its kinds promise a count")
        return x.astype(self.dtype, copy=False)

    def with_reference(self, x: NDArray) -> "FunctionTask":
        """This task with bins of the summary that hold equal shares of events x (n, d), so that none is simulated."""
        twin = copy(self)
        twin.reference = x
        twin.__dict__.pop("_edges", None)
        return twin

    @cached_property
    def _edges(self) -> list[NDArray[np.float64]]:
        """The edges of the bins of each feature."""
        rng = np.random.default_rng(0)
        x = self.reference
        if x is None:
            x = self.simulate(self.at_whole(self.prior.sample(NUM_REFERENCE, rng), rng), rng)
        return [np.unique(np.nanquantile(feature, np.arange(1, NUM_BINS) / NUM_BINS)) for feature in x.T]


@checked
def task(
    simulate: Simulate,
    *,
    prior: Mapping[str, Ends] | Sequence[Ends],
    names: Sequence[str] | None = None,
    support: Mapping[str, tuple[float, float]] | None = None,
    units: Mapping[str, str] | None = None,
    features: Sequence[str] = (),
    kinds: Mapping[str, Kind | ParameterKind] | None = None,
    feature_units: Mapping[str, str] | None = None,
    name: str | None = None,
    per_theta: bool = False,
    failed: Failed = "raise",
    missing: Sequence[str] = (),
    seconds: float = 60.0,
) -> FunctionTask:
    """A task from a function that simulates one event for each row of parameters, or many at one theta.

    Parameters
    ----------
    simulate
        Takes theta (n, p) and a NumPy generator, and returns the events: (n, d), or (n,) where an event is one number.
        Rows are independent, and all randomness comes from the generator.
    prior
        Ends of the uniform prior of each parameter by its name, such as `{"lifetime": (1, 4)}`; or in the order of
        `names`. In place of ends a distribution of one number, such as `scipy.stats.norm(0, 1)`; one that goes on for
        ever ends where a share of 0.0001 is left at either side. Of whole numbers it needs the kind "integer". Ends of
        an integer are half as probable as each number between; `scipy.stats.randint(0, 13)` has 0 to 12 alike.
    names
        Names of the parameters, where `prior` does not give them.
    support
        Where the simulator is defined, if that is wider than the prior: ends by name of the parameter. Beside a prior
        as narrow as the errors of the events, events of a wider support tell how they depend on the parameters.
    units
        Physical units by name of the parameter; "1" where there is none.
    features
        A name for each of the d numbers of an event; of a simulator that returns a DataFrame, the columns to take, by
        default all.
    kinds
        What a feature is, by its name (x1, x2, ... where it has none): "count", "continuous", or "angle" for one that
        comes round again. Of others the type of the events says it: whole numbers are counts. A parameter that takes
        whole values alone is "integer": the simulator is then called with whole ones, and an estimate is one.
    feature_units
        Physical units by name of the feature. An angle comes round after 360 "deg", or else after 2 pi.
    name
        What records and pages call the task; that of the function by default.
    per_theta
        `simulate` takes one theta (p,), a number n of events and a generator, as a program that is started for each
        theta does. A diagnosis, and `infer` with a `bank`, start it for few thetas; methods that draw a theta for each
        event start it for each.
    failed
        What is done where the simulator fails: returns NaN or infinity, or raises ValueError, ArithmeticError,
        RuntimeError, TimeoutError or an error of `subprocess`. "raise" ends what was asked with a line. "region" tries
        it at 512 thetas of its support first, learns where it mostly works, and keeps to that region: what is asked
        for outside is made at its edge, and answers say how often it failed, where, and which share of the prior
        works. An event that fails at a theta that works is made again at that theta. So events are those that
        succeed, and their density is conditional on it: measured events must have been selected in the same way. What
        failed counts within a limit on simulated events, in which a fit leaves room for it, and the 512 that are tried
        on top of it. NaN in the row that failed is cheaper than an exception, after which a whole call is made again in
        parts.
    missing
        Names of features that an event may lack, as of a detector that did not fire: it holds NaN there, simulated and
        measured. `diagnose` and `infer` compare how often they are missing beside their recorded values.
        Effects of the catalogue act on recorded values, but for `lost_value`, by which more are missing; those that
        tie features to each other are left out.
    seconds
        The function is tried on a few events, and ended if that takes longer.

    Raises
    ------
    UsageError
        If the prior is neither finite ends nor a distribution of each parameter, if the function raises, takes too
        long or returns events of another shape, if a name cannot be one, or if a feature is not of the kind that was
        stated.

    Examples
    --------
    >>> decay = task(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"lifetime": (1, 4)}, name="decay")
    >>> decay.simulate(np.full((3, 1), 2.0), np.random.default_rng(0)).shape
    (3, 1)
    """
    distinct("features", features)
    support, units, kinds, feature_units = (given or {} for given in (support, units, kinds, feature_units))
    if not isinstance(prior, Mapping):
        distinct("parameters", names or ())
        if names is None or len(names) != len(prior):
            raise UsageError(f"names must give a name to each of the {len(prior)} parameters of the prior, got {names}")
        prior = dict(zip(names, prior, strict=True))
    label = name or re.sub(r"[^A-Za-z0-9.]+", "-", getattr(simulate, "__name__", "")).strip("-") or "task"
    if not re.fullmatch(NAME, label):
        raise UsageError(f"the name of a task must be letters, digits, dots and dashes, got '{label}'")
    if not prior:
        raise UsageError(f"the prior of {label} is empty; give the ends of one parameter at least")
    box_of(prior, [parameter for parameter, kind in kinds.items() if kind == "integer"])
    for given, what in ((support, "support"), (units, "units")):
        for parameter in given:
            if parameter not in prior:
                raise UsageError(f"{what} names '{parameter}'; the parameters of {label} are {', '.join(prior)}")
    if failed not in get_args(Failed):
        raise UsageError(f"failed must be one of {', '.join(get_args(Failed))}, got {shown(failed)}")
    try:
        with limited_to(seconds, f"the function of the task {label}, tried on {len(prior) + 1} events,"):
            made = FunctionTask(
                simulate,
                label,
                prior,
                support,
                units,
                features,
                kinds,
                feature_units,
                per_theta,
                failed,
                missing,
            )
    except UsageError:
        raise
    except (Exception, SystemExit) as error:  # a user's function may raise anything
        hint, reason = "", str(error) if isinstance(error, SimulatorError) else raised(error)
        if getattr(simulate, "__code__", None) in [frame.f_code for frame, _ in walk_tb(error.__traceback__)]:
            hint = (
                "; theta is one, (p,), so theta[0]" if per_theta else "; theta has a row for each event, so theta[:, 0]"
            )
            hint += " is the first parameter"
        raise UsageError(f"the task {label} cannot be made: {reason}{hint}") from error
    if not made.repeats:
        warn(
            f"{label} makes other events when it is given the same generator again: take all randomness from that, or "
            "one seed gives more than one answer",
            stacklevel=3,
        )
    return made


class _Over(BaseException):
    """The time is over; no Exception, so that the function that hangs does not take it for one of its own."""


@contextmanager
def limited_to(seconds: float, what: str) -> Iterator[None]:
    """End the block after so many seconds by UsageError, which says `what` hangs.

    It is ended as by Ctrl-C: within Python, not within compiled code, and in the main thread only, not on Windows.
    """
    if not 0 < seconds < math.inf:
        raise UsageError(f"seconds must be a number above 0, got {seconds}")
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return

    def over(number: int, frame: object) -> None:
        raise _Over

    began, before = time.monotonic(), signal.signal(signal.SIGALRM, over)
    remaining, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except _Over:
        raise UsageError(f"{what} has not returned after {seconds:g} s; mend it, or allow more `seconds`") from None
    finally:
        # An alarm that was set before is set again.
        signal.setitimer(signal.ITIMER_REAL, remaining and max(remaining - (time.monotonic() - began), 1e-3), interval)
        signal.signal(signal.SIGALRM, before)
