"""What a simulator returns, held against what its task declares."""

import numpy as np

import avobench
from avobench.tasks.checked import checked_events

THETA = np.full((50, 1), 2.0)


def task(simulate):
    return avobench.task(simulate, prior={"mean": (1, 3)}, name="toy")


def test_events_can_be_written_to_though_the_simulator_s_cannot():
    def frozen(theta, rng):
        x = rng.exponential(theta)
        x.flags.writeable = False
        return x

    x = checked_events(task(frozen), THETA, np.random.default_rng(0))
    x[:] = 0


def test_events_stay_though_the_simulator_fills_one_buffer_again_and_again():
    buffer = np.empty((50, 1))

    def reusing(theta, rng):
        buffer[: len(theta)] = rng.exponential(theta)
        return buffer[: len(theta)]

    made = task(reusing)
    first = checked_events(made, THETA, np.random.default_rng(0))
    kept = first.copy()
    checked_events(made, THETA, np.random.default_rng(1))
    np.testing.assert_array_equal(first, kept)


def test_theta_stays_though_the_simulator_changes_it():
    def changing(theta, rng):
        x = rng.exponential(theta)
        theta /= 2
        return x

    theta = THETA.copy()
    checked_events(task(changing), theta, np.random.default_rng(0))
    np.testing.assert_array_equal(theta, THETA)
