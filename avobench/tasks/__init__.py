"""The tasks, which are simulated: one module a task, and the base class that a user's own task derives from."""

from avobench.tasks.contract import Box, Discriminator, Task

__all__ = ["Box", "Discriminator", "Task"]
