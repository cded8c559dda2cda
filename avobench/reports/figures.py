"""The figures that are drawn from the records of any store: their names, and how one is drawn by its name."""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avobench.bench.store.files import disk_errors

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

FIGURES = ("benchmark", "efficiency", "coverage")
TRACED = ("efficiency",)
"""Drawn from the traces of the records; the others do without, for which there is room in memory for many more."""


def draw(name: str, records: list[dict[str, Any]], folder: Path) -> list[Path]:
    """Write one figure of FIGURES and its numbers to `folder`, as `name`.pdf, .png and .csv.

    Raises StoreError when there is nothing to draw or the files cannot be written.
    """
    from avobench.reports.style import save

    with disk_errors(f"the figure could not be written to {folder}"):
        return save(*drawn(name, records), folder, name)


def drawn(name: str, records: list[dict[str, Any]]) -> "tuple[Figure, pd.DataFrame]":
    """One figure of FIGURES and the numbers that it shows; raises StoreError when there is nothing to draw."""
    import matplotlib  # here, because it takes a second to load

    from avobench.reports.style import STYLE

    with matplotlib.rc_context(STYLE):
        return importlib.import_module(f"avobench.reports.{name}").drawn(records)
