"""The figure of one estimate: each parameter against the number of simulated events, and its error."""

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avobench.methods import Estimate
from avobench.reports.style import PALETTE, STYLE, panels
from avobench.tasks import Task


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
