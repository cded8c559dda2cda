import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # as the command does, so that results are the same

from browser import browser  # noqa: E402

__all__ = ["browser"]
