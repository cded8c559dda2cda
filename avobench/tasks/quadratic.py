"""The terms of a quadratic polynomial in several variables, to which coefficients are fitted."""

import numpy as np
from numpy.typing import NDArray


def quadratic(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """1, t_i, and t_i t_j for i <= j: (..., p) -> (..., (p + 1)(p + 2) / 2)."""
    i, j = np.triu_indices(t.shape[-1])
    return np.concatenate([np.ones_like(t[..., :1]), t, t[..., i] * t[..., j]], axis=-1)
