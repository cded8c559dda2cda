"""Find where simulation and measurement disagree, name the missing effect, add it, and show the gap shrink."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from avobench.diagnosis.report.assemble import Result
    from avobench.diagnosis.run import diagnose
    from avobench.diagnosis.schema import Diagnosis

__all__ = ["Diagnosis", "Result", "diagnose"]

_HOMES = {
    "diagnose": "avobench.diagnosis.run",
    "Diagnosis": "avobench.diagnosis.schema",
    "Result": "avobench.diagnosis.report.assemble",
}


def __getattr__(name: str) -> Any:
    """What the package offers, loaded when asked for: SciPy's statistics take a second, the effects none."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__} has no attribute {name}")
    return getattr(import_module(_HOMES[name]), name)
