"""The one look of all figures: theme, order and colours of tasks and methods, and how a figure is written."""

import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import matplotlib
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avobench.bench.store.files import write_atomically

TASK_ORDER = ("poisson", "carl", "weinberg", "alignment")
METHOD_ORDER = ("avo", "avo-paper", "abc-smc", "bolfi")
"""The paper's orders; whatever else is in the records follows by name."""

PALETTE = sns.color_palette("colorblind", 10)
"""Told apart with the common forms of colour blindness; figures repeat the distinction in markers or positions."""
METHOD_COLOURS = dict(zip(METHOD_ORDER, (PALETTE[0], PALETTE[9], PALETTE[1], PALETTE[2]), strict=True))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
TRUTH, FLOOR = "0.15", "0.35"
"""Greys of what is not a method."""

STYLE = {
    **sns.axes_style("whitegrid"),
    **sns.plotting_context("paper", font_scale=1.1),
    "axes.edgecolor": "0.6",
    "grid.color": "0.9",
    "legend.frameon": False,
    "pdf.fonttype": 42,  # letters stay letters
}
PANEL = (3.2, 2.7)
"""Inches of a panel; two beside each other fill a page's text, and stay legible on a phone."""


def ordered(labels: Iterable[str], order: tuple[str, ...]) -> list[str]:
    """Distinct labels, first those whose name is in `order`."""
    place = {name: index for index, name in enumerate(order)}
    return sorted(set(labels), key=lambda label: (place.get(label.split()[0], len(place)), label))


def colours(methods: Iterable[str]) -> dict[str, Any]:
    """A colour for each method: the paper's have theirs in every figure, others take what is left, by name."""
    fixed = {method: METHOD_COLOURS[method] for method in methods if method in METHOD_COLOURS}
    others = ordered(set(methods) - set(fixed), METHOD_ORDER)
    free = [colour for colour in PALETTE if colour not in fixed.values()]
    free.sort(key=lambda colour: colour in METHOD_COLOURS.values())  # those of methods that are not here come last
    return fixed | {method: free[index % len(free)] for index, method in enumerate(others)}


def panels(titles: list[str], columns: int = 2, size: tuple[float, float] = PANEL) -> tuple[Figure, list[Axes]]:
    """A figure with a panel for each title."""
    columns = min(columns, len(titles))
    rows = -(-len(titles) // columns)
    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).flatten()
    for axis, title in zip(axes, titles, strict=False):
        axis.set_title(title)
    for axis in axes[len(titles) :]:
        axis.set_visible(False)
    return figure, list(axes[: len(titles)])


def by_task(table: pd.DataFrame, tasks: Iterable[str], draw: Callable[[Axes, pd.DataFrame, list[str]], None]) -> Figure:
    """A figure in which `draw` fills a panel of each task with its rows; of the methods and the floor is one legend."""
    tasks, methods = ordered(tasks, TASK_ORDER), ordered(table["method"], METHOD_ORDER)
    figure, axes = panels(tasks)
    for axis, task in zip(axes, tasks, strict=True):
        rows = table[table["task"] == task]
        if rows.empty:
            note(axis, "no cell has an estimate")
        else:
            draw(axis, rows, methods)
    legend_below(figure, axes, (*methods, "floor"))
    return figure


def legend_below(figure: Figure, axes: Iterable[Axes], names: Iterable[str], columns: int = 5) -> None:
    """One legend for all panels, of these names as far as one of them has each."""
    handles = {name: handle for axis in axes for handle, name in zip(*axis.get_legend_handles_labels(), strict=True)}
    shown = [name for name in names if name in handles]
    figure.legend([handles[name] for name in shown], shown, loc="outside lower center", ncols=min(columns, len(shown)))


def note(axis: Axes, text: str) -> None:
    axis.text(0.5, 0.5, text, ha="center", va="center", transform=axis.transAxes)
    axis.set(xticks=[], yticks=[])


def save(figure: Figure, table: pd.DataFrame, folder: Path, name: str) -> list[Path]:
    """Write `name`.pdf, .png and, with the numbers drawn, .csv to `folder`, each whole or not at all."""
    contents = (("pdf", image(figure, "pdf")), ("png", image(figure, "png")), ("csv", csv(table)))
    return [write_atomically(folder / f"{name}.{suffix}", content) for suffix, content in contents]


def image(figure: Figure, suffix: str) -> bytes:
    options = {"pdf": {"metadata": {"CreationDate": None}}, "png": {"dpi": 200}}[suffix]
    content = io.BytesIO()
    with matplotlib.rc_context(STYLE):  # some of it is read only now
        figure.savefig(content, format=suffix, **options)
    return content.getvalue()


def csv(table: pd.DataFrame) -> bytes:
    return table.to_csv(index=False, float_format="%.6g").encode()
