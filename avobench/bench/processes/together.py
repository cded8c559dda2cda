"""Cells of one task and method carried out as one piece of work, for methods that gain from knowing all at once."""

import json
from pathlib import Path
from typing import Any

from avobench.bench.cells.cell import Cell
from avobench.bench.processes.local import LocalBackend, Piece

EACH = ("target", "repetition", "theta_true")
"""What may differ between the cells of a piece."""


class TogetherBackend(LocalBackend):
    """Processes of this machine, each given all targets and repetitions of a task and method at once.

    So one batched network may train them all, on a GPU or in fewer and larger matrix products on a CPU; see
    `Method.infer_together`. Cells of methods that do not gain from it are carried out one by one, as in LocalBackend.
    A piece is in memory as a whole, with the observed events of each cell: `most` limits the number of its cells.
    """

    name = "together"

    def __init__(self, jobs: int, marks: Path, most: int | None = None, **options: Any) -> None:
        """`most` cells a piece, all where None; `options` are those of LocalBackend."""
        super().__init__(jobs, marks, **options)
        self._most = most

    def pieces(self, cells: list[Cell]) -> list[Piece]:
        """The pieces in the order of their first cells, those of several cells before all others: they take longest."""
        alike: dict[str, list[Cell]] = {}
        for cell in cells:
            shared = {name: value for name, value in cell.identity.items() if name not in EACH}
            key = json.dumps(shared, sort_keys=True) if cell.together else cell.id
            alike.setdefault(key, []).append(cell)
        pieces = []
        for group in alike.values():
            most = self._most or len(group)
            pieces += [tuple(group[start : start + most]) for start in range(0, len(group), most)]
        return sorted(pieces, key=lambda piece: len(piece) == 1)
