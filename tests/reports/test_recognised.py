"""The comparison of the search with a classifier, of the committed records."""

import pandas as pd

from avobench.reports.recognised import disagree, every, table


def test_both_are_counted_over_the_same_data_sets():
    known = every(["poisson-fourth-40", "weinberg-ninth-32"])
    rows = table(known)
    assert rows["cases"].iloc[-1] == rows["cases"].iloc[:-1].sum() == len(known)
    assert (rows[["search", "classifier"]].le(rows["cases"], axis=0)).all(axis=None)
    assert set(known["series"]) == {4, 9}


def test_an_uneven_split_is_told_with_its_probability():
    known = pd.DataFrame({"search": [True] * 3 + [False] * 9, "classifier": [True] * 2 + [False] + [True] * 9})
    assert disagree(known) == (
        "the classifier alone is right in 9 cases, the search alone in 1: p = 0.021 (exact, two-sided)"
    )
