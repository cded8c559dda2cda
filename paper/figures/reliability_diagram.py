"""Probabilities against how often they came true: `python -m paper.figures.reliability_diagram FOLDER RECORDS ...`.

Names of all cases are sorted by the probability that a diagnosis gave them and put into bins of equally many. Where
the probabilities hold, the share of a bin that was hidden covers the diagonal: its 95 % interval is Clopper-Pearson's.
"""

import sys
from collections.abc import Iterable
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binomtest

from avobench.challenge.case import Case
from avobench.reports.style import FLOOR, STYLE, save
from avobench.tasks.errors import UsageError
from paper.tables.reliability import BINS, LEAST, cases_of, names, truth


def bins(cases: Iterable[Case]) -> pd.DataFrame:
    """Names in each bin, the mean probability told, and the share that came true. Raises UsageError for none told."""
    told = [
        (share, key in truth(case))
        for case in cases
        if case.detected and case.diagnosis.get("probabilities")
        for key, share in names(case).items()
        if share >= LEAST
    ]
    if not told:
        raise UsageError("no case tells probabilities, so there is no reliability to draw")
    rows = []
    for part in np.array_split(np.array(sorted(told)), min(BINS, len(told))):
        share, hit = part.T
        interval = binomtest(int(hit.sum()), len(hit)).proportion_ci()
        rows.append((len(hit), share.mean(), hit.mean(), interval.low, interval.high))
    return pd.DataFrame(rows, columns=["names", "told", "true", "low", "high"])


def draw(cases: Iterable[Case], folder: Path) -> list[Path]:
    """Write reliability.pdf, reliability.png and reliability.csv to `folder`."""
    table = bins(cases)
    with matplotlib.rc_context(STYLE):
        figure = Figure(layout="constrained", figsize=(4.5, 4.5))
        axis = figure.add_subplot()
        axis.plot([0, 1], [0, 1], color=FLOOR, ls="--", lw=1.2)
        low, high = table.true - table.low, table.high - table.true
        axis.errorbar(table.told, table.true, [low, high], fmt="o", capsize=2)
        axis.set(xlabel="stated probability", ylabel="share that was hidden", xlim=(0, 1), ylim=(0, 1))
        return save(figure, table, folder, "reliability")


if __name__ == "__main__":
    print(*draw((case for _, case in cases_of(map(Path, sys.argv[2:]))), Path(sys.argv[1])), sep="\n")
