"""The classifier that fits nothing: what it sees of a feature, and what it learns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.reports.recognised import together
from avobench.studies.recognised import SEEN, portrait, told, trained


@given(st.floats(0.5, 150), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_poisson_counts_show_nothing_and_others_do(rate, seed):
    rng = np.random.default_rng(seed)
    x = rng.poisson(rate, 20_000)
    seen, by = portrait("counts", x)
    assert np.isfinite(seen).all()
    assert by < SEEN
    doubled, by = portrait("counts", 2 * x)
    assert by > SEEN
    assert doubled.shape == seen.shape


@given(st.floats(-0.7, 0.7), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_a_cosine_of_any_asymmetry_shows_nothing_and_a_smeared_one_does(asymmetry, seed):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, 80_000)
    x = x[rng.uniform(0, 3 / 4 + 0.7, len(x)) < 3 / 8 * (1 + x**2) + asymmetry * x]
    seen, by = portrait("continuous", x)
    assert np.isfinite(seen).all()
    assert by < SEEN
    _, by = portrait("continuous", np.where(np.abs(x) < 0.2, x / 2, x))
    assert by > SEEN


def test_what_it_has_seen_it_knows_again():
    rng = np.random.default_rng(0)

    def family(name):
        x = rng.poisson(rng.uniform(5, 50), 20_000)
        if name == "zeros":
            x[rng.random(len(x)) < rng.uniform(0.02, 0.3)] = 0
        return x if name == "zeros" else 2 * (x // 2)

    names = ["zeros", "even"] * 150
    classifiers = trained(np.array([portrait("counts", family(name))[0] for name in names]), names)
    fresh = np.array([portrait("counts", family(name))[0] for name in names[:20]])
    probabilities = [told(classifiers, seen) for seen in fresh]
    assert all(sum(each.values()) == pytest.approx(1) for each in probabilities)
    assert [max(each, key=each.get) for each in probabilities] == names[:20]


@given(st.dictionaries(st.sampled_from("abcd"), st.floats(0, 1), min_size=1))
def test_two_tables_alike_agree_and_neither_excludes_for_good(table):
    both = together(table, table)
    assert sum(both.values()) == pytest.approx(1)
    assert max(both.values()) == pytest.approx(both[max(table, key=table.get)])
    assert all(value > 0 for value in together(table, {"e": 1.0}).values())
