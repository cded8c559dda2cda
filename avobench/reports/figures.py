"""The figures that are drawn from records: their names, what each reads, and how one is drawn by its name."""

import importlib
from pathlib import Path
from typing import Any

from avobench.bench.store import Store
from avobench.studies import paper as study
from avobench.tasks.errors import StoreError

FIGURES = ("benchmark", "weinberg", "efficiency", "cost", "poisson", "alignment", "detector", "dimension", "coverage")
STUDY_FIGURES = ("poisson", "alignment", "detector")
"""Drawn from the records of the paper's experiment of that name."""
FOLDERS = {**dict.fromkeys(STUDY_FIGURES, Path("results/studies")), "dimension": Path("results/dimension")}
"""Where the records of a figure are, unless it is told; those of the others are a benchmark's."""
TRACED = ("efficiency", *STUDY_FIGURES)
"""Drawn from the traces of the records; the others do without, for which there is room in memory for many more."""


def draw(name: str, records: list[dict[str, Any]], folder: Path) -> list[Path]:
    """Draw one figure of FIGURES; raises StoreError when there is nothing to draw or the files cannot be written."""
    module = importlib.import_module(f"avobench.reports.{name}")  # here, because matplotlib takes a second to load
    try:
        return module.draw(records, folder)
    except OSError as error:
        raise StoreError(f"the figure could not be written to {folder}: {error.strerror or error}") from error


def records_for(name: str, store: Store) -> list[dict[str, Any]]:
    """What the figure `name` draws: the records of the store, or the one of the study `detector`. Raises StoreError."""
    return [study.read_detector(store.path)] if name == "detector" else store.read_all(traces=name in TRACED)
