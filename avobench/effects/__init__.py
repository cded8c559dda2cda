"""Effects that a simulator may lack: what they are (`contract`), and all that apply to a task (`catalogue`)."""

from avobench.effects.contract import Effect, Parameter

__all__ = ["Effect", "Parameter"]
