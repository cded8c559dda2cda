"""The paper: its claims, the studies behind them, tables, figures and timings; `make` runs them from a clone."""

import avobench.__main__  # noqa: F401  one thread a process, set before NumPy is loaded, as the command has it
