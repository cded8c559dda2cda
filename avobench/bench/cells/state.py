"""The process that many cells share: what one changes of it is put back before the next, and the memory of each."""

import os
import random
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np


@contextmanager
def put_back() -> Iterator[None]:
    """Put back what the code of a method or task changes of the process within the block.

    That is NumPy's floating-point error handling, legacy random states, PyTorch's defaults, filters of warnings,
    environment and current folder. A fork that comes back as well is ended: it would go on as a second sweep.
    """
    process = os.getpid()
    folder, environment = None, dict(os.environ)
    with suppress(FileNotFoundError):  # nothing leads back to a folder that was removed
        folder = os.getcwd()
    errors, legacy, python = np.geterr(), np.random.get_state(), random.getstate()  # noqa: NPY002
    torch = _torch_state()
    with warnings.catch_warnings():
        try:
            yield
        finally:
            if os.getpid() != process:
                os._exit(1)
            np.seterr(**errors)
            np.random.set_state(legacy)  # noqa: NPY002
            random.setstate(python)
            _put_torch_back(torch)
            for name in os.environ.keys() - environment.keys():
                del os.environ[name]
            os.environ.update(environment)
            if folder is not None:
                with suppress(FileNotFoundError):
                    os.chdir(folder)


def _torch_state() -> dict[str, Any]:
    """PyTorch's defaults; as it begins with where it is not loaded."""
    if (torch := sys.modules.get("torch")) is None:
        return {}
    return {
        "dtype": torch.get_default_dtype(),
        "grad": torch.is_grad_enabled(),
        "deterministic": torch.are_deterministic_algorithms_enabled(),
        "device": torch.get_default_device(),
        "threads": torch.get_num_threads(),
        "random": torch.get_rng_state(),
    }


def _put_torch_back(state: dict[str, Any]) -> None:
    if (torch := sys.modules.get("torch")) is None:
        return
    torch.set_default_dtype(state.get("dtype", torch.float32))
    torch.set_grad_enabled(state.get("grad", True))
    torch.use_deterministic_algorithms(state.get("deterministic", False))
    if torch.get_default_device() != (device := state.get("device", torch.device("cpu"))):
        torch.set_default_device(None if device.type == "cpu" else device)  # a mode for "cpu" would cost time
    if state:
        torch.set_num_threads(state["threads"])
        torch.set_rng_state(state["random"])


def reset_peak_memory() -> None:
    """Start a new high-water mark (Linux), so that a reused worker reports each cell's own peak."""
    with suppress(OSError):  # not Linux, or not allowed: the mark of the whole process stands
        Path("/proc/self/clear_refs").write_text("5")


def peak_memory_mib() -> float | None:
    """High-water mark of resident memory in MiB since the last reset; None where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024
