"""Pictures of each effect, for its page: the distribution of the events without it, and with each of its shapes.

`python -m paper.effect_pictures TASK ...` draws those of some tasks, given as on the command line, for docs/effects.md.
"""

import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avobench.bench.plugins import registry
from avobench.bench.store.files import write_atomically
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.reports.style import MARKERS, PALETTE, STYLE, image, panels
from avobench.tasks import Task

FOLDER = Path("docs/figures/effects")
NUM_EVENTS = 40_000
"""Events of each line, enough that its scatter is no wider than the line."""
NUM_IMAGES = 3000
"""Events of each panel of images, which cost more."""
NUM_BINS = 60
"""Bins of a feature: scatter stays below the width of the line, and a peak a tenth of the range wide is visible."""
MOST_BARS = 60
"""Largest number of bins of counts. If the counts spread over more values, several share a bin."""
MARGIN = 0.15
"""Share of the range that is drawn on either side of it, because an effect may put events there."""
THETA = 0.75
"""The events lie so far along each side of the prior: off the middle, where some tasks are symmetric."""
MIDDLING = 0.12
"""Share of the events that an effect moves to another bin at the strength that is drawn: clear, and no caricature."""
PLACES = (0.7, 0.5, 0.9, 0.3)
"""Where shape parameters lie along their bounds, in the order tried; at the middle a skewness is zero."""
SHARES = tuple(np.geomspace(0.01, 1, 16).tolist())
"""Strengths that are tried in turn, as shares of the way from null to bound."""
IMAGE_SHARE = 0.3
"""The strength for images in the same unit. Their bins show too little to choose it."""
BRIGHTEST = 0.995
"""Quantile of the cells at which the colours of an image end, so that a few noisy cells leave the others their own."""
LINES = 4
"""Lines of a panel. More cannot be distinguished."""
MOST_SHAPES = 12
"""Largest number of shapes that are drawn. From more, this many are chosen evenly."""
LEGEND_BELOW = 4.0
"""Letters' heights that a legend stands below its panel: clear of the numbers and the name of the axis."""
LETTERS = 46
"""Letters of a line of a title, for each panel in a row."""


def draw(task: Task, folder: Path = FOLDER) -> Iterator[Path]:
    """Write TASK-EFFECT.png to `folder` for each effect of a task, of the first feature that it acts on."""
    rng = np.random.default_rng(0)
    events = Pool(task, NUM_IMAGES, rng) if task.generates else None
    plain = Model(task, events=events)
    view = View(plain, NUM_IMAGES if task.event_shape else NUM_EVENTS)
    families: dict[str, list[Effect]] = {}
    for effect in catalogue(task) if task.event_shape else catalogue(task, view.plain):
        families.setdefault(effect.name, []).append(effect)
    for effect, *others in families.values():
        own = [effect, *(other for other in others if other.key == effect.key)]
        # What an image shows of faulty cells is nothing, where there are none.
        shapes = [shape for e in own for shape in (e if task.event_shape else e.adapted(view.plain)).shapes()]
        chosen = np.unique(np.linspace(0, len(shapes) - 1, min(len(shapes), MOST_SHAPES)).round().astype(int))
        made = [(view.images if task.event_shape else view.middling)(shapes[k]) for k in chosen]
        with matplotlib.rc_context(STYLE | ({"axes.grid": False} if task.event_shape else {})):
            figure = (_images if task.event_shape else _lines)(view, made)
            _titled(figure, task, effect, len(chosen), len(shapes))
            name = f"{task.name}-{effect.name.replace('_', '-')}.png"
            yield write_atomically(folder / name, image(figure, "png"))


@dataclass(frozen=True)
class Drawn:
    """An effect at a strength, and the events that it makes."""

    effect: Effect
    phi: NDArray[np.float64]
    """(q,)"""
    x: NDArray
    """(N, d)"""

    @property
    def label(self) -> str:
        values = [f"{p.name} = {v:.2g}" for p, v in zip(self.effect.parameters, self.phi, strict=True)]
        return f"{self.effect.shape}: {', '.join(values)}" if self.effect.shape else ", ".join(values)

    @property
    def column(self) -> int:
        return self.effect.feature if isinstance(self.effect.feature, int) else 0


