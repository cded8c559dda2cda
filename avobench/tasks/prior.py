"""Priors that are not uniform: a distribution of SciPy's for each parameter, by its quantiles."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.contract import Box
from avobench.tasks.errors import UsageError, raised, shown

TAIL = 1e-4
"""A prior that goes on for ever ends where so much is left at either side: a normal one 3.7 deviations out."""
TABULATED = "quantiles"
"""The name of a law that is none of SciPy's by name: its arguments are the quantiles of equal shares."""
STEPS = 100
"""So many shares it has."""
EVEN = 20_000
"""So many quantiles tell the moments of a law: a step is half of TAIL."""
MOST_VALUES = 100_000
"""Whole numbers of a prior, at most: all are looked at for a share of it."""


@runtime_checkable
class Distribution(Protocol):
    """A distribution of one number, as `scipy.stats.norm(0, 1)` is."""

    def ppf(self, q: ArrayLike) -> Any: ...

    def cdf(self, x: ArrayLike) -> Any: ...


@dataclass(frozen=True)
class Law:
    """A distribution of SciPy's by its name and arguments, so that a file can hold it.

    Of whole numbers it is made continuous, such that a draw which `Task.at_whole` makes whole has their probabilities.
    Others that can tell their quantiles, such as `scipy.stats.rv_histogram`, are kept as TABULATED.
    """

    name: str
    args: tuple[float, ...] = ()
    kwds: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, parameter: str, given: Distribution, integer: bool) -> "Law":
        """The law of a frozen distribution. Raises UsageError for what is none of one number, named in SciPy."""
        if isinstance(given, Law):
            return given
        from scipy import stats

        what = f"the prior of {parameter}"
        family, args = getattr(given, "dist", None), getattr(given, "args", ())
        if isinstance(given, stats.rv_continuous | stats.rv_discrete) and hasattr(stats, given.name or ""):
            raise UsageError(f"{what} lacks its parameters: write it as scipy.stats.norm(0, 1) is written")
        if family is None or type(family) is not type(getattr(stats, family.name or "", None)):
            if integer:
                raise UsageError(f"{what} must be one of scipy.stats by name, since {parameter} is an integer")
            return cls.tabulated(what, given)
        try:
            law = cls(family.name, tuple(map(float, args)), tuple((k, float(v)) for k, v in given.kwds.items()))
        except TypeError as error:
            raise UsageError(f"{what} must be a distribution of one number, got {shown(given)}") from error
        except ValueError as error:
            raise UsageError(f"{what} cannot be used: {error}") from error
        if law.discrete and not integer:
            raise UsageError(f"{what} is of whole numbers: say kinds={{'{parameter}': 'integer'}}")
        if integer and not law.discrete:
            raise UsageError(f"{parameter} is an integer: its prior must be of whole numbers, as scipy's randint is")
        return law

    @classmethod
    def tabulated(cls, what: str, given: Distribution) -> "Law":
        """The law by the quantiles of any distribution. Raises UsageError, which names `what`, where it has none."""
        try:
            edges = np.array(given.ppf(np.linspace(0, 1, STEPS + 1)), float)
            ends = np.array(given.ppf([TAIL, 1 - TAIL]), float)
            edges[[0, -1]] = np.where(np.isfinite(edges[[0, -1]]), edges[[0, -1]], ends)
        except Exception as error:  # of a user's class
            raise UsageError(f"{what} cannot be used: {raised(error)}") from error
        if edges.shape != (STEPS + 1,) or not (np.diff(edges) > 0).all():
            raise UsageError(f"{what} must be a continuous distribution of one number, got {shown(given)}")
        return cls(TABULATED, tuple(edges.tolist()))

    def __post_init__(self) -> None:
        from scipy import stats

        if self.name == TABULATED:
            return
        if not isinstance(getattr(stats, self.name, None), stats.rv_continuous | stats.rv_discrete):
            raise ValueError(f"scipy.stats has no distribution {self.name}")
        low, high = self.ends
        if not (np.isfinite([low, high]).all() and low < high):
            raise ValueError(f"{self!r} has no finite width")
        if self.discrete and high - low > MOST_VALUES:
            raise ValueError(f"{self!r} has more than {MOST_VALUES} values")

    def __repr__(self) -> str:
        if self.name == TABULATED:
            return f"scipy.stats.rv_histogram(([1] * {len(self.args) - 1}, {list(self.args)}), density=False)"
        arguments = [*map(repr, self.args), *(f"{name}={value!r}" for name, value in self.kwds)]
        return f"scipy.stats.{self.name}({', '.join(arguments)})"

    @cached_property
    def _frozen(self) -> Any:
        from scipy import stats

        if self.name == TABULATED:
            return stats.rv_histogram((np.ones(len(self.args) - 1), np.array(self.args)), density=False)
        return getattr(stats, self.name)(*self.args, **dict(self.kwds))

    @property
    def discrete(self) -> bool:
        return hasattr(self._frozen, "pmf")

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Where it ends, or all but TAIL of it does at either side."""
        ends = np.array(self._frozen.support(), float)
        return tuple(np.where(np.isfinite(ends), ends, self._frozen.ppf([TAIL, 1 - TAIL])).tolist())

    def cdf(self, x: ArrayLike) -> NDArray[np.float64]:
        """The share below x, in that between the ends: 0 to 1."""
        if self.discrete:
            return np.interp(x, *self._steps)
        low, high = self._frozen.cdf(self.ends)
        return (self._frozen.cdf(np.clip(x, *self.ends)) - low) / (high - low)

    def ppf(self, q: ArrayLike) -> NDArray[np.float64]:
        """The inverse of `cdf`."""
        if self.discrete:
            return np.interp(q, *self._steps[::-1])
        low, high = self._frozen.cdf(self.ends)
        return np.clip(self._frozen.ppf(low + np.asarray(q) * (high - low)), *self.ends)

    @cached_property
    def _steps(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points between which the density is flat, and the share below each: (2k - 1,) twice, for k whole numbers.

        A whole number gives half of its probability p to either side, or all to one at the ends. So between two of them
        lie `low` of the lower one and `high` of the upper one. Draws must then be rounded up with a probability of
        f = high / (low + high) on average: `low` lie evenly below f, and `high` above.
        """
        values = np.arange(self.ends[0], self.ends[1] + 1)
        p = self._frozen.pmf(values)
        low, high = p[:-1] / 2, p[1:] / 2
        low[0], high[-1] = p[0], p[-1]
        points, shares = np.repeat(values, 2)[:-1], np.zeros(2 * len(values) - 1)
        points[1::2] += np.divide(high, low + high, out=np.full(len(low), 0.5), where=low + high > 0)
        shares[1:] = np.cumsum(np.column_stack([low, high]).ravel())
        return points, shares / shares[-1]


