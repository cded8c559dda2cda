"""The figures of a diagnosis. Distinctions by colour are repeated in line style, marker or position."""

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avobench.diagnosis.report.result import Maps, Pictures
from avobench.diagnosis.schema import Diagnosis, Region
from avobench.reports.diagnosis.distribution import distribution
from avobench.reports.diagnosis.drawn import AFTER, BEFORE, REGION, Drawn, sigma
from avobench.reports.style import STYLE
from avobench.tasks import Task

FIGURE = re.compile(r"(maps|distribution-\d+|theta)\.(pdf|png|csv)")


def drawings(task: Task, diagnosis: Diagnosis, pictures: Pictures) -> Iterator[tuple[str, Callable[[], Drawn]]]:
    """The figures that the diagnosis has something to show in: the name of each, and what draws it."""
    styled = matplotlib.rc_context(STYLE)
    if pictures.maps is not None:
        yield "maps", styled(partial(_maps, pictures.maps, diagnosis.regions))
    units = dict(zip(task.labels, task.feature_units, strict=False))  # none where the task does not say them
    for number, spectrum in enumerate(pictures.spectra, start=1):
        name, unit = f"distribution-{number}", spectrum.unit or units.get(spectrum.feature, "1")
        yield name, styled(partial(distribution, spectrum, diagnosis.regions, name, unit))
    yield "theta", styled(partial(_theta, task, diagnosis))


def _maps(maps: Maps, regions: Sequence[Region]) -> Drawn:
    models = [("before", maps.before)]
    if maps.after is not None:
        models.append(("after", maps.after))
    figure = Figure(figsize=(3.2 * (1 + len(models)), 3.2), layout="constrained")
    first, *others = figure.subplots(1, 1 + len(models))
    image = first.imshow(maps.measured, cmap="cividis", origin="lower", aspect="auto")
    figure.colorbar(image, ax=first, label="mean of a cell", location="bottom")
    first.set_title("measured")
    limit = max(4.0, *(float(np.abs(maps.pulls(simulated)).max()) for _, simulated in models))
    for axis, (when, simulated) in zip(others, models, strict=True):
        style = {"cmap": "PuOr", "vmin": -limit, "vmax": limit, "origin": "lower", "aspect": "auto"}
        image = axis.imshow(maps.pulls(simulated), **style)
        axis.set_title(f"pulls {when}")
        figure.colorbar(image, ax=axis, label="pull", location="bottom")
    for region in regions:
        if span := {"row": others[0].axhspan, "column": others[0].axvspan}.get(region.feature or ""):
            # Not clipped, so that the frame of a row at the edge is as thick as any.
            span(region.low, region.high, fill=False, lw=1.5, ec=REGION[region.kind], clip_on=False)
            _beside(others[0], region)
    for axis in (first, *others):
        axis.set_xlabel("column")
        axis.set_ylabel("row")
        axis.grid(visible=False)
    row, column = np.indices(maps.measured.shape)
    table = {"row": row, "column": column, "measured": maps.measured, "error": maps.error}
    for when, simulated in models:
        table |= {f"simulated_{when}": simulated, f"pull_{when}": maps.pulls(simulated)}
    caption = (
        "Mean of the measured images, and cell by cell its difference from the simulated one in standard errors. "
        "Framed: rows and columns that stand out though all were looked at, each with its significance."
    )
    return Drawn("maps", caption, figure, pd.DataFrame({name: values.ravel() for name, values in table.items()}))


def _beside(axis: Axes, region: Region) -> None:
    """Write at the end of a row, or above a column, how much it stands out."""
    middle, of_row = (region.low + region.high) / 2, region.feature == "row"
    at, coordinates = ((1, middle), axis.get_yaxis_transform()) if of_row else ((middle, 1), axis.get_xaxis_transform())
    look = {"ha": "left", "va": "center"} if of_row else {"ha": "center", "va": "bottom"}
    offset = {"textcoords": "offset points", "annotation_clip": False, "fontsize": "small"}
    axis.annotate(sigma(region), at, (3, 0) if of_row else (0, 3), xycoords=coordinates, **look, **offset)


def _theta(task: Task, diagnosis: Diagnosis) -> Drawn:
    fits = {"before": diagnosis.theta_before, "after": diagnosis.theta_after}
    names = list(diagnosis.theta_before)
    units = dict(zip(task.parameter_names, task.parameter_units, strict=True))
    figure = Figure(figsize=(2.6 * len(names), 2.7), layout="constrained")
    rows = []
    for axis, name in zip(np.atleast_1d(figure.subplots(1, len(names))), names, strict=True):
        shown = [(when, theta[name]) for when, theta in fits.items() if theta is not None]
        for place, (when, fitted) in enumerate(shown):
            colour, marker = (BEFORE, "s") if when == "before" else (AFTER, "o")
            axis.errorbar(place, fitted.value, fitted.std, fmt=marker, color=colour, capsize=4)
            rows.append({"parameter": name, "when": when, **fitted.model_dump()})
        axis.set_xticks(range(len(shown)), [when for when, _ in shown])
        axis.set_xlim(-0.5, len(shown) - 0.5)
        unit = units.get(name, "1")
        axis.set_ylabel(name if unit == "1" else f"{name} [{unit}]")
    caption = "The parameters with their errors, fitted without and with the missing effects."
    return Drawn("theta", caption, figure, pd.DataFrame(rows))
