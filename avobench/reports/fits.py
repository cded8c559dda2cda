"""Figures of fits: one estimate on its way and its error, draws of it, and how often the errors of many hold."""

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import binom

from avobench.methods import Estimate
from avobench.reports.style import FLOOR, PALETTE, STYLE, panels
from avobench.tasks import Task

BINS = 10
"""Bins of the ranks."""


def draw(task: Task, estimate: Estimate, error: NDArray[np.float64], error_of: str) -> Figure:
    """A panel for each parameter, with two bands.

    One is the spread that the method had at each point, where it tells one, and the other the quoted `error` (p,) of
    the estimate, which `error_of` names.
    """
    points = estimate.trace
    with matplotlib.rc_context(STYLE):
        figure, axes = panels(list(task.parameter_names))
        for j, (axis, unit) in enumerate(zip(axes, task.parameter_units, strict=True)):
            if points:
                simulations = [point.simulations for point in points]
                theta = np.array([point.theta[j] for point in points])
                std = np.array([np.nan if point.std is None else point.std[j] for point in points])
                axis.plot(simulations, theta, color=PALETTE[0])
                named = "spread while it ran"
                axis.fill_between(simulations, theta - std, theta + std, color=PALETTE[0], alpha=0.2, lw=0, label=named)
            low, high = estimate.theta[j] - error[j], estimate.theta[j] + error[j]
            axis.axhspan(low, high, color=PALETTE[1], alpha=0.4, lw=0, label=f"estimate ± {error_of}")
            axis.axhline(estimate.theta[j], color="0.35", ls=":", lw=1)
            axis.set_xlabel("simulated events")
            axis.set_ylabel(task.parameter_names[j] if unit == "1" else f"{task.parameter_names[j]} [{unit}]")
        axes[0].legend()
    return figure


def pairs(draws: pd.DataFrame, draws_of: str) -> Figure:
    """Draws (n, p) of the parameters: a histogram of each, and one of each pair."""
    import matplotlib.pyplot as plt
    import seaborn  # here, since it takes a second to load

    with matplotlib.rc_context(STYLE):
        figure = seaborn.pairplot(draws, corner=True, kind="hist", diag_kind="hist").figure
        figure.suptitle(draws_of, x=0.98, ha="right")
        plt.close(figure)  # pyplot would keep it, and a notebook would show it twice
    return figure


def calibration(ranks: pd.DataFrame) -> Figure:
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
