"""All effects that apply to a task: of each installed family, ours and those of other distributions, its entries."""

from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import entry_points

from numpy.typing import NDArray

from avobench.effects.continuous.recording import LostValue
from avobench.effects.contract import Effect
from avobench.effects.site import Domain, Site, domain
from avobench.tasks import Task
from avobench.tasks.errors import UsageError, did_you_mean, raised

__all__ = ["catalogue", "chosen", "domain", "families", "of_domain"]

GROUP = "avobench.effects"
"""Entry points are named by domain, a dot, and what each is. Classes of one family, as `continuous.truncation` and
`edge_acceptance`, have each their own."""


@cache
def families() -> dict[str, type[Effect]]:
    """The installed families by their entry points, looked for once a process. Raises UsageError."""
    installed = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            family = point.load()
        except (Exception, SystemExit) as error:
            raise UsageError(f"effect '{point.name}' cannot be used, {point.value} raised {raised(error)}") from error
        if not (isinstance(family, type) and issubclass(family, Effect) and family.domains):
            raise UsageError(f"effect '{point.name}': {point.value} is no subclass of Effect that states its domains")
        installed[point.name] = family
    if not installed:
        raise UsageError("no effect is installed: this checkout is newer than its installation; pip install it again")
    return installed


def of_domain(*kinds: Domain) -> list[type[Effect]]:
    """The families for features of any of these kinds, in the order of the catalogue."""
    matching = {family: None for family in families().values() if not set(kinds).isdisjoint(family.domains)}
    return sorted(matching, key=lambda family: (family.position is None, family.position or 0, family.name))


def catalogue(task: Task, x: NDArray | None = None, made: Callable[[], NDArray] | None = None) -> list[Effect]:
    """Every effect that applies to `task`: one entry a class and feature, each in its plainest shape.

    Classes of one family have the same name; no two of their shapes have. Ranges of features are those that events x
    (N, d) show, or those of simulated events (n, d) over the prior, which `made` gives.
    """
    site = Site(task, x, made)
    classes = [*of_domain(*site.domains), *([LostValue] if task.missing else [])]
    return [entry for family in classes for entry in family.entries(site)]


def chosen(effects: Iterable[Effect], names: Iterable[str], task: str) -> list[Effect]:
    """The effects of these names, of families or of entry points, in their own order. Raises UsageError.

    `task` is what the user calls the task.
    """
    effects = list(effects)
    all_names = dict.fromkeys(name for effect in effects for name in _names(effect))
    wanted = {name.rpartition(".")[2]: name for name in names}
    for name, given in wanted.items():
        if name not in all_names:
            hint = [did_you_mean(name, all_names, n=3, cutoff=0.5), f"`avobench list effects --task {task}` shows all"]
            raise UsageError(f"there is no effect '{given}' for {task}; {' '.join(filter(None, hint))}")
    return [effect for effect in effects if wanted.keys() & set(_names(effect))]


def _names(effect: Effect) -> list[str]:
    return [effect.name, *(point.rpartition(".")[2] for point, family in families().items() if family is type(effect))]
