"""A backend carries out cells for a sweep, and a cell tells it by a heartbeat how far it is."""

import dataclasses
import json
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

from avobench.bench.cells.cell import Cell

HEARTBEAT_SECONDS = 1.0
"""A cell tells this often how far it is: as often as the display is drawn."""
ATTEMPTS = 2
"""A cell is recorded as crashed when it has lost its worker so often."""
_SAME: set[str] = set()
"""The tasks and methods, with their identities, that were found in this process as they were planned."""


class Backend(ABC):
    """Carries out cells in its workers and hands their records back to the sweep.

    The records do not depend on the backend: `trial.Trial` makes them everywhere, with one thread a worker. Where cells
    are carried out together, estimates are the same to floating-point reordering.
    """

    name: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """The number of cells that are carried out at a time."""

    @abstractmethod
    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        """The record of each cell as soon as it is finished, cells begun in their order.

        `note` is called with each line that the user should see. A cell whose worker dies is tried again, and recorded
        as crashed when that does not help. Raises AvobenchError when no cell can be carried out any more.
        """

    @abstractmethod
    def shares(self) -> dict[str, float]:
        """Share of the budget used so far by each running cell, by id."""


def heartbeat(cell: Cell, tell: Callable[[float], None]) -> Callable[[int], None]:
    """A function of the events that a cell has used, which lets `tell` know the share of its budget now and then."""
    last = 0.0

    def beat(used: int) -> None:
        nonlocal last
        if time.monotonic() - last >= HEARTBEAT_SECONDS:
            last = time.monotonic()
            tell(used / cell.budget)

    tell(0)
    return beat


def differing(cell: Cell) -> str:
    """The task or method that is another one in this process than the cell was planned with, in words; "" if none is.

    They are compared at their first cell only: an object may change what it holds while it works.
    """
    planned = {kind: _identity(kind, cell, cell.identity) for kind in ("task", "method")}
    new = [kind for kind in planned if planned[kind] not in _SAME]
    remade = dataclasses.replace(cell).identity if new else {}  # made anew from what this process imports
    for kind in new:
        if _identity(kind, cell, remade) != planned[kind]:
            return f"{kind} '{getattr(cell, kind)}'"
        _SAME.add(planned[kind])
    return ""


def _identity(kind: str, cell: Cell, identity: dict[str, Any]) -> str:
    parts = {name: value for name, value in identity.items() if name.startswith(kind)}
    return json.dumps([getattr(cell, kind), parts], sort_keys=True)
