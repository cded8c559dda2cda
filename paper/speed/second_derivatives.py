"""Milliseconds of what an acquisition of `bolfi` asks of its process, with p^2 systems solved and with one instead.

`OMP_NUM_THREADS=1 python -m paper.speed.second_derivatives`. Both ways are timed in turns, in CPU time,
on the same evidence and the ten points from which an acquisition starts; `difference` is the largest between the two
Hessians of the variance, beside its largest element.
"""

import time

import numpy as np
import pandas as pd

from avobench.methods.gaussian_process import Posterior
from paper.speed.kernel_rank import USUAL

PARAMETERS = (2, 5, 10)
EVIDENCE = 300
"""About what the full budget holds at 512 events each."""
POINTS = 10
"""From which an acquisition starts."""
REPEATS = 20
"""Timings of each way, of which the median counts: the machine does other things too."""


def row(num_parameters: int) -> dict[str, float]:
    rng = np.random.default_rng(0)
    posterior = Posterior(rng.random((EVIDENCE, num_parameters)), rng.random(EVIDENCE), USUAL)
    points = rng.random((POINTS, num_parameters))
    seconds, hessians = {True: [], False: []}, {}
    for _ in range(REPEATS):
        for direct in (True, False):
            start = time.process_time()
            hessians[direct] = posterior.moments(points, derivatives=2, direct=direct).variance_hessian
            seconds[direct].append(time.process_time() - start)
    direct, transposed = (1000 * np.median(seconds[way]) for way in (True, False))
    apart = np.abs(hessians[True] - hessians[False]).max() / np.abs(hessians[True]).max()
    return {
        "parameters": num_parameters,
        "rank": len(posterior.pivots),
        "p^2 systems [ms]": direct,
        "transposed [ms]": transposed,
        "ratio": direct / transposed,
        "difference": apart,
    }


if __name__ == "__main__":
    print(pd.DataFrame(map(row, PARAMETERS)).to_string(index=False, float_format=lambda value: f"{value:.3g}"))
