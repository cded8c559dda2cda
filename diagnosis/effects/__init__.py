"""Effects that a simulator may lack: what they are (`base`), and all that apply to a task (`catalogue`)."""

from avobench.diagnosis.effects.base import Effect, Parameter
from avobench.diagnosis.effects.catalogue import catalogue

__all__ = ["Effect", "Parameter", "catalogue"]
