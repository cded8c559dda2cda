"""What the diagnosis offers. Each name is loaded when it is first asked for."""

from .report.result import Result
from .run import diagnose
from .schema import Diagnosis

__all__ = ["Diagnosis", "Result", "diagnose"]
