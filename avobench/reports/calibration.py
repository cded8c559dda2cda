"""The figure of a calibration: ranks of the true values, and how many each central interval held."""

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binom

from avobench.reports.style import FLOOR, PALETTE, STYLE, panels

BINS = 10
"""Bins of the ranks."""


def drawn(ranks: pd.DataFrame) -> Figure:
    """A panel of ranks (n, p) for each parameter, and one of the coverage; grey is where chance leaves 95 %."""
    n, nominal = len(ranks), np.linspace(0, 1, 101)
    with matplotlib.rc_context(STYLE):
        figure, axes = panels([*map(str, ranks), "coverage"])
        for axis, name in zip(axes, ranks, strict=False):
            axis.axhspan(*binom.interval(0.95, n, 1 / BINS), color=FLOOR, alpha=0.2, lw=0)
            axis.hist(ranks[name], np.linspace(0, 1, BINS + 1), color=PALETTE[0])
            axis.set(xlabel="rank of the true value", ylabel="fits")
        low, high = (edge / n for edge in binom.interval(0.95, n, nominal))
        axes[-1].fill_between(nominal, low, high, color=FLOOR, alpha=0.2, lw=0)
        for i, name in enumerate(ranks):
            away = (2 * ranks[name] - 1).abs().to_numpy()
            held = (away[:, None] <= nominal).mean(axis=0)
            axes[-1].plot(nominal, held, label=name, color=PALETTE[i % len(PALETTE)])
        axes[-1].set(xlabel="nominal coverage", ylabel="empirical coverage")
        axes[-1].legend()
    return figure
