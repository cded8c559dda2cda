"""The figures that are drawn from the records of any store: their names, and how one is drawn by its name."""

import importlib
from pathlib import Path
from typing import Any

from avobench.tasks.errors import StoreError

FIGURES = ("benchmark", "efficiency", "cost", "coverage")
TRACED = ("efficiency",)
"""Drawn from the traces of the records; the others do without, for which there is room in memory for many more."""


def draw(name: str, records: list[dict[str, Any]], folder: Path) -> list[Path]:
    """Draw one figure of FIGURES; raises StoreError when there is nothing to draw or the files cannot be written."""
    module = importlib.import_module(f"avobench.reports.{name}")  # here, because matplotlib takes a second to load
    try:
        return module.draw(records, folder)
    except OSError as error:
        raise StoreError(f"the figure could not be written to {folder}: {error.strerror or error}") from error
