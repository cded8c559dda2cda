"""Which versions made a record."""

import importlib.metadata
import platform
import subprocess
from functools import cache
from pathlib import Path

RECORDED = ("avobench", "numpy", "scipy", "torch", "pyabc", "elfi", "GPy", "pythia8mc")
"""Packages on which a result depends."""


@cache
def versions() -> dict[str, str | None]:
    """Versions of what a result depends on, and the commit of the source where it is a git checkout."""
    found: dict[str, str | None] = {"python": platform.python_version()}
    for name in RECORDED:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = None
    source = Path(__file__).resolve().parents[2]
    found["commit"] = None
    if (source / ".git").exists():
        git = ["git", "-C", str(source)]
        try:
            head = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=True)
            changed = subprocess.run([*git, "diff", "--quiet", "HEAD", "--", "avobench"])
            found["commit"] = head.stdout.strip() + "-changed" * (changed.returncode != 0)
        except (OSError, subprocess.CalledProcessError):
            found["commit"] = "unknown"
    return found
