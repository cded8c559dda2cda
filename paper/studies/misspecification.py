"""What adversarial inference does where the simulator is wrong, beside what the diagnosis says of it.

The paper expects the proposal to smear a simulator that is too sharp. Here the parameters of the observed events vary
from event to event: a proposal of that width, averaged over, gives exactly the observed distribution.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.streams import stream
from avobench.bench.plugins import registry
from avobench.diagnosis.run import diagnose
from avobench.methods.avo import Avo
from paper.experiments import BUDGET, NUM_OBSERVATIONS
from paper.studies.files import StudyFile

FILE = StudyFile("misspecification")
TASKS = ("poisson", "carl")
"""One with a count for an event, one with five features."""
STRENGTHS = (0.0, 0.01, 0.03, 0.1, 0.3)
"""Standard deviation of each parameter between events, in units of the prior's."""
REPETITIONS = 3
"""A median then has one run on either side."""
METHOD = Avo(polish=False, min_std=1e-3)
"""The adversarial phase alone, whose proposal may become as narrow as it will: what is looked at is its width."""


def made(path: Path, seed: int = 0) -> dict[str, Any]:
    """The record of the study at `path`, of which each run that is lacking is made and written at once.

    `runs` holds for each the `task`, `strength` and `repetition`, the `width` of the final proposal in units of the
    prior's, a number a parameter, and the p-value of the gates of a diagnosis. Raises StoreError for a damaged file.
    """
    identity = {"seed": seed, "budget": BUDGET, "num_observations": NUM_OBSERVATIONS}
    keys = [(task, strength, i) for i in range(REPETITIONS) for task in TASKS for strength in STRENGTHS]
    wanted = [
        (dict(zip(("task", "strength", "repetition"), key, strict=True)), partial(one, *key, seed)) for key in keys
    ]
    return FILE.completed(path, "runs", wanted, **identity, method=METHOD.name, method_version=METHOD.version)


def one(
    name: str, strength: float, repetition: int, seed: int, num_events: int = NUM_OBSERVATIONS, budget: int = BUDGET
) -> dict[str, Any]:
    """A run on events whose parameters vary around the prior's center."""
    task = registry.build("task", name, {})
    words = ("misspecification", name, str(strength), str(repetition))
    rng = stream(seed, "observed", *words)
    unit = task.prior.width / np.sqrt(12)  # the prior is uniform
    spread = strength * unit * rng.standard_normal((num_events, task.prior.dim))
    x = task.simulate(np.clip(task.prior.center + spread, task.support.low, task.support.high), rng)
    simulate = MeteredSimulator(task, budget, stream(seed, "simulator", *words))
    found = METHOD.infer(pose(task, x, simulate), stream(seed, "method", *words))
    found_by_gates = diagnose(task, x, seed=seed + repetition, effects=[])
    return {"width": (found.std / unit).tolist(), "p_value": float(found_by_gates.diagnosis.p_value_before)}
