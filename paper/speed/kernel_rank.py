"""Why the fast process of `bolfi` is not fast with many parameters: `python -m paper.speed.kernel_rank`.

It factorises the kernel matrix to its numerical rank r. An acquisition solves triangular systems of that size for
1 + p + p^2 columns a point with up to two parameters, and for 2 + p with more (`paper.speed.second_derivatives`
times either way), so its cost goes as r^2 times that. Printed is r for evidence drawn uniformly in the
unit box of p parameters, at the length scale that is its prior mean, a third of the box; to two digits, since the
next one depends on how the processor rounds.
"""

import numpy as np
import pandas as pd

from avobench.methods.gaussian_process import DIRECT, Hyperparameters, Posterior

EVIDENCE = (150, 400, 1250)
"""The last is what the full budget holds at 128 events each."""
PARAMETERS = (1, 2, 3, 5, 10)
USUAL = Hyperparameters(variance=1.0, lengthscale=1 / 3, bias=1.0, noise=0.01)
"""The noise and the bias do not enter the rank."""


def rank(num_parameters: int, num_evidence: int) -> int:
    x = np.random.default_rng(0).random((num_evidence, num_parameters))
    return len(Posterior(x, np.zeros(num_evidence), USUAL).pivots)


def table() -> pd.DataFrame:
    """A row a number of parameters, a column a number of evaluations; the last is the cost beside that with two."""
    rows = [{"parameters": p, **{f"rank of {n}": rank(p, n) for n in EVIDENCE}} for p in PARAMETERS]
    frame = pd.DataFrame(rows)
    p = frame["parameters"]
    cost = frame[f"rank of {EVIDENCE[-1]}"] ** 2.0 * (1 + p + (p**2).where(p <= DIRECT, 1))
    frame["cost of an acquisition beside two"] = cost / cost[PARAMETERS.index(2)]
    return frame.map(lambda value: float(f"{value:.2g}"))


if __name__ == "__main__":
    print(table().to_string(index=False, float_format=lambda value: f"{value:g}"))
