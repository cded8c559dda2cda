"""The coverage of quoted errors, by numbers: `python -m paper.tables coverage`."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import norm

from avobench.reports.coverage import by_method

LEVELS = (0.68, 0.95)


def within(away: NDArray[np.float64]) -> dict[str, str]:
    """The share of distances (n,) that lie within the intervals of each of LEVELS, in words; a dash of none."""
    return {
        f"within {level:.0%}": f"{(away <= norm.ppf((1 + level) / 2)).mean():.0%}" if len(away) else "-"
        for level in LEVELS
    }


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """One row per task and method: how many true parameters, and which share of them each level's intervals hold."""
    return pd.DataFrame(
        [
            {"task": task, "method": method, "parameters": len(away), **within(away)}
            for (task, method), away in by_method(records).items()
        ]
    )
