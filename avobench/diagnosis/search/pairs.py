"""Two effects added at once, where none alone closes enough."""

from collections.abc import Callable
from dataclasses import replace

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.search.acceptance import PAIR_ALONE, PAIR_CLEAR, PAIR_LEAVES, excess
from avobench.diagnosis.search.ranking import TIE, Ranked, cost
from avobench.diagnosis.search.tested import Step

PARTNERS = 3
"""Effects to which a second one is added at once, where none alone closes enough; each costs a search."""
Rank = Callable[..., tuple[list[Ranked], KnownModel]]
"""That of a Search, `ranked`."""


def best_pair(
    steps: list[Step], search: Rank, worse: Callable[[Fit, Fit], bool]
) -> tuple[list[Step], KnownModel] | None:
    """Two effects that together leave next to nothing, where none alone closes half of the excess.

    Or where one does, but a second beside it is not enough: the pair then begins with that second, or with another that
    the first was tied with.
    """
    null, whole = steps[0], excess(steps[0].fit)
    enough = PAIR_CLEAR * whole
    firsts = [entry for entry in null.ranks if 0 < excess(entry.fit) < (1 - PAIR_ALONE) * whole]
    if len(steps) > 1:
        enough = min(enough, PAIR_LEAVES * excess(steps[1].fit))
        second = [entry.effect.key for entry in steps[1].ranks[:1]]
        firsts = [e for e in firsts if e.effect.key in second or any(e is tie for tie in null.ties)]
    return _beginning_with(firsts[:PARTNERS], enough, null, search, worse)


def _beginning_with(
    firsts: list[Ranked], enough: float, null: Step, search: Rank, worse: Callable[[Fit, Fit], bool]
) -> tuple[list[Step], KnownModel] | None:
    """The best pair that begins with one of these effects and leaves no more than `enough`.

    The steps up to the first of them, with the ranks that the second leads, and the model with the first alone.
    """
    found = [(one, *search(one.fit, max(enough / excess(one.fit), PAIR_CLEAR), one.others)) for one in firsts]
    found = [(first, ranks, known) for first, ranks, known in found if ranks]
    if not found:
        return None
    found.sort(key=lambda each: cost(each[1][0].fit))
    first, ranks, known = found[0]
    best = ranks[0]
    if excess(best.fit) > enough or worse(best.fit, null.fit):
        return None
    rivals = tuple(
        one
        for one, (second, *_), _ in found[1:]
        if second.effect.key == best.effect.key and cost(second.fit) < cost(best.fit) + TIE
    )
    return [replace(null, chosen=first, rivals=rivals), Step(first.fit, first.fit, {}, ranks)], known
