"""Methods that leave the process in another state than they found it in; each is as good as `smm` by itself."""

import os
import random
import warnings
from dataclasses import dataclass
from typing import Literal

import numpy as np

from avobench import Estimate, Method, Problem


@dataclass(frozen=True)
class Dirty(Method):
    """A method that changes what all cells share, and then gives the centre of the prior."""

    how: Literal["torch", "events", "errors", "warnings", "random", "environment", "folder"] = "torch"

    name = "dirty"
    version = "1"
    source = "a test"

    def min_simulations(self, num_parameters: int) -> int:
        """The least budget."""
        return 1

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        import torch

        if self.how == "torch":
            torch.set_default_dtype(torch.float64)
            torch.set_grad_enabled(False)
            torch.set_default_device("meta")
        elif self.how == "events":
            torch.from_numpy(problem.x_observed).mul_(2)
        elif self.how == "errors":
            np.seterr(all="raise")
        elif self.how == "warnings":
            warnings.simplefilter("error")
        elif self.how == "random":
            np.random.seed(3)
            random.seed(3)
            torch.manual_seed(3)
        elif self.how == "environment":
            os.environ["DIRTY"] = "yes"
            os.environ.pop("HOME", None)
        elif self.how == "folder":
            os.chdir("/")
        theta = problem.prior.center
        problem.simulate(theta[None])
        return Estimate(theta, "the centre", "proposal", theta, np.ones_like(theta), message="the budget is not needed")
