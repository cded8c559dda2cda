"""The workers that carry out a sweep, as a user asks for them."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import joblib

from avobench.bench.processes.calls import Limits
from avobench.bench.processes.contract import Backend
from avobench.bench.processes.dask import DaskBackend
from avobench.bench.processes.local import LIMITS, LocalBackend
from avobench.tasks.errors import UsageError


@dataclass(frozen=True)
class Workers:
    """Workers of this machine, or of a cluster. Raises UsageError for what does not go together."""

    jobs: int | None = None
    """Processes of this machine; one a core where None."""
    backend: Literal["local", "together", "dask"] = "local"
    """Processes that take a cell at a time; all cells of a task at once where a method gains from it; a cluster."""
    group: int | None = None
    """The most cells at once with `together`; all where None."""
    scheduler: str | None = None
    """Address of Dask's, such as tcp://10.0.0.1:8786."""
    time_limit: float | None = None
    """Seconds that a cell may take before its process is ended; 6 hours where None."""
    memory_limit: float | None = None
    """MiB of memory that its process may take; 8192 where None."""
    in_process: bool = False
    """Cells, one after the other, in this process, for a debugger: nothing then holds what a simulator does to it."""

    def __post_init__(self) -> None:
        if self.jobs is not None and self.jobs < 1:
            raise UsageError(f"--jobs must be at least 1, got {self.jobs}")
        if (self.backend == "dask") != (self.scheduler is not None):
            raise UsageError("--backend dask and --scheduler ADDRESS belong together")
        if self.backend == "dask" and self.jobs is not None:
            raise UsageError("--jobs is for --backend local; a Dask cluster has the workers that it has")
        for option, value in (("--time-limit", self.time_limit), ("--memory-limit", self.memory_limit)):
            if value is not None and not 0 < value < math.inf:
                raise UsageError(f"{option} must be a number above 0, got {value}")
            if value is not None and (self.backend == "dask" or self.in_process):
                where = "--in-process" if self.in_process else "--backend dask, whose workers have limits of their own"
                raise UsageError(f"{option} is not for {where}")
        if self.in_process and (self.jobs not in (None, 1) or self.backend == "dask"):
            raise UsageError("--in-process is one process of this machine; leave out --jobs and --backend dask")
        if self.group is not None and (self.backend != "together" or self.group < 1):
            raise UsageError(
                f"--group is for --backend together, at least 1; got {self.group} with --backend {self.backend}"
            )

    def begin(self, marks: Path, *, debug: bool = False) -> Backend:
        """The backend, which keeps a file for each running cell in the folder `marks`.

        With `debug` tracebacks of failed cells go to standard error.
        """
        if self.scheduler is not None:
            return DaskBackend(self.scheduler, debug=debug)
        together = self.backend == "together"
        return LocalBackend(self.processes, marks, together=together, most=self.group, limits=self.limits, debug=debug)

    @property
    def processes(self) -> int | None:
        """The number of processes beside this one, in which a call is carried out; None for this one alone."""
        return None if self.in_process else self.jobs or joblib.cpu_count()

    @property
    def limits(self) -> Limits:
        """The limits of a cell in a process of this machine."""
        return Limits(self.time_limit or LIMITS.seconds, self.memory_limit or LIMITS.mib)
