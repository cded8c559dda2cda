"""The tasks on targets drawn apart from those of the benchmark: settings are chosen on them, and on nothing else."""

from dataclasses import dataclass
from typing import ClassVar

from avobench.tasks.alignment_3 import Alignment3
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

# Targets are drawn with the hash of the task's name, so another name is other targets.


@dataclass(frozen=True)
class PoissonDevelopment(Poisson):
    name: ClassVar[str] = "poisson-development"


@dataclass(frozen=True)
class CarlDevelopment(Carl):
    name: ClassVar[str] = "carl-development"


@dataclass(frozen=True)
class WeinbergDevelopment(Weinberg):
    name: ClassVar[str] = "weinberg-development"


@dataclass(frozen=True)
class Alignment3Development(Alignment3):
    """Not among TASKS: a run costs a minute of Pythia."""

    name: ClassVar[str] = "alignment-3-development"


TASKS = {"poisson": PoissonDevelopment, "carl": CarlDevelopment, "weinberg": WeinbergDevelopment}
SEED = 20_251
"""Root of the streams of every run on them: not that of the benchmark."""


def spec(task: str) -> str:
    """How a cell names the development task of that name."""
    return f"{__name__}:{TASKS[task].__name__}"
