"""The versions of the packages that made a record."""

import importlib.metadata
import platform
import subprocess
from functools import cache
from pathlib import Path

RECORDED = ("avobench", "numpy", "scipy", "torch", "pyabc", "elfi", "GPy", "pythia8mc")
"""Packages on which a result depends."""

_distributions = cache(importlib.metadata.packages_distributions)
"""The packages by module, asked for once a process: Python looks into every installed distribution."""


@cache
def versions(modules: tuple[str, ...] = ()) -> dict[str, str | None]:
    """Versions of RECORDED, of the packages of these modules, and the commit of the source of a git checkout."""
    record: dict[str, str | None] = {"python": platform.python_version()}
    for name in (*RECORDED, *(package for module in modules for package in _packages(module))):
        try:
            record[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            record[name] = None
    source = Path(__file__).resolve().parents[3]
    record["commit"] = None
    if (source / ".git").exists():
        git = ["git", "-C", str(source)]
        try:
            head = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=True)
            changed = subprocess.run([*git, "diff", "--quiet", "HEAD", "--", "avobench"])
            record["commit"] = head.stdout.strip() + "-changed" * (changed.returncode != 0)
        except (OSError, subprocess.CalledProcessError):
            record["commit"] = "unknown"
    return record


def _packages(module: str) -> list[str]:
    """The names under which what provides a module was installed; its own name where nothing is known of it."""
    return _distributions().get(module.partition(".")[0], [module])
