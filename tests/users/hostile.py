"""Tasks, methods and effects that do harm to the process in which they are. Loaded as `hostile:Name`."""

import os
import signal
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from faulty import SoundMethod, SoundTask
from toys import Moment

from avobench.effects import Effect, Parameter
from avobench.methods import Estimate


def segfault(*_):
    os.kill(os.getpid(), signal.SIGSEGV)


def hang(self, theta, rng):
    """A step of a method takes ten minutes, and an observation next to none."""
    time.sleep(600 * (len(theta) == 40))
    return SoundTask.events(self, theta, rng)


def leak(self, theta, rng):
    """A step of a method fills the memory."""
    kept = []
    while len(theta) == 40:
        kept.append(np.ones(10**6))  # 8 MB
        time.sleep(0.01)
    return SoundTask.events(self, theta, rng)


TASKS = {
    "Segfault": {"events": staticmethod(segfault)},
    "Leaves": {"events": staticmethod(lambda theta, rng: os._exit(0))},  # as a library does that calls exit()
    "NoTargets": {"targets": staticmethod(segfault)},
    "Stuck": {"events": staticmethod(lambda theta, rng: time.sleep(600))},
    "Hangs": {"events": hang},
    "Leaks": {"events": leak},
}
"""What each task does in place of its events, at its first call or where a method asks for a step."""
for _name, _changes in TASKS.items():
    globals()[_name] = type(_name, (SoundTask,), {"__module__": __name__, "name": _name.lower(), **_changes})


class EndsItself(SoundMethod):
    name = "ends-itself"
    infer = staticmethod(lambda problem, rng: os._exit(0))


@dataclass(frozen=True)
class Steps(Moment):
    """Ten events a step of four."""

    name: ClassVar = "steps"

    def infer(self, problem, rng):
        theta = problem.prior.center
        for _ in range(4):
            problem.simulate.repeat(theta, 40)
        return Estimate(theta, "centre", "posterior", theta, theta, [])


class Guesses(SoundMethod):
    """Simulates nothing, and does not say why."""

    name, message = "guesses", ""

    def infer(self, problem, rng):
        theta = problem.prior.center
        return Estimate(theta, "centre", "posterior", theta, theta * 0, message=self.message)


class Says(Guesses):
    name, message = "says", "the prior is known to be enough"


@dataclass(frozen=True)
class OnDevice(SoundMethod):
    """A user's own, which asks for a device and does not look whether it is there."""

    name: ClassVar = "on-device"
    device: str = "cpu"

    def infer(self, problem, rng):
        problem.simulate.repeat(problem.prior.center, 100)
        raise RuntimeError("Found no NVIDIA driver on your system")


class Fatal(Effect):
    name = "fatal"
    parameters = (Parameter("rate", 0, 2, 0, "counts"),)
    sentence = "Nothing is left."
    source = "test"

    def apply(self, simulate, theta, phi, rng):
        segfault()
