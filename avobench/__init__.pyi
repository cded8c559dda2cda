"""What `import avobench` offers. Each name is loaded when it is first asked for."""

from .api.calibration import Calibration, calibrate
from .api.diagnosis import Diagnosed, diagnose
from .api.inference import Inference, infer
from .api.joint import Joint, joint
from .api.listing import list_effects, list_methods, list_tasks
from .api.load import load
from .api.sweep import records, run
from .bench.events import read_events
from .bench.processes.workers import Workers
from .effects.contract import Effect, Parameter
from .methods.contract import Estimate, Method, TracePoint, WeightedSample
from .methods.problem import Problem
from .tables.comparison import compare_tables
from .tables.fit import fit_tables
from .tables.read import read_table
from .tables.table import Table, Tables
from .tasks.contract import Box, Task
from .tasks.errors import AvobenchError, SimulatorError, UsageError
from .tasks.function import task
from .tasks.sample import bank
from .tasks.weights import unweighted

__version__: str

__all__ = [
    "AvobenchError",
    "Box",
    "Calibration",
    "Diagnosed",
    "Effect",
    "Estimate",
    "Inference",
    "Joint",
    "Method",
    "Parameter",
    "Problem",
    "SimulatorError",
    "Table",
    "Tables",
    "Task",
    "TracePoint",
    "UsageError",
    "WeightedSample",
    "Workers",
    "bank",
    "calibrate",
    "compare_tables",
    "diagnose",
    "fit_tables",
    "infer",
    "joint",
    "list_effects",
    "list_methods",
    "list_tasks",
    "load",
    "read_events",
    "read_table",
    "records",
    "run",
    "task",
    "unweighted",
]
