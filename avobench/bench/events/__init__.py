"""Measured events: read from files, matched with the features of a task, and checked."""

from avobench.bench.events.checks import check_events, with_times
from avobench.bench.events.files import read_events, read_timed

__all__ = ["check_events", "read_events", "read_timed", "with_times"]
