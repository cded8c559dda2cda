"""Which workers carry out a sweep, as a user asks for them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import joblib

from avobench.bench.backends.contract import Backend
from avobench.bench.backends.dask import DaskBackend
from avobench.bench.backends.local import LocalBackend
from avobench.bench.backends.together import TogetherBackend
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

    def __post_init__(self) -> None:
        if self.jobs is not None and self.jobs < 1:
            raise UsageError(f"--jobs must be at least 1, got {self.jobs}")
        if (self.backend == "dask") != (self.scheduler is not None):
            raise UsageError("--backend dask and --scheduler ADDRESS belong together")
        if self.backend == "dask" and self.jobs is not None:
            raise UsageError("--jobs is for --backend local; a Dask cluster has the workers that it has")
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
        jobs = self.jobs or joblib.cpu_count()
        if self.backend == "together":
            return TogetherBackend(jobs, marks, self.group, debug=debug)
        return LocalBackend(jobs, marks, debug=debug)
