"""BOLFI with either Gaussian process in cells of the benchmark: `python -m paper.tables.surrogates`.

One is ELFI's own, in GPy, the other the fast one. A pair is a target that both have, with the same observed events.
Errors are in units of the floor; `p` is of Wilcoxon's signed-rank test, to both sides, that the logarithms of the
errors do not differ.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import wilcoxon

from avobench.bench.store.store import Store
from avobench.reports.quantities import labelled
from avobench.reports.style import TASK_ORDER, ordered
from paper.speed.bolfi import LEAST_FOR_TEST

ELFI_OWN = Path("results/bolfi-gpy")
FAST = Path("results/reference")


def table(own: list[dict[str, Any]], fast: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task, from the records of `bolfi` with either process."""
    both = [labelled([record for record in records if record["method"] == "bolfi"]) for records in (own, fast)]
    return pd.DataFrame([_row(task, *both) for task in ordered(both[0]["task"], TASK_ORDER)])


def _row(task: str, own: pd.DataFrame, fast: pd.DataFrame) -> dict[str, Any]:
    sides = [frame[frame["task"] == task].set_index("target")[["ratio", "seconds"]] for frame in (own, fast)]
    pairs = sides[0].merge(sides[1], on="target", suffixes=("_elfi", "_fast"))
    logs = np.log(pairs[["ratio_elfi", "ratio_fast"]].to_numpy())
    p = f"{wilcoxon(logs[:, 0], logs[:, 1]).pvalue:.2g}" if len(pairs) >= LEAST_FOR_TEST else "-"
    return {
        "task": task,
        "targets": len(pairs),
        "ELFI's: median error / floor": pairs["ratio_elfi"].median(),
        "fast": pairs["ratio_fast"].median(),
        "nearer with ELFI's": int((logs[:, 0] < logs[:, 1]).sum()),
        "p": p,
        "ELFI's: seconds": pairs["seconds_elfi"].median(),
        "fast: seconds": pairs["seconds_fast"].median(),
    }


def format_table(own: Path = ELFI_OWN, fast: Path = FAST) -> str:
    """`table` of two results folders, to be read."""
    found = table(Store(own).read_all(), Store(fast).read_all())
    return found.to_string(index=False, float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
