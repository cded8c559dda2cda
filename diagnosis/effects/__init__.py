"""Effects that a simulator may lack: what they are (`base`), and all that apply to a task (`catalogue`)."""

from avobench.diagnosis.effects.base import Effect, Parameter

__all__ = ["Effect", "Parameter"]
