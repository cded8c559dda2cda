"""The budget is a hard limit of the simulator, whatever a method asks for."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toys import Normal

from avobench.bench.cells.budget import MeteredSimulator
from avobench.tasks.errors import BudgetExhausted, SimulatorError, SupportError, UsageError
from avobench.tasks.weinberg import Weinberg

THETA = [45.5, 1.0]


def metered(budget, task=None):
    return MeteredSimulator(task or Weinberg(), budget, np.random.default_rng(0))


@given(budget=st.integers(1, 300), requests=st.lists(st.integers(1, 120), max_size=20))
def test_never_above_the_budget_and_every_request_accounted_for(budget, requests):
    simulate = metered(budget)
    for n in requests:
        if n <= (left := simulate.remaining):
            assert simulate([THETA] * n).shape == (n, 1)
            assert simulate.remaining == left - n
        else:
            with pytest.raises(BudgetExhausted, match=f"{n} events asked for, {left} of {budget} left"):
                simulate([THETA] * n)
    assert simulate.used == budget - simulate.remaining <= budget
    assert simulate.requested == simulate.used + simulate.refused == sum(requests)


def test_repeat_needs_an_event_of_each_row():
    simulate = metered(10)
    for n in (0, -1):
        with pytest.raises(SupportError, match=f"at least 1 event per row must be asked for, got {n}"):
            simulate.repeat(THETA, n)
    with pytest.raises(SupportError, match="outside the support"):
        simulate.repeat([50.0, 1.0], 2)
    assert simulate.requested == 0


def test_no_event_is_made_in_another_process_where_none_is_counted():
    simulate = metered(10)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        for asked in (pool.submit(simulate, [THETA]), pool.submit(simulate.repeat, THETA, 1)):
            with pytest.raises(UsageError, match="process"):
                asked.result()
    assert simulate([THETA] * 10).shape == (10, 1)


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


def test_the_events_of_a_faulty_simulator_are_charged():
    simulate = metered(10, Normal(fault="nan"))
    with pytest.raises(SimulatorError, match="NaN or infinity in 4 of 4 events"):
        simulate([[0.0]] * 4)
    assert simulate.used == 4
