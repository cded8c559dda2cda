"""The figures of a diagnosis. Distinctions by colour are repeated in line style, marker or position."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from avobench.diagnosis.answer.pictures import Maps, Pictures, Spectrum
from avobench.diagnosis.schema import Diagnosis, FoundEffect, Named
from avobench.reports.style import PALETTE, STYLE, save
from avobench.tasks import Task

FIGURE = re.compile(r"(maps|distribution-\d+|gap|theta|candidates)\.(pdf|png|csv)")
"""The file of a figure."""
BEFORE, AFTER, REGION = PALETTE[1], PALETTE[0], {"excess": PALETTE[2], "deficit": PALETTE[4]}
HATCH = {"excess": "//", "deficit": "\\\\"}
MOST_CANDIDATES = 20
STEEP = 5.0
"""A density whose highest bin is so many times the middle one is drawn on a logarithmic axis."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """A figure, the numbers that it shows, and what a reader is told about it."""

    name: str
    caption: str
    figure: Figure
    table: pd.DataFrame

    def save(self, folder: Path) -> list[Path]:
        """As .pdf, .png and .csv."""
        return save(self.figure, self.table, folder, self.name)


def draw(task: Task, diagnosis: Diagnosis, pictures: Pictures) -> list[Drawn]:
    """All figures that the diagnosis has something to show in."""
    with matplotlib.rc_context(STYLE):
        return list(_figures(task, diagnosis, pictures))


def _figures(task: Task, diagnosis: Diagnosis, pictures: Pictures) -> Iterator[Drawn]:
    if pictures.maps is not None:
        yield _maps(pictures.maps, diagnosis)
    for number, spectrum in enumerate(pictures.spectra, start=1):
        yield _distribution(spectrum, diagnosis, f"distribution-{number}")
    yield _gap(diagnosis)
    yield _theta(task, diagnosis)
    if diagnosis.candidates:
        yield _candidates(diagnosis)


def label(effect: Named) -> str:
    """`name` or `name of feature`."""
    return effect.name if effect.feature is None else f"{effect.name} of {effect.feature}"


def _distribution(spectrum: Spectrum, diagnosis: Diagnosis, name: str) -> Drawn:
    models = [("before", BEFORE, "--", spectrum.before)]
    if spectrum.after is not None:
        models.append(("after", AFTER, "-", spectrum.after))
    figure = Figure(figsize=(6.4, 3.2 + 1.1 * len(models)), layout="constrained")
    top, *below = figure.subplots(1 + len(models), 1, sharex=True, height_ratios=[3] + [1] * len(models))
    edges, width = spectrum.edges, np.diff(spectrum.edges)
    for when, colour, style, share in models:
        top.stairs(share / width, edges, color=colour, ls=style, lw=1.4, label=f"simulated, {when}")
    measured, error = spectrum.measured / width, spectrum.error / width
    centres = (edges[1:] + edges[:-1]) / 2
    top.errorbar(centres, measured, error, fmt="o", color="black", ms=2.5, lw=0.8, label="measured")
    top.set_ylabel("probability density")
    if measured.max() > STEEP * np.median(measured):
        top.set_yscale("log", nonpositive="mask")
    else:
        top.set_ylim(bottom=0)
    for region in diagnosis.regions:
        if region.feature in (spectrum.feature, None):
            for axis in (top, below[0]):
                colour, own = REGION[region.kind], {"hatch": HATCH[region.kind], "label": region.kind, "lw": 0}
                axis.axvspan(region.low, region.high, fc=(*colour, 0.15), ec=(*colour, 0.5), **own)
    for axis, (when, colour, _, share) in zip(below, models, strict=True):
        pulls = spectrum.pulls(share)
        axis.axhspan(-2, 2, color="0.85", lw=0)
        axis.stairs(pulls, edges, baseline=0, fill=True, color=colour, alpha=0.8)
        axis.set_ylabel(f"pull\n{when}")
        limit = max(4, 1.1 * np.abs(pulls).max())
        axis.set_ylim(-limit, limit)
    below[-1].set_xlabel(spectrum.feature)
    top.set_xlim(edges[0], edges[-1])
    handles, labels = top.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))  # several regions of a kind are one entry
    top.legend(once.values(), once.keys())
    columns = {"low": edges[:-1], "high": edges[1:], "measured": spectrum.measured, "error": spectrum.error}
    for when, _, _, share in models:
        columns |= {f"simulated_{when}": share, f"pull_{when}": spectrum.pulls(share)}
    caption = (
        f"Measured and simulated {spectrum.feature}. Pulls are differences in standard errors, the band spans 2. "
        "Hatched: regions that stand out though all were looked at."
    )
    return Drawn(name, caption, figure, pd.DataFrame(columns))


def _maps(maps: Maps, diagnosis: Diagnosis) -> Drawn:
    models = [("before", maps.before)]
    if maps.after is not None:
        models.append(("after", maps.after))
    figure = Figure(figsize=(3.2 * (1 + len(models)), 3.2), layout="constrained")
    first, *others = figure.subplots(1, 1 + len(models))
    image = first.imshow(maps.measured, cmap="cividis", origin="lower", aspect="auto")
    figure.colorbar(image, ax=first, label="mean of a cell", location="bottom")
    first.set_title("measured")
    limit = max(4.0, float(np.abs(maps.pulls(maps.before)).max()))
    for axis, (when, simulated) in zip(others, models, strict=True):
        style = {"cmap": "PuOr", "vmin": -limit, "vmax": limit, "origin": "lower", "aspect": "auto"}
        image = axis.imshow(maps.pulls(simulated), **style)
        axis.set_title(f"pulls {when}")
        figure.colorbar(image, ax=axis, label="pull", location="bottom")
    for region in diagnosis.regions:
        if span := {"row": others[0].axhspan, "column": others[0].axvspan}.get(region.feature or ""):
            style = {"fill": False, "lw": 1.5, "ec": REGION[region.kind]}
            span(region.low, region.high, **style)
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
        "Framed: rows and columns that stand out though all were looked at."
    )
    return Drawn("maps", caption, figure, pd.DataFrame({name: values.ravel() for name, values in table.items()}))


def _gap(diagnosis: Diagnosis) -> Drawn:
    gaps = {"before": diagnosis.gap_before, "after": diagnosis.gap_after}
    shown = {when: gap for when, gap in gaps.items() if gap is not None}
    figure = Figure(figsize=(3.2, 2.7), layout="constrained")
    axis = figure.subplots()
    for place, (when, gap) in enumerate(shown.items()):
        error = [[max(gap.value - gap.low, 0)], [max(gap.high - gap.value, 0)]]
        colour, marker = (BEFORE, "s") if when == "before" else (AFTER, "o")
        axis.errorbar(place, gap.value, error, fmt=marker, color=colour, capsize=4)
        axis.annotate(f"{gap.value:.3g}", (place, gap.value), (8, 0), textcoords="offset points", va="center")
    axis.axhline(1, color="0.3", ls=":", lw=1)
    if max(gap.value for gap in shown.values()) > 10:
        axis.set_yscale("log")
    axis.set_xticks(range(len(shown)), list(shown))
    axis.set_xlim(-0.5, len(shown) - 0.5)
    axis.set_ylabel(r"$\chi^2$ / ndf of held-out events")
    rows = [{"when": when, **gap.model_dump()} for when, gap in shown.items()]
    caption = "How far the simulation is from events that no fit has seen; the dotted line is where nothing is missing."
    return Drawn("gap", caption, figure, pd.DataFrame(rows))


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


def _candidates(diagnosis: Diagnosis) -> Drawn:
    order = sorted(diagnosis.candidates, key=lambda candidate: candidate.score)
    shown = order[:MOST_CANDIDATES]
    chosen, tied = _chosen(diagnosis.effects)
    figure = Figure(figsize=(6.4, 0.8 + 0.24 * len(shown)), layout="constrained")
    axis = figure.subplots()
    kinds = {"named": (AFTER, "o"), "tied with it": (PALETTE[2], "D"), "another": ("0.6", "s")}
    kind_of = {
        id(each): "named" if label(each) in chosen else "tied with it" if label(each) in tied else "another"
        for each in shown
    }
    for kind, (colour, marker) in kinds.items():
        own = [(each.score, place) for place, each in enumerate(shown) if kind_of[id(each)] == kind]
        if own:
            axis.plot(*zip(*own, strict=True), marker, color=colour, label=kind, ls="")
    axis.set_yticks(range(len(shown)), [label(each) for each in shown])
    axis.invert_yaxis()
    axis.set_xlabel("score, lower is better")
    axis.legend()
    rows = [{**each.model_dump(), "shown_as": kind_of.get(id(each), "not shown")} for each in order]
    left_out = f" The best {len(shown)} of {len(order)} are shown." if len(order) > len(shown) else ""
    caption = "Every effect that was tried, by its score. Those that these data cannot tell apart are marked as tied."
    return Drawn("candidates", caption + left_out, figure, pd.DataFrame(rows))


def _chosen(effects: list[FoundEffect]) -> tuple[set[str], set[str]]:
    """Labels of the named effects, and of those tied with any of them."""
    return {label(effect) for effect in effects}, {label(rival) for effect in effects for rival in effect.tied_with}
