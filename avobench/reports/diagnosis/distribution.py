"""The figure of one feature: measured and simulated, their pulls, and the regions that stand out."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator, ScalarFormatter
from numpy.typing import NDArray

from avobench.diagnosis.report.result import Spectrum
from avobench.diagnosis.schema import Region
from avobench.reports.diagnosis.drawn import AFTER, BEFORE, REGION, Drawn, sigma

STEEP = 5.0
"""A density whose highest bin is so many times the middle one is drawn on a logarithmic axis."""
LEAST_SEEN = 0.012
"""The least width of the axis that a region is drawn with, about three of a reader's pixels a side."""
MOST_LABELS = 8
"""Regions beyond so many have no label, but stand in the table."""
LABEL_WIDTH = 0.1
"""Share of the axis; labels that would be nearer to each other stand above each other."""
LEAST_PULLS = 4.0
"""The scale of pulls reaches at least so far."""
LINEAR_PULLS = 5.0
"""Up to here a scale of pulls is linear; beyond, logarithmic, if it has to reach much farther."""
FAR_PULLS = 15.0
"""A linear scale up to here still shows pulls of one standard error."""

Model = tuple[str, Any, str, NDArray[np.float64]]
"""When, colour, line style, shares of the bins."""


def distribution(spectrum: Spectrum, regions: Sequence[Region], name: str, unit: str = "1") -> Drawn:
    """Measured and simulated densities of a feature, and below them the pulls of each simulation on one scale."""
    models: list[Model] = [("before", BEFORE, "--", spectrum.before)]
    if spectrum.after is not None:
        models.append(("after", AFTER, "-", spectrum.after))
    near = [each for each in regions if each.feature in (spectrum.feature, None) and each.low is not None]
    near.sort(key=lambda each: -abs(each.z))
    figure = Figure(figsize=(6.4, 3.4 + 1.1 * len(models)), layout="constrained")
    heights = [3] + [1] * len(models)
    top, *below = axes = figure.subplots(1 + len(models), sharex=True, height_ratios=heights)
    _densities(top, spectrum, models)
    for axis, model in zip(below, models, strict=True):
        _pulls(axis, spectrum, model)
    edges = _drawn(spectrum)
    _regions((top, below[0]), near, edges[0], edges[-1])
    top.set_xlim(edges[0], edges[-1])
    far = _one_scale(below, [spectrum.pulls(share) for *_, share in models])
    _words(axes, spectrum, models, unit)
    caption = (
        f"Measured and simulated {spectrum.feature}. Pulls are differences in standard errors, the band spans 2, and "
        "all panels of pulls have one scale"
        + (f", linear up to {LINEAR_PULLS:g} and logarithmic beyond. " if far else ". ")
        + "Shaded: regions that stand out though all were looked at, each with its significance. Those that are too "
        "narrow to be seen are drawn wider."
        + (f" The last bin reaches to {spectrum.edges[-1]:g}." if edges[-1] < spectrum.edges[-1] else "")
    )
    return Drawn(name, caption, figure, _table(spectrum, models))


def _drawn(spectrum: Spectrum) -> NDArray[np.float64]:
    """The edges (bins + 1,) in the figure: the last bin of a table takes half of the axis at most."""
    edges = spectrum.edges.copy()
    if spectrum.axis and len(edges) > 2:
        edges[-1] = min(edges[-1], 2 * edges[-2] - edges[0])
    return edges


def _densities(axis: Axes, spectrum: Spectrum, models: list[Model]) -> None:
    width, edges = np.diff(spectrum.edges), _drawn(spectrum)
    centres = (edges[1:] + edges[:-1]) / 2
    for when, colour, style, share in models:
        axis.stairs(share / width, edges, color=colour, ls=style, lw=1.4, label=f"simulated, {when}")
    measured, error = spectrum.measured / width, spectrum.error / width
    axis.errorbar(centres, measured, error, fmt="o", color="black", ms=2.5, lw=0.8, label="measured")
    if measured.max() > STEEP * np.median(measured):
        axis.set_yscale("log", nonpositive="mask")
    else:
        axis.set_ylim(bottom=0)


