"""Where cells are carried out: what a sweep asks of it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

from avobench.bench.cells.cell import Cell


class Backend(ABC):
    """Carries out cells in its workers and hands their records back to the sweep.

    The records do not depend on the backend: `trial.Trial` makes them everywhere, with one thread a worker. Where cells
    are carried out together, estimates are the same to floating-point reordering.
    """

    name: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many cells are carried out at a time."""

    @abstractmethod
    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        """The record of each cell as soon as it is finished, cells begun in their order.

        `note` is called with each line that the user should see. A cell whose worker dies is tried again, and recorded
        as crashed when that does not help. Raises AvobenchError when no cell can be carried out any more.
        """

    @abstractmethod
    def shares(self) -> dict[str, float]:
        """Share of the budget used so far by each running cell, by id."""
