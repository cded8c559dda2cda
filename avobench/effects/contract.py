"""The contract of an effect: something that a simulator may lack, written as a change of that simulator."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.site import Domain, Site

OF_FEATURE = "of the feature"
"""The unit of a parameter that is a value of the feature; in answers it has the feature's own, if the task says it."""


Simulate = Callable[[NDArray[np.float64], np.random.Generator], NDArray]
"""The simulator that an effect receives. It makes one event per row: theta (n, p), a generator -> (n, d)."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect, `low <= null <= high`. Raises ValueError otherwise."""

    name: str
    low: float
    high: float
    null: float | None
    """The value at which the effect is absent; None for a parameter that then has no meaning, such as a location."""
    unit: str
    soft: bool = False
    """Whether `high` is a guess and not a limit: a fit that ends there may double it."""
    known: bool = False
    """Whether its value is read off the data, so that what its narrow bounds leave is no error of a measurement."""

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise ValueError(f"parameter {self.name} needs finite low < high, got {self.low} and {self.high}")
        if self.null is not None and not self.low <= self.null <= self.high:
            raise ValueError(f"the null value {self.null} of parameter {self.name} lies outside its bounds")

    @property
    def logarithmic(self) -> bool:
        """Whether the parameter is varied on a logarithmic scale, because its bounds span orders of magnitude."""
        return self.null is None and self.low > 0 and self.high / self.low >= 10


class Effect(ABC):
    """A change of a simulator. A subclass sets the attributes and defines `apply`.

    An effect is a *family*: `shapes` may offer other shapes of the same physics, which share its name. A fit tries all
    of them, because the real effect never has the exact shape of one. Where the data could not tell two classes apart,
    as a truncation from a sharp acceptance, they are one family too: they have one name, and shapes of their own.
    """

    name: str
    feature: int | str | None = None
    """The column it acts on, "all" where it acts on all alike, None where events have no features to choose from; the
    name of a parameter of the task, if it acts on that."""
    parameters: tuple[Parameter, ...]
    """Strength first; the other parameters give its shape."""
    shape: str = ""
    """Name of this shape among the shapes of the effect."""
    stage: int = 2
    """Stage of the chain: 0 generated particles, which are altered before there is an event; 1 the source;
    2 measurement; 3 selection; 4 what is added or read out; 5 a selection after everything else. Effects act in this
    order, and those of one stage in that of being added."""
    choices: int = 0
    """Shape parameters beyond `parameters` that choosing among its shapes amounts to, such as a step."""
    sentence: ClassVar[str]
    """A sentence on the effect, for a reader."""
    source: ClassVar[str]
    domains: ClassVar[tuple[Domain, ...]] = ()
    """Kinds of events for which the effect is in the catalogue. An effect with an entry point must state them. One that
    is only requested by `--effect` need not."""
    moves_theta: ClassVar[bool] = False
    """Whether it asks the simulator for every event at another theta, so that nothing of finished events stays."""
    second: tuple[int, ...] = ()
    """Of a mixture: the columns of theta of which a second population has values of its own. The parameters are the
    share of that population, up to a half, and these values."""
    between: ClassVar[bool] = False
    """Whether it ties features to each other, as those of different data sets are not."""
    odds: ClassVar[float] = 1.0
    """Prior odds of the effect against another family."""
    position: ClassVar[int | None] = None
    """Its place in the catalogue, lowest first; effects without one follow by name. A search draws its random numbers
    in this order: effects that take part get a place once and keep it."""

    @classmethod
    def entries(cls, site: Site) -> list["Effect"]:
        """Its entries in the catalogue of a task, each in its plainest shape: none where it does not apply.

        Asked for tasks of its `domains` only. One with default settings unless a family says otherwise.
        """
        return [cls()]

    @abstractmethod
    def apply(
        self, simulate: Simulate, theta: NDArray[np.float64], phi: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        """Events of the simulator with the effect, one per row: theta (n, p), phi (n, q) within the bounds -> (n, d).

        The events keep the simulator's dtype. With the strength at its null value they have the distribution of
        `simulate(theta, rng)`. All randomness comes from `rng`; rows are independent.
        """

    def shapes(self) -> tuple["Effect", ...]:
        """This effect and its other shapes, the plainest first."""
        return (self,)

    def guess(self, x: NDArray) -> NDArray[np.float64] | None:
        """Values of the parameters from which to fit measured events x (N, d): (m, q), or None for a grid over all.

        For an effect whose small change of strength changes the events everywhere, so that no grid comes close.
        """
        return None

    def within(self, low: float, high: float, column: int) -> NDArray[np.float64] | None:
        """Parameters beside the strength (q - 1,) for an effect between two values of a feature, if it has a place.

        A fit then also begins where measured and simulated events disagree most: a grid is too coarse for narrow ones.
        """
        return None

    def adapted(self, x: NDArray) -> "Effect":
        """The same effect with bounds within which it keeps its meaning for measured events x (N, d)."""
        return self

    def unit(self, parameter: Parameter, units: Sequence[str] = ()) -> str:
        """The unit of one of its parameters, as an answer says it; `units` (d,) are those of the features, if known."""
        has_unit = units and isinstance(self.feature, int)
        return units[self.feature] if has_unit and parameter.unit == OF_FEATURE else parameter.unit

    @property
    def key(self) -> tuple[str, int | str | None]:
        """The name of the effect in an answer, which all its shapes share."""
        return self.name, self.feature


class Family(Effect):
    """An effect whose `shape` is one of several. A subclass sets STRENGTH and SHAPES, or defines the methods."""

    STRENGTH: ClassVar[Parameter]
    SHAPES: ClassVar[dict[str, tuple[Parameter, ...]]] = {"": ()}
    """The parameters beside the strength, by the name of the shape."""

    def strength(self) -> Parameter:
        return self.STRENGTH

    def variants(self) -> dict[str, tuple[Parameter, ...]]:
        return self.SHAPES

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (self.strength(), *self.variants()[self.shape])

    def shapes(self) -> tuple[Effect, ...]:
        return tuple(replace(self, shape=shape) for shape in self.variants())
