"""Find where simulation and measurement disagree, name the missing effect, add it, and show the gap shrink."""

from avobench.diagnosis.loop import diagnose
from avobench.diagnosis.schema import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
