"""Pairs of cells with either Gaussian process."""

import pytest

from paper.tables.surrogates import table


def test_only_targets_that_both_have_are_pairs(make_record):
    own = [make_record("poisson", "bolfi", target, 1e-2) for target in range(8)]
    fast = [make_record("poisson", "bolfi", target, 2e-2) for target in range(1, 12)]
    (row,) = table(own, [*fast, make_record("poisson", "avo", 0, 1.0)]).to_dict("records")
    assert (row["targets"], row["nearer with ELFI's"]) == (7, 7)
    assert row["fast"] == pytest.approx(4 * row["ELFI's: median error / floor"])
    assert float(row["p"]) == pytest.approx(2 / 2**7, rel=0.1)


def test_few_pairs_are_not_tested(make_record):
    (row,) = table(*[[make_record("carl", "bolfi", 0, offset)] for offset in (1e-2, 2e-2)]).to_dict("records")
    assert row["p"] == "-"
