"""What a claim of the paper is here, and what it is held against."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from avobench.reports.style import METHOD_ORDER, ordered


@dataclass(frozen=True)
class Evidence:
    """All records that the claims are held against."""

    benchmark: pd.DataFrame
    """Comparable cells of the benchmark, see `labelled`."""
    study: list[dict[str, Any]]
    detector: dict[str, Any]
    ablation: list[dict[str, Any]] = field(default_factory=list)
    baseline: dict[str, Any] = field(default_factory=dict)
    misspecification: dict[str, Any] = field(default_factory=dict)

    def task(self, name: str) -> dict[str, pd.DataFrame]:
        """The cells of a task by method, in the figures' order."""
        cells = self.benchmark[self.benchmark["task"] == name]
        return {method: cells[cells["method"] == method] for method in ordered(cells["method"], METHOD_ORDER)}


@dataclass(frozen=True)
class Finding:
    """What was measured for a claim."""

    verdict: str
    """A few words: reproduced, not reproduced, differs, for each preset where it matters."""
    reading: str
    """The criterion, and what to make of the numbers."""
    numbers: pd.DataFrame


@dataclass(frozen=True)
class Claim:
    title: str
    where: str
    says: str
    commands: tuple[str, ...]
    find: Callable[[Evidence], Finding]
    why: str = ""
    """What is known of the reason, whatever the numbers."""
