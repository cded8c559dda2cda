"""Curves of the proposal of a one-parameter run of AVO, from its record: density, model, and what it says of theta*."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import norm


def proposal(record: dict[str, Any], *, final: bool) -> tuple[float, float]:
    """Mean and standard deviation of the proposal at the end of a run, or at its start."""
    point = record["trace"][-1 if final else 0]
    return point["theta"][0], point["std"][0]


def density(record: dict[str, Any], theta: NDArray[np.float64], *, final: bool) -> NDArray[np.float64]:
    """q(theta | psi), as a Gaussian of the recorded mode and standard deviation: theta (n,) -> (n,)."""
    return norm.pdf(theta, *proposal(record, final=final))


def convergence(record: dict[str, Any]) -> pd.DataFrame:
    """One row per point of the trace: `simulations`, `distance` of the proposal's mode from theta*, and `loss`.

    The loss is -log q(theta* | psi), for a Gaussian of the recorded mode and standard deviation.
    """
    true = record["theta_true"][0]
    rows = [(point["simulations"], point["theta"][0], point["std"][0]) for point in record["trace"]]
    frame = pd.DataFrame(rows, columns=["simulations", "mean", "std"])
    frame["distance"] = (frame["mean"] - true).abs()
    frame["loss"] = -norm.logpdf(true, frame["mean"], frame["std"])
    return frame
