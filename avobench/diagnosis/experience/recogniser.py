"""Which family measured events look like, told by networks that have seen random examples of all.

`python -m paper.studies.experience` makes the examples and trains the networks, whose weights lie beside this file.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from avobench.diagnosis.experience.portrait import MOST_EVENTS, portrait
from avobench.effects import Effect
from avobench.tasks import Task

Kind = Literal["count", "real", "reals"]
"""Of events that there is experience with: one count, one real number, or several."""
SIMULATED = 2
"""Events beside which measured ones are looked at, a measured one."""
LEAST = 0.1
"""Added to the probability of each family: experience excludes none, since simulators may be unlike those it was had
with. On the challenge as many names are right as with a tenth of it."""
LEAST_COUNT = 5.0
"""Of counts, on average, below which there is no experience: hidden shapes of counts are written for means of 5 to 150.
Of fewer, real tables of accidents and claims were taken for what is common among examples."""

Layer = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Weights (a, b) and biases (b,)."""


@dataclass(frozen=True)
class Recogniser:
    """Networks with rectified units, whose probabilities are averaged."""

    families: tuple[str, ...]
    """(k,)"""
    networks: tuple[tuple[Layer, ...], ...]

    def probabilities(self, seen: NDArray[np.float64]) -> dict[str, float]:
        """Of each family, by a portrait (f,)."""
        shares = [softmax(forward(layers, compressed(seen))) for layers in self.networks]
        return dict(zip(self.families, np.mean(shares, axis=0).tolist(), strict=True))

    @classmethod
    @cache
    def of(cls, kind: Kind) -> "Recogniser":
        """The one that is installed."""
        with files(__package__).joinpath(f"{kind}.npz").open("rb") as file, np.load(file) as stored:
            names = tuple(stored["families"].tolist())
            sizes = stored["layers"].tolist()
            layers = [tuple(stored[f"{part}{k}"].astype(float) for part in "wb") for k in range(sum(sizes))]
        ends = np.cumsum(sizes)
        return cls(names, tuple(tuple(layers[end - size : end]) for end, size in zip(ends, sizes, strict=True)))


def compressed(seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """A portrait, or several, on the scale of networks: logarithms beyond 1, of either sign."""
    return np.sign(seen) * np.log1p(np.abs(seen))


def forward(layers: Sequence[Layer], inputs: NDArray[np.float64]) -> NDArray[np.float64]:
    """The outputs (k,) of a network for inputs (f,)."""
    *hidden, (weights, biases) = layers
    for w, b in hidden:
        inputs = np.maximum(inputs @ w + b, 0)
    return inputs @ weights + biases


def kind_of(task: Task) -> Kind | None:
    """What the events of a task are; None where there is no experience with such."""
    kinds = set(task.kinds_of_features)
    if task.event_shape or ("count" in kinds and task.num_features > 1):
        return None
    return "count" if "count" in kinds else "real" if task.num_features == 1 else "reals"


def resemblance(task: Task, effects: Sequence[Effect], x: NDArray, simulated: NDArray) -> dict[str, float]:
    """Logarithm of how much measured events (n, d), beside simulated ones (m, d), look like each family of `effects`.

    Empty where there is no experience with such events. A family without is like the average of the others.
    """
    if (kind := kind_of(task)) is None or (kind == "count" and simulated.mean() < LEAST_COUNT):
        return {}
    seen = Recogniser.of(kind).probabilities(portrait(x[:MOST_EVENTS], simulated, kind == "count"))
    names = list(dict.fromkeys(effect.name for effect in effects))
    known = [seen[name] for name in names if name in seen]
    total = sum(known) or 1.0
    share = [seen[name] / total if name in seen else 1 / max(len(known), 1) for name in names]
    return {name: float(np.log(each + LEAST)) for name, each in zip(names, share, strict=True)}
