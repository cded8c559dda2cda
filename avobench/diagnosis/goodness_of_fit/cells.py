"""Is one cell of an image unlike what the simulator expects of it?"""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, norm

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Gate


def cell_gate(fit: Fit, x: NDArray, rng: np.random.Generator, effort: Effort) -> Gate:
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
    return Gate(statistic=float(norm.isf(max(least, 1e-300) / 2)), dof=None, p_value=float(p), sides=2)