def _pulls(axis: Axes, spectrum: Spectrum, model: Model) -> None:
    _, colour, _, share = model
    axis.axhspan(-2, 2, color="0.85", lw=0, zorder=0.1)
    axis.stairs(spectrum.pulls(share), _drawn(spectrum), baseline=0, fill=True, color=colour, alpha=0.8)


def _regions(axes: Sequence[Axes], regions: Sequence[Region], low: float, high: float) -> None:
    """Shade the regions, and write above the first panel how much each stands out, without one label on another."""
    rows: list[float] = []  # the place of the last label of each
    labelled = regions[:MOST_LABELS]
    for region in sorted(regions, key=lambda region: region.low + region.high):
        left, right = _drawn_limits(max(region.low, low), min(region.high, high), low, high)
        if region.low >= high or region.high <= low:
            continue
        look = {"fc": (*REGION[region.kind], 0.2), "lw": 0, "zorder": 0}
        for axis in axes:
            axis.axvspan(left, right, label=region.kind, **look)
        if region not in labelled:
            continue
        place = ((left + right) / 2 - low) / (high - low)
        row = next((k for k, last in enumerate(rows) if place - last >= LABEL_WIDTH), len(rows))
        rows[row : row + 1] = [place]
        where = {"xycoords": "axes fraction", "textcoords": "offset points", "annotation_clip": False}
        look = {"ha": "center", "color": "0.15", "fontsize": "small"}
        axes[0].annotate(sigma(region), (place, 1), (0, 3 + 11 * row), **where, **look)


def _drawn_limits(left: float, right: float, low: float, high: float) -> tuple[float, float]:
    """The limits that a region is drawn with, which lie within the axis and are not too near to each other."""
    least = LEAST_SEEN * (high - low)
    if right - left >= least:
        return left, right
    middle = min(max((left + right) / 2, low + least / 2), high - least / 2)
    return middle - least / 2, middle + least / 2


def _one_scale(axes: Sequence[Axes], pulls: list[NDArray[np.float64]]) -> bool:
    """Give all panels of pulls one scale, and say whether it is logarithmic where pulls are large."""
    limit = max(LEAST_PULLS, *(1.1 * float(np.abs(each).max()) for each in pulls))
    far = limit > FAR_PULLS
    for axis in axes:
        if far:
            axis.set_yscale("symlog", linthresh=LINEAR_PULLS, linscale=1)
            largest = 10.0 ** np.floor(np.log10(limit))
            axis.yaxis.set_major_locator(FixedLocator([-largest, 0, largest]))
            axis.yaxis.set_minor_locator(NullLocator())
            axis.yaxis.set_major_formatter(ScalarFormatter())
            axis.yaxis.set_minor_formatter(NullFormatter())
        axis.set_ylim(-limit, limit)
    return far


def _words(axes: Sequence[Axes], spectrum: Spectrum, models: list[Model], unit: str) -> None:
    axes[0].set_ylabel(spectrum.quantity)
    for axis, (when, *_) in zip(axes[1:], models, strict=True):
        axis.set_ylabel(f"pull\n{when}")
    axes[-1].set_xlabel((spectrum.axis or spectrum.feature) + f" [{unit}]" * (unit != "1"))
    handles, labels = axes[0].get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))  # several regions of a kind are one entry
    axes[0].legend(once.values(), once.keys(), frameon=True, framealpha=0.9, edgecolor="none")


def _table(spectrum: Spectrum, models: list[Model]) -> pd.DataFrame:
    edges = spectrum.edges
    columns = {"low": edges[:-1], "high": edges[1:], "measured": spectrum.measured, "error": spectrum.error}
    for when, _, _, share in models:
        columns |= {f"simulated_{when}": share, f"pull_{when}": spectrum.pulls(share)}
    return pd.DataFrame(columns)
