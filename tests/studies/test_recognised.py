"""Two opinions of one name."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.reports.recognised import together


@given(st.dictionaries(st.sampled_from("abcd"), st.floats(0, 1), min_size=1))
def test_two_tables_alike_agree_and_neither_excludes_for_good(table):
    both = together(table, table)
    assert sum(both.values()) == pytest.approx(1)
    assert max(both.values()) == pytest.approx(both[max(table, key=table.get)])
    assert all(value > 0 for value in together(table, {"e": 1.0}).values())
