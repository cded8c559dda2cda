"""The null model: the task alone, with theta fitted, to which effects may be added."""

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.scan import scan
from avobench.diagnosis.fit.sharpening import sharpen
from avobench.diagnosis.summary.target import Target, summary_of, target_of
from avobench.effects.model import Model

SCANS = 2
"""From which theta is fitted again before a disagreement is believed."""


def fit_null(
    model: Model, x: NDArray, rng: np.random.Generator, effort: Effort, centre: NDArray[np.float64] | None
) -> tuple[Fit, Target]:
    """Fit theta to events x (N, d), first with bins of the measured events, then with bins that suit both.

    The search begins at `centre` (p,) in the unit cube, or everywhere.
    """
    target, others = target_of(x, summary_of(model.task, x, x), x), x[:0]
    if target.rank == 0:  # measured events are all in one bin: bins beside it take simulated ones
        others = model.simulate(model.from_cube(rng.random((len(x), model.dim))), rng)
        target = target_of(x, summary_of(model.task, x, others), others)
    near = 0.03
    if centre is None:
        centre, near = scan(model, target, rng, size=effort.scan)
    per_round = max(effort.least, int(effort.rounds * len(x)))
    fit = refine(model, target, centre, np.maximum(near, 0.005), rng, num_events=per_round)
    simulated = np.concatenate([model.simulate(np.tile(fit.params, (len(x), 1)), rng), others])
    target = target_of(x, summary_of(model.task, x, simulated), simulated)
    return refine(model, target, fit.point, 0.005, rng, num_events=per_round), target


def best_null(tried: list[Fit], target: Target, rng: np.random.Generator, effort: Effort) -> Fit:
    """The task's own best fit where it does not describe the events, hence where the way to it may have been long.

    From where the fits that were tried ended, of which the first is in the target's metric, and from scans of the whole
    range.
    """
    first, *others = tried
    model, per_round = first.model, max(effort.least, int(effort.rounds * target.num_events))
    starts = [(fit.point, 0.005) for fit in others] + [scan(model, target, rng, size=effort.scan) for _ in range(SCANS)]
    fits = [first] + [
        refine(model, target, start, np.maximum(near, 0.005), rng, num_events=per_round) for start, near in starts
    ]
    # The lowest of a few values is low by chance: it is simulated anew, and that counts.
    best = min(fits, key=lambda fit: fit.noiseless_q)
    return sharpen(best, target, rng, int(effort.sharpen * target.num_events))
