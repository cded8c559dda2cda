"""How an estimate came about: each parameter against the number of simulated events."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from avobench.methods import Estimate
from avobench.reports.style import PALETTE, STYLE, panels
from avobench.tasks import Task


def draw(task: Task, estimate: Estimate) -> Figure:
    """A panel for each parameter; the band is the spread that the method had at that point, where it tells one."""
    points = estimate.trace
    with matplotlib.rc_context(STYLE):
        figure, axes = panels(list(task.parameter_names))
        for j, (axis, unit) in enumerate(zip(axes, task.parameter_units, strict=True)):
            if points:
                simulations = [point.simulations for point in points]
                theta = np.array([point.theta[j] for point in points])
                std = np.array([np.nan if point.std is None else point.std[j] for point in points])
                axis.plot(simulations, theta, color=PALETTE[0])
                axis.fill_between(simulations, theta - std, theta + std, color=PALETTE[0], alpha=0.2, lw=0)
            axis.axhline(estimate.theta[j], color="0.35", ls=":", lw=1)
            axis.set_xlabel("simulated events")
            axis.set_ylabel(task.parameter_names[j] if unit == "1" else f"{task.parameter_names[j]} [{unit}]")
    return figure
