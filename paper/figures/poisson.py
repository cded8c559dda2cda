"""The paper's Figure 1, from the study `poisson`: an unknown Poisson mean, with and without a penalty on entropy."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import poisson

from avobench.bench.store.status import Status
from avobench.reports.style import PALETTE, TRUTH
from avobench.tasks.errors import StoreError
from paper.proposals import convergence, density, proposal

GAMMAS = {
    0.0: (r"$\gamma = 0$", PALETTE[0], {"ls": "-", "lw": 3, "alpha": 0.4}),
    1e-4: (r"$\gamma = 0.0001$", PALETTE[1], {"ls": "--"}),
}
"""The paper's two coefficients: label, colour, line; the two lie on each other, so one is wide and pale."""
THETA, COUNTS = np.linspace(-1.6, 3.2, 241), np.arange(21)


def chosen(records: list[dict[str, Any]], gamma: float, entropy_gradient: str = "closed_form") -> list[dict[str, Any]]:
    """The records of the study `poisson` with this coefficient, by repetition; raises StoreError without any."""
    wanted = {"entropy": gamma, "entropy_gradient": entropy_gradient}
    found = [record for record in records if record["task"] == "poisson-example" and record["status"] == Status.OK]
    found = [record for record in found if wanted.items() <= record["method_settings"].items()]
    if not found:
        raise StoreError(f"there are no records with gamma = {gamma:g}; `python -m paper.study poisson` makes them")
    return sorted(found, key=lambda record: record["repetition"])


def model(record: dict[str, Any], counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """The model q(x | psi) of the final proposal (paper, Equation 14), by Gauss-Hermite quadrature: (n,) -> (n,)."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(64)
    mean, std = proposal(record, final=True)
    return poisson.pmf(counts[:, None], np.exp(mean + std * nodes)) @ weights / weights.sum()


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure and its numbers; every repetition is a line of its own."""
    shown = {gamma: chosen(records, gamma) for gamma in GAMMAS}
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.subplot_mosaic([["proposals", "models"], ["loss", "loss"]])
    rows = []

    def line(panel: str, curve: str, repetition: int, x: NDArray, y: NDArray, **look: Any) -> None:
        axes[panel].plot(x, y, **{"lw": 1.2, **look})
        rows.append(pd.DataFrame({"panel": panel, "curve": curve, "repetition": repetition, "x": x, "y": y}))

    first = next(record for records in shown.values() for record in records)
    true = first["theta_true"][0]
    axes["models"].bar(COUNTS, poisson.pmf(COUNTS, np.exp(true)), color="0.85", label="true")
    pmf = poisson.pmf(COUNTS, np.exp(true))
    rows.append(pd.DataFrame({"panel": "models", "curve": "true", "repetition": -1, "x": COUNTS, "y": pmf}))
    line("proposals", "before", 0, THETA, density(first, THETA, final=False), color=TRUTH, ls=":", label="before")
    for gamma, (name, colour, style) in GAMMAS.items():
        for record in shown[gamma]:
            repetition = record["repetition"]
            look = {"color": colour, **style, "label": None if repetition else name}
            line("proposals", name, repetition, THETA, density(record, THETA, final=True), **look)
            line("models", name, repetition, COUNTS, model(record, COUNTS), **look)
            curve = convergence(record)
            line("loss", name, repetition, curve["simulations"], curve["loss"], **look)
    axes["proposals"].axvline(true, color=TRUTH, lw=1, label=r"$\theta^* = \log 7$")
    axes["proposals"].set(xlabel=r"$\theta = \log\lambda$", ylabel=r"$q(\theta\,|\,\psi)$", title="proposals")
    axes["models"].set(xlabel="$x$", ylabel=r"$q(x\,|\,\psi)$", title="models after")
    axes["loss"].set(xlabel="simulations", ylabel=r"$-\log q(\theta^*\,|\,\psi)$")
    for axis, told in ((axes["proposals"], ("before", r"$\theta^* = \log 7$")), (axes["models"], ("true",))):
        handles = [handle for handle in axis.get_legend_handles_labels()[0] if handle.get_label() in told]
        axis.legend(handles=handles)
    axes["loss"].legend()
    return figure, pd.concat(rows)
