"""The tasks of the paper's experiments that are not among those of the package: other targets, priors and summaries.

The records of these tasks carry a hash of the source below: a class that changes makes them those of another task.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.alignment import NUM_COLUMNS, NUM_ROWS, Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.contract import NUM_TARGETS, Box, Task, stable_hash
from avobench.tasks.poisson import Poisson
from avobench.tasks.warped import KINDS, Mixed, Warped2, Warped5, Warped10
from avobench.tasks.weinberg import Weinberg

THETA_ITSELF = Box((-np.sqrt(3),), (np.sqrt(3),))
"""The prior in whose standardised coordinates (see TruncatedGaussian) a parameter is itself: the paper's experiments
give the proposal's start and learning rate in theta. The prior has no other part in them."""


class PoissonExample(Poisson):
    """Section 4.1: x ~ Poisson(exp theta), theta* = log 7."""

    name: ClassVar = "poisson-example"
    prior: ClassVar = THETA_ITSELF

    def targets(self, n: int = 1) -> NDArray[np.float64]:
        return np.full((n, 1), np.log(7))


class _OnAlignment(Alignment):
    """The task alignment under another name, whose floor is that of alignment itself."""

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        return Alignment().floor(theta, num_observations, num_simulations)


class AlignmentExample(_OnAlignment):
    """Section 4.2: the task alignment at theta* = 1 mm."""

    name = "alignment-example"
    prior = THETA_ITSELF

    def targets(self, n: int = 1) -> NDArray[np.float64]:
        return np.ones((n, 1))


class AlignmentRows(_OnAlignment):
    """The benchmark's alignment with another summary statistic, which knows that nothing depends on the azimuth."""

    name = "alignment-rows"

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """The sums of an average image over azimuth: (n, 1024) -> (32,)."""
        return super().summary(x).reshape(NUM_ROWS, NUM_COLUMNS).sum(axis=1)

    def targets(self, n: int = NUM_TARGETS) -> NDArray[np.float64]:
        return Alignment().targets(n)


class PoissonDevelopment(Poisson):
    """Targets are drawn with the hash of a task's name, so another name is other targets: settings are chosen here."""

    name = "poisson-development"


class CarlDevelopment(Carl):
    name = "carl-development"


class WeinbergDevelopment(Weinberg):
    name = "weinberg-development"


# The hash of the source holds the docstring, which is true of `avo`. `rank-moments` was changed once after it had seen
# poisson, carl and weinberg, and run again.
class Fresh(Task):
    """A task on targets that nobody has seen before `avo` was finished. What else there is stays the task's."""

    of: ClassVar[type[Task]]

    def targets(self, n: int = 100) -> NDArray[np.float64]:
        """Draws from the prior: (n, p)."""
        return self.prior.sample(n, np.random.default_rng(stable_hash("targets of 28 November 2026", self.of.name)))

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """The floor of the task itself: on alignment it is tabulated for that class alone."""
        return self.of().floor(theta, num_observations, num_simulations)


class FreshPoisson(Fresh, Poisson):
    name = "poisson-fresh"
    of = Poisson


class FreshCarl(Fresh, Carl):
    name = "carl-fresh"
    of = Carl


class FreshWeinberg(Fresh, Weinberg):
    name = "weinberg-fresh"
    of = Weinberg


class FreshAlignment(Fresh, Alignment):
    name = "alignment-fresh"
    of = Alignment


class FreshWarped2(Fresh, Warped2):
    name = "warped-2-fresh"
    of = Warped2


class FreshWarped5(Fresh, Warped5):
    name = "warped-5-fresh"
    of = Warped5


class FreshWarped10(Fresh, Warped10):
    name = "warped-10-fresh"
    of = Warped10


class Warped32(Mixed, p=32, kinds=KINDS, family="warped"):
    """Eight of each kind."""


class Means32(Mixed, p=32, kinds=("mean",), family="means"):
    """The control of Warped32."""


FRESH = (FreshPoisson, FreshCarl, FreshWeinberg, FreshAlignment)
FRESH_WARPED = (FreshWarped2, FreshWarped5, FreshWarped10)
DEVELOPMENT = {"poisson": PoissonDevelopment, "carl": CarlDevelopment, "weinberg": WeinbergDevelopment}


def spec(task: type[Task]) -> str:
    """How a cell names a task that is not registered."""
    return f"{task.__module__}:{task.__name__}"
