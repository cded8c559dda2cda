"""Random errors of a given skewness, which smearing and a scatter of rates share."""

import numpy as np
from numpy.typing import NDArray


def skewed_noise(skewness: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Noise of mean 0 and standard deviation 1, from a mirrored exponential over a Gaussian to an exponential: (n,).

    A Gaussian and a share s of an exponential have the skewness 2 s^3. It, and not s, is the parameter: a fit that
    begins at a Gaussian sees its slope.
    """
    s, n = np.cbrt(skewness / 2), len(skewness)
    return np.sqrt(1 - s**2) * rng.standard_normal(n) + s * (rng.standard_exponential(n) - 1)
