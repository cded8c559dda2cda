"""Several data sets with one theta: what they share, and what cannot be shared."""

import numpy as np
import pytest

import avobench
from avobench.tasks.errors import UsageError
from avobench.tasks.joint import JointTask


def task(*, names=("rate",), prior=(1.0, 9.0), units=None, kinds=None, seconds=1.0, features=("count",)):
    def counts(theta, rng):
        return rng.poisson(seconds * theta[:, :1] + np.zeros(len(features)))

    prior = prior if isinstance(prior, dict) else dict.fromkeys(names, prior)
    return avobench.task(counts, name="counts", prior=prior, units=units, kinds=kinds, features=features)


def test_an_event_has_one_of_each_set_at_its_own_conditions():
    joint = JointTask({"near": task(), "far": task(seconds=10.0, features=("early", "late"))})
    assert joint.feature_names == ("near: count", "far: early", "far: late")
    assert joint.parameter_names == joint.shared == ("rate",)
    x = joint.simulate(np.full((4000, 1), 3.0), np.random.default_rng(0))
    assert x.dtype == np.int64
    assert x.mean(axis=0) == pytest.approx([3, 30, 30], rel=0.05)
    with pytest.raises(ValueError, match="outside the support"):
        joint.simulate(np.full((1, 1), 10.0), np.random.default_rng(0))


def test_parameters_are_shared_by_name_or_stay_their_own():
    sets = {"near": task(names=("rate", "gain")), "far": task(names=("gain", "rate", "delay"))}
    assert JointTask(sets).parameter_names == ("rate", "gain", "delay")
    apart = JointTask(sets, ["gain"])
    assert apart.parameter_names == ("near: rate", "gain", "far: rate", "delay")
    theta = np.array([[1.0, 2.0, 3.0, 4.0]])
    assert apart.theta_of(0, theta).tolist() == [[1, 2]]
    assert apart.theta_of(1, theta).tolist() == [[2, 3, 4]]


def test_what_is_shared_lies_where_all_sets_may_be():
    joint = JointTask({"near": task(prior=(1, 5)), "far": task(prior=(3, 9))})
    assert (joint.prior.low, joint.prior.high) == ((3,), (5,))


@pytest.mark.parametrize(
    ("near", "far", "shared", "word"),
    [
        ({}, {"names": ("loss",)}, ["rate"], "no two data sets have a parameter 'rate'"),
        ({}, {}, ["slope"], "parameter 'slope' to share; they have: rate"),
        ({"units": {"rate": "Hz"}}, {"units": {"rate": "kHz"}}, None, "in Hz in one data set and in kHz"),
        ({"prior": (1, 2)}, {"prior": (3, 9)}, None, "do not overlap"),
        ({"kinds": {"rate": "integer"}}, {}, None, "a whole number in one data set"),
    ],
)
def test_what_cannot_be_shared_is_told_in_one_line(near, far, shared, word):
    with pytest.raises(UsageError, match=word) as raised:
        JointTask({"near": task(**near), "far": task(**far)}, shared)
    assert "\n" not in str(raised.value)
