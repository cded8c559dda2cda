from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.goodness_of_fit.outside import left, outside
from avobench.diagnosis.schema import Gap

P, SHARE = st.floats(0, 1), st.floats(0, 1)


@given(P, P, SHARE, SHARE)
def test_the_worse_the_best_model_fits_the_more_probably_it_is_outside(p, q, much, little):
    less, more = sorted([little, much])
    assert outside(min(p, q), more, 0.05) >= outside(max(p, q), less, 0.05)


@given(st.floats(0, 900), st.floats(0, 900))
def test_what_is_left_of_a_gap_is_a_share_and_all_where_it_did_not_shrink(before, after):
    share = left(*(Gap(value=value, low=0, high=1000) for value in (before, after)))
    assert 0 <= share <= 1
    assert share == 1 or after < before
