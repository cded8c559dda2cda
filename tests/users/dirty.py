"""Methods that leave the process in another state than they found it in, or return what no record can hold."""

import os
import random
import sys
import warnings
from dataclasses import dataclass, replace

import numpy as np

from avobench import Estimate, Method, Problem


class Speechless(Exception):
    """An exception that fails to say what is wrong."""

    def __str__(self) -> str:
        raise ValueError("not this either")


class OwnText(str):
    """A text of a class that only a user has."""


def _torch(problem: Problem, found: Estimate) -> None:
    import torch

    torch.set_default_dtype(torch.float64)
    torch.set_grad_enabled(False)
    torch.set_default_device("meta")


def _events(problem: Problem, found: Estimate) -> None:
    import torch

    torch.from_numpy(problem.x_observed).mul_(2)


def _random(problem: Problem, found: Estimate) -> None:
    import torch

    np.random.seed(3)
    random.seed(3)
    torch.manual_seed(3)


def _environment(problem: Problem, found: Estimate) -> None:
    os.environ["DIRTY"] = "yes"
    os.environ.pop("HOME", None)


def _speechless(problem: Problem, found: Estimate) -> None:
    raise Speechless


def _leaves(problem: Problem, found: Estimate) -> None:
    sys.exit("enough")


def _screen(problem: Problem, found: Estimate) -> None:
    raise RuntimeError("\x1b[2J\x1b]0;title\x07 \u202eevig \x9b1A\r \udcff")


def _nested(problem: Problem, found: Estimate) -> Estimate:
    how = found.how
    for _ in range(900):
        how = [how]
    return replace(found, how=how)


WAYS = {
    "torch": _torch,
    "events": _events,
    "errors": lambda problem, found: np.seterr(all="raise") and None,
    "warnings": lambda problem, found: warnings.simplefilter("error"),
    "random": _random,
    "environment": _environment,
    "folder": lambda problem, found: os.chdir("/"),
    "fork": lambda problem, found: os.fork() and None,
    "speechless": _speechless,
    "leaves": _leaves,
    "screen": _screen,
    "nested": _nested,
    "wide": lambda problem, found: replace(found, theta=found.theta.astype(np.longdouble)),
    "wide spread": lambda problem, found: replace(found, std=found.std.astype(np.longdouble)),
    "masked": lambda problem, found: replace(found, theta=np.ma.masked_all(len(found.theta))),
    "half a character": lambda problem, found: replace(found, message="half \udcff", doubt="\ud800"),
    "half a character elsewhere": lambda problem, found: replace(found, how="half \udcff"),
    "own text": lambda problem, found: replace(found, message=OwnText("own")),
    "no estimate": lambda problem, found: {"theta": found.theta},
}
"""What is done before a sound estimate is returned, or what is returned in its place."""
LOST = ("events", "speechless", "leaves", "screen", "nested", "wide", "wide spread", "masked", "no estimate")
LOST += ("half a character elsewhere",)
"""Ways that cost the cell."""


@dataclass(frozen=True)
class Dirty(Method):
    """A method that does one or more of WAYS, and gives the centre of the prior."""

    how: str = "torch"
    """Names of WAYS, with a plus between them."""

    name = "dirty"
    version = "1"
    source = "a test"

    def min_simulations(self, num_parameters: int) -> int:
        """The least budget."""
        return 1

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        theta = problem.prior.center
        problem.simulate(theta[None])
        found = Estimate(theta, "the centre", "proposal", theta, np.ones_like(theta), message="no more is needed")
        for way in self.how.split("+"):
            returned = WAYS[way](problem, found)
            found = found if returned is None else returned
        return found
