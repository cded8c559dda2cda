"""What `import avobench` offers. Each name is loaded when it is first asked for."""

from .api.diagnosis import Diagnosed, diagnose
from .api.inference import Inference, infer
from .api.listing import list_effects, list_methods, list_tasks
from .api.load import load
from .api.sweep import records, run
from .bench.events import read_events
from .bench.processes.workers import Workers
from .effects.contract import Effect, Parameter
from .methods.contract import Estimate, Method, TracePoint, WeightedSample
from .methods.problem import Problem
from .tasks.contract import Box, Task
from .tasks.errors import AvobenchError, SimulatorError, UsageError
from .tasks.function import task
from .tasks.sample import bank

__version__: str

__all__ = [
    "AvobenchError",
    "Box",
    "Diagnosed",
    "Effect",
    "Estimate",
    "Inference",
    "Method",
    "Parameter",
    "Problem",
    "SimulatorError",
    "Task",
    "TracePoint",
    "UsageError",
    "WeightedSample",
    "Workers",
    "bank",
    "diagnose",
    "infer",
    "list_effects",
    "list_methods",
    "list_tasks",
    "load",
    "read_events",
    "records",
    "run",
    "task",
]