class View:
    """Events of a task at one theta, without and with an effect, and the bins to see them in."""

    def __init__(self, model: Model, num_events: int) -> None:
        self.model = model
        prior = model.task.prior
        self.theta = np.tile(np.array(prior.low) + THETA * prior.width, (num_events, 1))
        self.plain = self._events(model, np.empty(0))

    def _events(self, model: Model, phi: NDArray[np.float64]) -> NDArray:
        params = np.hstack([self.theta, np.tile(phi, (len(self.theta), 1))])
        return model.simulate(params, np.random.default_rng(0))

    @cached_property
    def _edges(self) -> list[NDArray[np.float64]]:
        """Edges of the bins of each feature. Counts have one bin each, from zero on."""
        edges = []
        for column, kind in zip(self.plain.T, self.model.task.kinds_of_features, strict=True):
            if kind == "count":
                top = int(1.6 * np.quantile(column, 0.999)) + 2
                edges.append(np.arange(0, top + 1, -(-top // MOST_BARS)) - 0.5)
            else:
                low, high = np.quantile(column, [0.001, 0.999])
                margin = MARGIN * (high - low)
                edges.append(np.linspace(low - margin, high + margin, NUM_BINS + 1))
        return edges

    def shares(self, x: NDArray, column: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Edges (k + 1,) and the share of the events (N, d) in each bin (k,)."""
        edges = self._edges[column]
        return edges, np.histogram(x[:, column], edges)[0] / len(x)

    def hits(self, x: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Edges and shares of the number of cells that an image hits."""
        most = int((self.plain > 0).sum(axis=1).max())
        edges = np.arange(0, 1.5 * most, max(1, most // 20)) - 0.5
        return edges, np.histogram((x > 0).sum(axis=1), edges)[0] / len(x)

    def middling(self, effect: Effect) -> Drawn:
        """The events at the first strength that moves enough of them, or else at the one that moves most."""
        model = self.model.plus(effect)
        tried: list[tuple[float, Drawn]] = []
        for place in PLACES:
            for share in SHARES:
                made = self._at(model, effect, place, share)
                tried.append((self._moved(made), made))
                if tried[-1][0] >= MIDDLING:
                    return made
        return max(tried, key=lambda each: each[0])[1]

    def images(self, effect: Effect) -> Drawn:
        """The images at a fixed share of the way to the bound of the strength."""
        return self._at(self.model.plus(effect), effect, PLACES[0], IMAGE_SHARE)

    def _at(self, model: Model, effect: Effect, place: float, share: float) -> Drawn:
        strength, start = effect.parameters[0], self.model.dim
        unit = np.full((1, model.dim), place)
        phi = model.from_cube(unit)[0, start:]
        bound = strength.high if strength.high != strength.null else strength.low
        phi[0] = strength.null + share * (bound - strength.null)
        return Drawn(effect, phi, self._events(model, phi))

    def _moved(self, made: Drawn) -> float:
        """The share of the events that an effect moves to another bin, or out of all bins."""
        (_, before), (_, after) = (self.shares(x, made.column) for x in (self.plain, made.x))
        outside = before.sum() - after.sum()
        return float(np.abs(after - before).sum() + abs(outside)) / 2


def _lines(view: View, made: list[Drawn]) -> Figure:
    """The share of events in bins of a feature: an area without the effect, a line for each shape."""
    rows = [made[k : k + LINES] for k in range(0, len(made), LINES)]
    figure, axes = panels([""] * len(rows), columns=len(rows), size=(4.6, 3.6))
    for axis, row in zip(axes, rows, strict=True):
        edges, before = view.shares(view.plain, row[0].column)
        axis.stairs(before, edges, fill=True, color="0.82", label="without")
        for k, each in enumerate(row):
            _outline(axis, edges, view.shares(each.x, each.column)[1], k, each.label)
        axis.set(xlabel=view.model.task.labels[row[0].column], ylabel="share of events", xlim=(edges[0], edges[-1]))
        below = {"loc": "upper center", "bbox_to_anchor": (0.5, 0), "borderaxespad": LEGEND_BELOW}
        axis.legend(fontsize="small", handlelength=1.6, **below)
    return figure


def _outline(axis: Axes, edges: NDArray, shares: NDArray, k: int, label: str) -> None:
    colour, middle = PALETTE[(0, 1, 2, 4)[k]], (edges[1:] + edges[:-1]) / 2
    marks = {"marker": MARKERS[k], "markersize": 4, "markevery": (3 * k, 12)}
    axis.plot(middle, shares, color=colour, lw=1.3, drawstyle="steps-mid", label=label, **marks)


def _images(view: View, made: list[Drawn]) -> Figure:
    """The average image without and with each shape, their difference, and how many cells an image hits."""
    shape = view.model.task.event_shape
    titles = ["average image without", *(f"with {each.label}" for each in made)]
    titles += ["number of cells hit", *("difference" for _ in made)]
    wrapped = ["\n".join(textwrap.wrap(title, 30)) for title in titles]
    figure, axes = panels(wrapped, columns=1 + len(made), size=(3.6, 3.2))
    means = [x.mean(axis=0).reshape(shape) for x in (view.plain, *(each.x for each in made))]
    top = np.quantile(means, BRIGHTEST)
    for axis, mean in zip(axes, means, strict=False):
        shown = axis.imshow(mean, origin="lower", cmap="viridis", vmin=0, vmax=top)
        figure.colorbar(shown, ax=axis)
    for axis, mean in zip(axes[len(means) + 1 :], means[1:], strict=True):
        most = max(float(np.quantile(np.abs(mean - means[0]), BRIGHTEST)), 1e-9)
        figure.colorbar(axis.imshow(mean - means[0], origin="lower", cmap="RdBu_r", vmin=-most, vmax=most), ax=axis)
    histogram = axes.pop(len(means))
    for axis in axes:
        axis.set(xlabel="column", ylabel="row")
    edges, before = view.hits(view.plain)
    histogram.stairs(before, edges, fill=True, color="0.82", label="without")
    for k, each in enumerate(made):
        _outline(histogram, edges, view.hits(each.x)[1], k, f"with {each.effect.shape}".strip())
    histogram.set(xlabel="cells hit by an event", ylabel="share of events")
    histogram.legend(fontsize="small")
    return figure


def _titled(figure: Figure, task: Task, effect: Effect, drawn: int, shapes: int) -> None:
    feature = task.labels[effect.feature] if isinstance(effect.feature, int) else effect.feature
    feature = "" if feature in (None, "all") else f" of {feature}"
    some = "" if drawn == shapes else f" ({drawn} of its {shapes} shapes)"
    text = f"{effect.name}{feature} on {task.name}{some}: {effect.sentence}"
    letters = int(LETTERS * figure.get_figwidth() / 4.6)
    figure.suptitle("\n".join(textwrap.wrap(text, letters)), fontsize="medium")


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for spec in sys.argv[1:]:
        for path in draw(registry.build("task", spec, {})):
            print(path)
