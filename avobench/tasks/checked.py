"""The events that a simulator returns are held against what its task declares."""

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Task
from avobench.tasks.errors import BudgetExhausted, SimulatorError, raised


def checked_events(task: Task, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
    """Events of `task`, or SimulatorError saying what its simulator did wrong: theta (n, p) -> x (n, d).

    Integers are made whole, see `Task.at_whole`. Theta and events are copied, since a simulator may change or keep
    them.
    """
    try:
        x = task.simulate(task.at_whole(theta, rng).copy(), rng)
    except (SimulatorError, BudgetExhausted):
        raise
    except (Exception, SystemExit) as error:
        raise SimulatorError(f"the simulator of {task.name} raised {raised(error)}") from error
    if not isinstance(x, np.ndarray) or x.shape != (len(theta), task.num_features):
        expected = (len(theta), task.num_features)
        got = f"shape {x.shape}" if isinstance(x, np.ndarray) else type(x).__name__
        raise SimulatorError(f"the simulator of {task.name} returned {got} where an array {expected} was due")
    if x.dtype != task.dtype:
        raise SimulatorError(f"the simulator of {task.name} returned {x.dtype} where {np.dtype(task.dtype)} was due")
    if x.dtype.kind == "f" and len(bad := np.flatnonzero(task.broken(x))):
        raise SimulatorError(
            f"the simulator of {task.name} returned NaN or infinity in {len(bad)} of {len(x)} events, "
            f"the first at theta = {theta[bad[0]].tolist()}"
        )
    return x.copy()
