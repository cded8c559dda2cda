"""Events that are kept: none is made twice, none is handed out twice, and their mean is the simulator's."""

from copy import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import avobench
from avobench.effects.bank import Bank, Given
from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.meter import Meter


def bank_of(made, limit=None, jobs=1):
    """Each event is theta with a little noise, so that no two are equal; `made` counts them."""

    def near(theta, rng):
        made.append(len(theta))
        return theta + rng.normal(0, 1e-3, theta.shape)

    bank = Bank(avobench.task(near, prior={"a": (0, 1), "b": (-2, 2)}), Meter(limit), 0, jobs)
    bank.resolve(np.array([0.1, 0.2]))
    return bank


def test_the_mean_between_nodes_is_interpolated():
    theta = np.array([0.333, 1.21])
    x = bank_of([]).session()(np.tile(theta, (40_000, 1)), np.random.default_rng(0))
    assert len(np.unique(np.round(x, 1), axis=0)) > 1  # of several nodes
    np.testing.assert_allclose(x.mean(axis=0), theta, atol=5 * x.std(axis=0).max() / 200)


@given(sizes=st.lists(st.integers(0, 50), min_size=1, max_size=6), seed=st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_no_event_comes_twice_in_a_session_nor_is_made_twice(sizes, seed):
    made = []
    bank = bank_of(made)
    made.clear()
    rng = np.random.default_rng(seed)
    thetas = [rng.uniform([0, -2], [1, 2], (n, 2)) for n in sizes]
    first, second = (
        np.concatenate([session(theta, np.random.default_rng(k)) for k, theta in enumerate(thetas)])
        for session in (bank.session(), bank.session())
    )
    np.testing.assert_array_equal(first, second)
    assert len(np.unique(first, axis=0)) == len(first) == sum(made) == bank.meter.used


def test_a_copy_of_a_session_goes_on_as_it_does():
    session, theta = bank_of([]).session(), np.tile([0.3, 0.1], (20, 1))
    before = session(theta, np.random.default_rng(0))
    twin = copy(session)
    again, other = session(theta, np.random.default_rng(1)), twin(theta, np.random.default_rng(1))
    np.testing.assert_array_equal(again, other)
    assert not np.isin(again, before).any()


def test_the_number_of_processes_changes_no_event(monkeypatch):
    monkeypatch.setattr("avobench.effects.bank.PIECE", 30)
    theta = np.random.default_rng(0).uniform([0, -2], [1, 2], (100, 2))
    alone, together = (bank_of([], jobs=jobs).session()(theta, np.random.default_rng(0)) for jobs in (1, 2))
    np.testing.assert_array_equal(alone, together)


def test_the_limit_is_kept():
    bank = bank_of([], limit=100)
    theta = np.tile([0.3, 0.1], (60, 1))
    bank.session()(theta, np.random.default_rng(0))
    bank.session()(theta, np.random.default_rng(0))  # costs nothing
    with pytest.raises(BudgetExhausted):
        bank.session()(np.tile([0.9, 1.9], (60, 1)), np.random.default_rng(0))
    assert bank.meter.used == 60


def test_a_sample_is_handed_out_once_and_then_again_with_a_larger_variance():
    events = np.random.default_rng(0).normal(size=1000)
    bank = Given(avobench.bank(events), Meter())
    session, rng = bank.session(), np.random.default_rng(0)
    x = session(np.empty((800, 0)), rng)
    assert (len(np.unique(x)), session.repeats) == (800, 1)
    session(np.empty((800, 0)), rng)
    assert session.repeats == 2
    aside = bank.fresh(np.empty((200, 0)), rng)
    assert not np.isin(aside, x).any()
