"""Which fits of candidates are the same, and which of them go on."""

import numpy as np

from avobench.diagnosis.fit.fit import Fit

NEARBY = 0.05
"""In cube coordinates: fits of one shape that are closer than that are one."""
CONTINUED = 10
"""Fits that go on beside the best of each family: what bounds the time. Chosen by trial."""


def going_on(fits: list[Fit], expected: list[float]) -> list[Fit]:
    """Of each family the fit that left least and the one of most hope, by what screening expected too; and others."""
    hope = {id(fit): min(fit.noiseless_q, value) for fit, value in zip(fits, expected, strict=True)}
    hopeful = sorted(fits, key=lambda fit: hope[id(fit)])
    firsts = list({fit.model.effects[-1].key: fit for fit in sorted(fits, key=lambda fit: -fit.noiseless_q)}.values())
    for fit in {fit.model.effects[-1].key: fit for fit in reversed(hopeful)}.values():
        if not any(same(fit, one) for one in firsts):
            firsts.append(fit)
    others: list[Fit] = []
    for fit in hopeful:
        if len(others) < CONTINUED and not any(same(fit, one) for one in (*firsts, *others)):
            others.append(fit)
    return [*firsts, *others]


def distinct(fits: list[Fit], most: int | None = None) -> list[Fit]:
    """The best fits of each family that are not the same, and of a family at most so many, of other shapes first."""
    kept: dict[tuple, list[Fit]] = {}
    for fit in sorted(fits, key=lambda fit: fit.noiseless_q):
        own = kept.setdefault(fit.model.effects[-1].key, [])
        if not any(same(fit, one) for one in own):
            own.append(fit)
    for key, own in kept.items():
        shapes = {fit.model.effects[-1].shape: fit for fit in reversed(own)}
        kept[key] = sorted(own, key=lambda fit: all(fit is not one for one in shapes.values()))[:most]
    return sorted((fit for own in kept.values() for fit in own), key=lambda fit: fit.noiseless_q)


def same(fit: Fit, other: Fit) -> bool:
    """Whether two fits are of one shape and close to each other."""
    effect, than = fit.model.effects[-1], other.model.effects[-1]
    if (effect.key, effect.shape) != (than.key, than.shape):
        return False
    return bool(np.abs(fit.point - other.point).max() < NEARBY)
