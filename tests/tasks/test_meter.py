"""One meter for all that simulates: it never counts more than its limit."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.meter import Meter


@given(limit=st.integers(0, 300), kept=st.integers(0, 100), requests=st.lists(st.integers(1, 120), max_size=20))
def test_never_above_the_limit_less_what_is_kept(limit, kept, requests):
    meter = Meter(limit)
    with meter.keeping(kept):
        for n in requests:
            before = meter.used
            if n <= limit - kept - before:
                meter.charge(n)
                assert meter.used == before + n
            else:
                with pytest.raises(BudgetExhausted, match=f"{n} events asked for"):
                    meter.charge(n)
                assert meter.used == before
    assert meter.used + meter.refused == sum(requests)
    assert meter.remaining == limit - meter.used


def test_without_a_limit_it_counts_and_tells():
    meter = Meter(progress=(told := []).append)
    meter.charge(10**12)
    meter.add(5)
    assert told == [10**12, 10**12 + 5]
    assert meter.remaining is None


def test_the_copy_of_another_process_has_its_share_and_tells_nobody():
    told = []
    meter = Meter(100, told.append)
    meter.charge(40)
    copy = pickle.loads(pickle.dumps(meter))
    copy.share(20)
    copy.charge(20)
    with pytest.raises(BudgetExhausted):
        copy.charge(1)
    assert told == [40]
    assert meter.used == 40
