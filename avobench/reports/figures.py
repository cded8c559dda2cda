"""The figures that are drawn from records: their names, what each reads, and how one is drawn by its name."""

import importlib
from pathlib import Path
from typing import Any

from avobench.bench.store.store import Store
from avobench.tasks.errors import StoreError
from paper.studies import misspecification, paper

FIGURES = (
    "benchmark",
    "weinberg",
    "efficiency",
    "cost",
    "poisson",
    "alignment",
    "detector",
    "dimension",
    "coverage",
    "misspecification",
)
STUDY_FIGURES = ("poisson", "alignment", "detector")
"""Drawn from the records of the paper's experiment of that name."""
FOLDERS = dict.fromkeys((*STUDY_FIGURES, "misspecification"), Path("results/studies")) | {
    "dimension": Path("results/dimension")
}
"""Where the records of a figure are, unless it is told; those of the others are a benchmark's."""
ONE_FILE = {"detector": paper.read_detector, "misspecification": misspecification.read}
"""Of the figures that are drawn from a file of their own, what reads it."""
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
    """What the figure `name` draws: the records of the store, or the one of a study. Raises StoreError."""
    return [ONE_FILE[name](store.path)] if name in ONE_FILE else store.read_all(traces=name in TRACED)
