"""The scales on which the strengths of this series are meant."""

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Place


def mean_count(place: Place) -> float:
    return max(float(place.reference[:, place.columns].mean()), 1.0)


def root(place: Place) -> float:
    """The Poisson fluctuation of a typical count."""
    return float(np.sqrt(mean_count(place)))


def count_above(place: Place, share: float) -> int:
    """The count that a share of the reference exceeds."""
    return int(np.quantile(place.reference[:, place.columns], 1 - share, method="lower"))


def dithered(x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """To whole counts, up or down in proportion to what is between them, and not below zero."""
    return np.maximum(np.floor(x + rng.random(x.shape)), 0)


def unit(place: Place, columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """The columns of the place on the scale where the range is [-1, 1]."""
    return (columns - place.centre) / place.half_range


def value(place: Place, units: NDArray[np.float64]) -> NDArray[np.float64]:
    """Back from the scale where the range is [-1, 1]."""
    return place.centre + place.half_range * units


def single(place: Place) -> bool:
    """Whether it is one feature, a cosine or another."""
    return isinstance(place.feature, int)


def real(place: Place) -> bool:
    """Whether it is one feature that is not a cosine."""
    return single(place) and not place.cosine


def positive(place: Place) -> bool:
    """Whether it is one feature that is never negative."""
    return real(place) and bool((place.reference[:, place.columns] >= 0).all())


def one_of_many(place: Place) -> bool:
    """Whether it is one feature that has others beside it."""
    return real(place) and place.reference.shape[1] > 1


def standardised(place: Place, x: NDArray, column: int) -> NDArray[np.float64]:
    """Any feature of the event less its mean, in units of its standard deviation."""
    reference = place.reference[:, column]
    return (x[:, column] - reference.mean()) / reference.std()


def cotangent(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where a track crosses a cylinder of radius one, along its axis."""
    return cosine / np.sqrt(np.maximum(1 - cosine**2, 1e-12))


def cosine_of(cotangent: NDArray[np.float64]) -> NDArray[np.float64]:
    return cotangent / np.sqrt(1 + cotangent**2)
