"""The contract of a method: from a problem and a random stream to an estimate."""

import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.methods.problem import Problem

LATER = {"identifies": "unless default"}
"""Metadata of settings that came after the first records, which they do not identify at their defaults."""


class TracePoint(NamedTuple):
    """The estimate that would have been given after so many simulated events."""

    simulations: int
    theta: NDArray[np.float64]
    """(p,)"""
    std: NDArray[np.float64] | None = None
    """Spread of the proposal or posterior at that point (p,), where the method knows it."""


class WeightedSample(NamedTuple):
    """Points of a posterior, and how probable each is beside the others."""

    theta: NDArray[np.float64]
    """(m, p), in raw units."""
    weights: NDArray[np.float64]
    """(m,), not negative, of sum 1."""

    @classmethod
    def equal(cls, theta: NDArray[np.float64]) -> "WeightedSample":
        """Draws (m, p) that are all as probable."""
        return cls(theta, np.full(len(theta), 1 / len(theta)))


@dataclass(frozen=True)
class Estimate:
    """The answer of a method. All parameters are in raw units."""

    theta: NDArray[np.float64]
    """Best fit (p,), finite and within the support."""
    how: str
    """The way in which the estimate was taken, e.g. "mode of the final proposal"."""
    spread_of: str
    """The distribution that `mean` and `std` describe: "proposal" or "posterior"."""
    mean: NDArray[np.float64]
    """(p,)"""
    std: NDArray[np.float64]
    """(p,)"""
    trace: list[TracePoint] = field(default_factory=list)
    discarded: int = 0
    """Events that were simulated but did not enter the estimate."""
    message: str = ""
    """Anything a reader of the record should know; must say why when much of the budget was left."""
    doubt: str = ""
    """Why the method does not vouch for `theta`, such as a search that did not come to rest; then the status of the
    record is `doubtful`, and its message ends with this."""
    error: NDArray[np.float64] | None = None
    """Standard error of `theta` (p,), where the method knows one; the width of a proposal is none."""
    covariance: NDArray[np.float64] | None = None
    """Covariance (p, p) of which `error` is the root of the diagonal, or `std` where there is no error; where the
    method knows it."""
    sample: WeightedSample | None = None
    """The posterior of which `std` is the spread, where the method has points of it."""


class Method(ABC):
    """An inference method. Settings are dataclass fields of the subclass; they are part of what identifies a result.

    Raise `version` when the same settings and seed would give another estimate.
    """

    name: ClassVar[str]
    version: ClassVar[str] = "1"
    source: ClassVar[str]
    """The paper or package that the method follows."""
    packages: ClassVar[tuple[str, ...]] = ()
    """Modules that must be importable, checked before a sweep begins; `extra` is the extra that installs them."""
    extra: ClassVar[str] = ""
    amortised: ClassVar[bool] = False
    """True if nothing that it simulates depends on the observation, so that one budget serves all targets of a task.

    All cells of a task and repetition then have the same random streams, hence the same simulated events, and their
    records say `amortised`: they are not to be compared with those of methods that have a budget for each target.
    """
    by_moments: ClassVar[bool] = False
    """True if it uses the mean and the standard deviation of a prior, whatever that is; a prior that is not uniform is
    given to it as it is. For other methods the parameters are shares of such a prior, which are uniform."""
    together: ClassVar[bool] = False
    """True if `infer_together` takes less time than one problem after the other."""

    @property
    def from_prior(self) -> bool:
        """Whether all its thetas are drawn from the prior, whatever was observed."""
        return False

    @abstractmethod
    def min_simulations(self, num_parameters: int) -> int:
        """The smallest budget, in events, from which this method can make an estimate.

        Raises UsageError when its settings suit no problem of so many parameters.
        """

    @abstractmethod
    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """Infer the parameters of `problem` by calling `problem.simulate`, with all randomness taken from `rng`.

        Stop before the budget ends, or let a package run into BudgetExhausted and use what it had completed. Errors of
        the simulator are left to propagate: they become the status of the record.
        """

    def infer_together(self, problems: Sequence[Problem], rngs: Sequence[np.random.Generator]) -> list[Estimate]:
        """Return what `infer` makes of each problem with its own random stream, to floating-point reordering.

        The problems are of one task. A method that gains from knowing them all at once, such as one that trains their
        networks in one batch, says so with `together = True`. What goes wrong with any of them is raised for all.
        """
        return [self.infer(problem, rng) for problem, rng in zip(problems, rngs, strict=True)]


@contextmanager
def global_seed(rng: np.random.Generator) -> Iterator[None]:
    """Seed the global generators that a package draws from, and restore them afterwards.

    They are `numpy.random`, `random`, and PyTorch's, those of CUDA devices too, where PyTorch has been imported before
    the block begins: a method that uses it imports it, or the package that does, first.
    """
    import random

    numpy_state, python_state = np.random.get_state(), random.getstate()
    np.random.seed(rng.integers(2**32, dtype=np.uint32))
    random.seed(int(rng.integers(2**63)))
    torch_seed = int(rng.integers(2**63))  # drawn whether it is needed or not, so that `rng` goes on alike
    with ExitStack() as restored:
        restored.callback(np.random.set_state, numpy_state)
        restored.callback(random.setstate, python_state)
        if torch := sys.modules.get("torch"):
            devices = range(torch.cuda.device_count()) if torch.cuda.is_available() else []
            restored.enter_context(torch.random.fork_rng(devices=devices))
            torch.manual_seed(torch_seed)
        yield
