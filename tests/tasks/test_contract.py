"""Box, targets and histogram; what a task keeps of its contract is in the conformance checks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from avobench.tasks import Box
from avobench.tasks.carl import Carl
from avobench.tasks.contract import NUM_TARGETS, histogram, stable_hash
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


@pytest.mark.parametrize(
    ("low", "high"),
    [((0,), (0,)), ((1,), (0,)), ((0, 0), (1,)), ((0, 0), (1, -1)), ((float("nan"),), (1,)), ((0,), (float("inf"),))],
)
def test_a_box_refuses_bounds_that_are_not_finite_and_increasing(low, high):
    with pytest.raises(ValueError, match="a box needs finite low < high"):
        Box(low, high)


def test_a_box_knows_its_center_and_width_and_includes_its_bounds():
    box = Box((43, 0), (47, 2))
    assert box.dim == 2
    assert box.center.tolist() == [45, 1]
    assert box.width.tolist() == [4, 2]
    theta = [[43, 0], [47, 2], [45, 1], [42.9, 1], [45, 2.1], [np.nan, 1], [45, np.inf]]
    assert box.contains(theta).tolist() == [True, True, True, False, False, False, False]


VALUES = st.sampled_from([-1.0, -1.0000000000000002, 0.0, 1.0, 1.0000000000000002, np.nan, np.inf, -np.inf])


@given(arrays(float, st.tuples(st.integers(1, 5), st.integers(1, 3)), elements=VALUES | st.floats(-1, 1)))
def test_a_box_contains_all_rows_when_it_contains_each(theta):
    box = Box((-1,) * theta.shape[1], (1,) * theta.shape[1])
    assert box.contains_all(theta) == box.contains(theta).all()
    with pytest.raises(ValueError, match="must have"):
        Box((0,) * 4, (1,) * 4).contains_all(theta)


def test_a_box_samples_uniformly():
    box = Box((-2, 10), (2, 11))
    theta = box.sample(100_000, np.random.default_rng(0))
    assert theta.shape == (100_000, 2)
    assert box.contains(theta).all()
    np.testing.assert_allclose(theta.mean(axis=0), box.center, atol=0.01)
    np.testing.assert_allclose(theta.var(axis=0), box.width**2 / 12, rtol=0.01)


def test_histogram_counts_outside_only_with_overflow():
    x = np.array([[-9.0, 0.5], [0.0, 0.5], [1.0, 1.5], [2.0, 99.0]])
    assert histogram(x, [0, 1, 2]).tolist() == [0.25, 0.5, 0.5, 0.25]
    assert histogram(x, [0, 1, 2], overflow=True).tolist() == [0.25, 0.25, 0.25, 0.25, 0, 0.5, 0.25, 0.25]


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)), elements=st.floats(-1e9, 1e9)))
def test_histogram_with_overflow_is_a_distribution_for_each_feature(x):
    shares = histogram(x, np.linspace(-3, 3, 7), overflow=True).reshape(x.shape[1], 8)
    np.testing.assert_allclose(shares.sum(axis=1), 1)


def test_stable_hash_separates_its_words_and_is_pinned():
    assert stable_hash("ab", "c") != stable_hash("a", "bc")
    assert stable_hash("targets", "poisson") == 0x721753077C9223F02BBA861CB3FCB31


def test_the_first_target_of_each_task_is_the_published_one():
    assert len(Poisson().targets()) == NUM_TARGETS == 15
    np.testing.assert_array_equal(Poisson().targets()[:3], Poisson().targets(3))
    assert Poisson().targets()[0].tolist() == [3.675274324001297]
    assert Carl().targets()[0].tolist() == [-1.7428357587932064, -0.16826683225416028]
    assert Weinberg().targets()[0].tolist() == [44.73592157404568, 1.415854847179705]


@pytest.mark.parametrize(
    ("task", "setting", "wrong", "said"),
    [
        *((task, "num_bins", [0, -1, 2.5, "9"], "a whole number of at least 1") for task in (Poisson, Carl, Weinberg)),
        (Carl, "bin_limit", [0.0, -1.0, np.inf, np.nan], "positive and finite"),
    ],
)
def test_bins_that_make_no_sense_are_refused(task, setting, wrong, said):
    for value in wrong:
        with pytest.raises(ValueError, match=f"{setting} must be {said}"):
            task(**{setting: value})