@dataclass(frozen=True)
class Distributed(Box):
    """A box in which parameters are distributed by laws; those without one are uniform."""

    laws: tuple[Law | None, ...] = ()

    @property
    def center(self) -> NDArray[np.float64]:
        """The medians (p,)."""
        return self.at(np.full((1, self.dim), 0.5))[0]

    @cached_property
    def mean(self) -> NDArray[np.float64]:
        """(p,)"""
        return self._even.mean(axis=0)

    @cached_property
    def std(self) -> NDArray[np.float64]:
        """(p,)"""
        return self._even.std(axis=0)

    @cached_property
    def _even(self) -> NDArray[np.float64]:
        """The quantiles in the middle of each of many equal shares (n, p): between its ends any law has moments."""
        shares = (np.arange(EVEN) + 0.5) / EVEN
        return self.at(np.tile(shares[:, None], self.dim))

    def sample(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draws: (n, p)."""
        return self.at(rng.random((n, self.dim)))

    def at(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        """The parameters below which these shares of the prior lie, each by itself: (..., p) -> (..., p)."""
        plain = np.clip(self.low + share * self.width, self.low, self.high)
        return self._by_law(plain, share, "ppf")

    def shares(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The inverse of `at`."""
        return self._by_law((theta - self.low) / self.width, theta, "cdf")

    def _by_law(self, plain: NDArray, given: NDArray, how: str) -> NDArray[np.float64]:
        values = plain.copy()
        for j, law in enumerate(self.laws):
            values[..., j] = plain[..., j] if law is None else getattr(law, how)(given[..., j])
        return values


Ends = tuple[float, float] | Distribution
"""The ends of a uniform prior, or a distribution."""
