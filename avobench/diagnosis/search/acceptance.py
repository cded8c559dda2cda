"""Whether an effect may be added to a model, and whether a further one is to be looked for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.features import CLOSES
from avobench.diagnosis.search.ranking import TIE, tied
from avobench.diagnosis.search.tested import Step

PAIR_LEAVES = 0.3
"""Share of what the first effect left that a second one may leave. This share and the two next ones were tuned on
the challenge's first series."""
PAIR_CLEAR = 0.1
"""Share below which nothing else is asked of a second effect."""
PAIR_ALONE = 0.2
"""Share of the whole excess that a second effect above the last share must close by itself, unless it has no rival or
leaves no more than chance. A third must have no rival, nor a second where the first may be all."""
CHANCE = 1.65
"""Standard deviations of chi-squared that count as chance: exceeded once in twenty times."""


def accepted(
    steps: list[Step], worse: Callable[[Fit, Fit], bool], clears: Callable[[Fit, Fit], bool], rejected: bool
) -> Step | None:
    """The last step with the effect that may be added to its model, the first of its ranks as a rule; None for none.

    Else the first that clears a feature which no effect acts on yet. `rejected`: whether the model without it must be
    wrong, not only may be.
    """
    last = steps[-1]
    if last.ranks and not worse(last.ranks[0].fit, last.fit) and closes(steps, rejected):
        return last
    for entry in last.ranks:
        if clears(entry.fit, last.fit) and not worse(entry.fit, last.fit):
            feature, within = entry.effect.feature, entry.score + TIE
            rivals = [one for one in last.ranks if one is not entry and one.effect.feature == feature]
            return replace(last, chosen=entry, rivals=tuple(one for one in rivals if one.score < within))
    return None


def closes(steps: list[Step], rejected: bool) -> bool:
    """Whether the first of the last step's ranks closes enough of the whole excess to be added; `rejected` as above."""
    last, whole = steps[-1], excess(steps[0].fit)
    best = last.ranks[0]
    if len(steps) == 1:
        return excess(best.fit) < (1 - CLOSES) * whole
    if last.fit.noiseless_q - best.fit.noiseless_q < TIE + best.fit.noiseless_q_error:
        return False
    share = excess(best.fit) / max(excess(last.fit), 1e-9)
    single = {entry.effect.key: entry.fit for entry in steps[0].ranks}.get(best.effect.key)
    alone = single is not None and whole - excess(single) > PAIR_ALONE * whole
    no_rival, no_more = not tied(last.ranks), excess(best.fit) < CHANCE * scatter(best.fit)
    if (len(steps) > 2 or not rejected) and not no_rival:
        return False
    return share < PAIR_CLEAR or (share < PAIR_LEAVES and (alone or no_rival or no_more))


def shown(step: Step, rejected: bool, alpha: float) -> bool:
    """Whether the summary shows something that one more effect may close: what only the classifier sees has no name."""
    return excess(step.fit) >= TIE if rejected else step.gates["summary"].p_value < alpha


def enough(steps: list[Step], step: Step | None, clears: Callable[[Fit, Fit], bool]) -> bool:
    """Whether no other pair need be looked for: there is an effect to add, and a second leaves no more than chance."""
    if step is None or len(steps) == 1:
        return step is not None
    fit = step.added.fit
    return clears(fit, step.fit) or excess(fit) < CHANCE * scatter(fit)


def excess(fit: Fit) -> float:
    """By how much chi-squared exceeds its degrees of freedom."""
    return max(fit.noiseless_q - fit.dof, 0.0)


def scatter(fit: Fit) -> float:
    """Standard deviation of chi-squared."""
    return float(np.sqrt(2 * fit.dof))
