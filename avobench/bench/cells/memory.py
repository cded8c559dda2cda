"""The most memory that a process took."""

from contextlib import suppress
from pathlib import Path


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
