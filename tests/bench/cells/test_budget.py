"""The budget is a hard limit of the simulator, whatever a method asks for."""

from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.bench.cells.budget import MeteredSimulator
from avobench.tasks.errors import BudgetExhausted, SimulatorError, SupportError
from avobench.tasks.weinberg import Weinberg

THETA = [45.5, 1.0]


def metered(budget, task=None, progress=None):
    return MeteredSimulator(task or Weinberg(), budget, np.random.default_rng(0), progress)


class Faulty(Weinberg):
    """Weinberg with its events replaced."""

    name: ClassVar = "faulty"

    def __init__(self, events):
        super().__init__()
        object.__setattr__(self, "events", events)

    def simulate(self, theta, rng):
        return self.events(theta)


@given(budget=st.integers(1, 300), requests=st.lists(st.integers(1, 120), max_size=20))
def test_never_above_the_budget_and_every_request_accounted_for(budget, requests):
    simulate, delivered = metered(budget), 0
    for n in requests:
        if n <= budget - delivered:
            assert simulate([THETA] * n).shape == (n, 1)
            delivered += n
        else:
            with pytest.raises(BudgetExhausted, match=f"{n} events asked for, {budget - delivered} of {budget} left"):
                simulate([THETA] * n)
    assert simulate.used == delivered <= budget
    assert simulate.requested == simulate.used + simulate.refused == sum(requests)
    assert simulate.remaining == budget - delivered


def test_repeat_needs_an_event_of_each_row():
    simulate = metered(10)
    for n in (0, -1):
        with pytest.raises(SupportError, match=f"at least 1 event per row must be asked for, got {n}"):
            simulate.repeat(THETA, n)
    with pytest.raises(SupportError, match="outside the support"):
        simulate.repeat([50.0, 1.0], 2)
    assert simulate.requested == 0


def test_a_simulator_cannot_change_what_the_method_holds():
    def spoil(theta):
        theta[:] = 0
        return np.zeros((len(theta), 1))

    given_theta = np.array([THETA, THETA])
    simulate = metered(10, Faulty(spoil))
    simulate(given_theta)
    simulate.repeat(given_theta, 2)
    simulate.repeat(given_theta, 1)
    assert given_theta.tolist() == [THETA, THETA]


@pytest.mark.parametrize(
    ("theta", "message"),
    [
        ([[50.0, 1.0]], "outside the support"),
        ([[np.nan, 1.0]], "outside the support"),
        ([THETA[0]], "shape"),
        ([[1.0, 2.0, 3.0]], "shape"),
        (np.empty((0, 2)), "shape"),
    ],
)
def test_parameters_that_cannot_be_simulated_are_refused_and_not_charged(theta, message):
    simulate = metered(10)
    with pytest.raises(SupportError, match=message):
        simulate(theta)
    assert simulate.requested == 0


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (lambda theta: np.full((len(theta), 1), np.nan), "NaN or infinity in 4 of 4 events"),
        (lambda theta: np.zeros(len(theta)), r"shape \(4,\) where an array \(4, 1\)"),
        (lambda theta: np.zeros((len(theta), 1), np.float32), "float32 where float64"),
        (lambda theta: [[0.0]] * len(theta), "returned list"),
        (lambda theta: 1 / 0, "raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_faulty_simulator_is_named_and_its_events_are_charged(events, message):
    simulate = metered(10, Faulty(events))
    with pytest.raises(SimulatorError, match=message):
        simulate([THETA] * 4)
    assert simulate.used == 4
