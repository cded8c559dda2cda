import subprocess
import sys

import numpy as np
import pytest

from avobench.bench.plugins.registry import settings_of
from avobench.methods.bolfi import Bolfi
from avobench.tasks import Task
from gaussian import TRUTH, GaussianMean, gaussian_problem


def infer(budget: int = 18 * 16, task: Task | None = None, events_per_theta: int = 16, **settings):
    """The estimate of BOLFI with these settings, and the problem that it had."""
    problem = gaussian_problem(task or GaussianMean(), budget)
    method = Bolfi(events_per_theta=events_per_theta, **settings)
    return method.infer(problem, np.random.default_rng(1)), problem


def test_both_surrogates_acquire_the_same_points():
    class Recording(GaussianMean):
        def simulate(self, theta, rng):
            seen[-1].append(theta[0, 0])
            return super().simulate(theta, rng)

    seen, estimates = [], []
    for surrogate in ("fast", "gpy"):
        seen.append([])
        estimates.append(infer(22 * 64, Recording(), 64, num_trace_points=2, surrogate=surrogate)[0])
    assert len(set(seen[0])) == 22
    assert seen[0] == pytest.approx(seen[1], abs=1e-4)
    assert estimates[0].theta == pytest.approx(estimates[1].theta, abs=1e-4)
    assert estimates[0].std == pytest.approx(estimates[1].std, abs=1e-4)


@pytest.mark.parametrize("surrogate", ["fast", "gpy"])
def test_acquisition_noise_and_many_initial_evaluations(surrogate):
    settings = {"num_trace_points": 2, "acq_noise_var": 0.01, "initial_evidence": 12}
    estimate, problem = infer(20 * 16, surrogate=surrogate, **settings)
    assert problem.simulate.used == 20 * 16
    assert estimate.theta == pytest.approx(TRUTH, abs=1)


def test_events_for_a_theta_may_grow_within_the_budget():
    grown = {"growth": 8.0, "log_distance": True, "regression": True}
    estimate, problem = infer(60 * 16, num_trace_points=3, **grown)
    assert estimate.theta == pytest.approx(TRUTH, abs=0.3)
    assert 0.85 * 60 * 16 < problem.simulate.used <= 60 * 16
    assert problem.simulate.refused == 0
    assert len(estimate.trace) == 3
    assert grown.items() <= settings_of(Bolfi(**grown)).items()
    assert not grown.keys() & settings_of(Bolfi()).keys()  # old records keep their names


def test_the_trace_does_not_disturb_the_run():
    (plain, _), (traced, _) = (infer(num_trace_points=points) for points in (1, 8))
    assert (plain.theta == traced.theta).all()
    assert (plain.std == traced.std).all()


def test_importing_elfi_does_not_hide_later_deprecation_warnings():
    script = (
        "import warnings; before = list(warnings.filters)\n"
        "from avobench.methods.elfi_model import import_elfi; import_elfi()\n"
        "ours = [f for f in warnings.filters if f[2] is DeprecationWarning]\n"
        "assert ours == [f for f in before if f[2] is DeprecationWarning], ours\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
