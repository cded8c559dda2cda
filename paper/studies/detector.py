"""The detector of Section 4.2: its average response, and single events, at two offsets."""

from pathlib import Path
from typing import Any

import numpy as np

from avobench.bench.cells.streams import stream
from avobench.tasks.alignment import CHUNK, Alignment
from paper.studies.files import StudyFile

FILE = StudyFile("detector")
THETA = (0.0, 1.0)
EVENTS = 200_000
"""Behind each average response (paper, Figure 2): a cell is then known to a few per cent."""
SINGLE_EVENTS = 3
"""Shown by themselves (paper, Figure 2)."""


def made(path: Path, seed: int = 0, num_events: int = EVENTS) -> dict[str, Any]:
    """The detector's response at each of THETA, read from `path` or, if that is missing or of others, made.

    `responses` holds for each theta the `mean` image over `num_events` events, (1024,), and the first SINGLE_EVENTS of
    them as lists of the cells that were hit. No event serves twice. Raises StoreError when the file is damaged.
    """
    task = Alignment()
    identity = {"theta": list(THETA), "num_events": num_events, "seed": seed}
    record = FILE.begun(path, "responses", **identity, task=task.name, task_version=task.version)
    if responses := record["responses"]:
        return record
    rng = stream(seed, "study", "detector")
    for theta in THETA:
        total, events = np.zeros(task.num_features), []
        for start in range(0, num_events, CHUNK):
            x = task.simulate(np.full((min(CHUNK, num_events - start), 1), theta), rng)
            total += x.sum(axis=0, dtype=float)
            events += list(x[: SINGLE_EVENTS - len(events)])
        hits = [np.flatnonzero(event).tolist() for event in events]
        responses.append({"theta": theta, "mean": (total / num_events).tolist(), "events": hits})
    FILE.keep(path, record)
    return record
