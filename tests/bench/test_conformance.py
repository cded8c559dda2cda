"""The conformance suite passes what is sound and tells each fault by the check that it breaks."""

import re

import numpy as np
import pytest

from avobench.bench import conformance as check


@pytest.fixture(autouse=True)
def _error_state():
    with np.errstate():  # one of the faults changes it
        yield


def failed(kind, name):
    return {result.what: result.why for result in check.run(kind, name) if not result.passed}


SOUND = {
    "task": ["poisson", "carl", "weinberg", "faulty:SoundTask", "faulty:SoundGenerator"],
    "method": ["faulty:SoundMethod", "smm"],
}


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, names in SOUND.items() for name in names])
def test_what_is_sound_passes(kind, name):
    results = list(check.run(kind, name))
    assert len(results) > 12
    assert all(result.passed and result.why == "" for result in results)


FAULTS = {
    "task": [
        ("Nameless", 1, "source must be text, got ''"),
        ("HoldsASet", 1, "a record cannot hold the settings"),
        ("TwoNames", 1, "parameter_names must be 1 texts"),
        ("WidePrior", 1, "must contain the prior"),
        ("TwoKinds", 1, "feature_kinds must be 1 of count, continuous, angle"),
        ("HalfCounts", 1, "x1 is a count and was ["),
        ("WideAngle", 1, "x1 is an angle from -3.142 to 3.142 and was ["),
        ("TargetsElsewhere", 1, "a target lies outside the prior"),
        ("NotANumber", 1, "returned NaN or infinity in"),
        ("Burning", 1, "the simulator of sound raised RuntimeError: the detector is on fire"),
        ("FailsAtTheEdge", 1, "the first at theta = [-9.0]"),
        ("Anywhere", 1, "where ValueError is due"),
        ("ChangesTheta", 1, "simulate changed the array"),
        ("OwnEntropy", 2, "two generators of one seed give different events"),
        ("GlobalRandomness", 2, "depend on the seed of a global generator"),
        ("SeedsGlobally", 1, "simulate or summary changes numpy.random"),
        ("Silences", 1, "changes numpy's floating-point error handling"),
        ("FixedSeed", 2, "is the generator ignored?"),
        ("IgnoresTheta", 1, "look alike"),
        ("FirstTheta", 1, "does a row use the theta of another"),
        ("SharedLatent", 1, "a random number drawn once for the batch?"),
        ("PairsOfRows", 1, "rows i and i + 1 of a batch of 2000 are correlated"),
        ("Antithetic", 1, "rows i and i + 1000 of a batch of 2000 are correlated"),
        ("SummaryOfOrder", 1, "depends on the order"),
        ("GrowingSummary", 1, "128 events have a summary (128,), 1000 have (1000,)"),
        ("TableSummary", 1, "must be an array (k,) of floats"),
        ("HalfAFloor", 1, "floor_shares must be one a parameter and sum to 1"),
        ("RisingFloor", 1, "more simulations raised the floor"),
        ("NoFloor", 1, "must be a positive number, or NaN, got 0.0"),
        ("Unpicklable", 1, "lambda"),
        ("DeterminesMore", 1, "k from 1 to 1, got array"),
        ("DeterminesAnother", 1, "must return theta itself where it returns as many numbers"),
        ("DeterminesInNothing", 1, "identifiable_scale must be 1 positive numbers, got array([0.])"),
        ("DeterminesTogether", 1, "another value where other rows are beside it"),
        ("GeneratesNothing", 1, "takes 3 positional arguments but 4 were given"),
        ("DetectsAnew", 1, "detecting what was generated makes other events"),
        ("AltersNothing", 1, "`alter` is given [] generated events"),
        ("GeneratesMore", 1, "generate made 31 events where 30 were asked for"),
    ],
    "method": [
        ("NoMinimum", 1, "must be a whole number from 1, got 0"),
        ("HoldsATask", 1, "a record cannot hold the settings"),
        ("UnpicklableMethod", 1, "lambda"),
        ("UnderstatesMinimum", 2, "budget_exhausted: 150 events asked for"),
        ("Makeshift", 1, "status invalid_estimate after 0 events"),
        ("WideEstimate", 4, "invalid_estimate: theta of the estimate must be a float array"),
        ("SaysNothing", 4, "how of the estimate must be text, got ' '"),
        ("WritesPlainly", 4, "method_error: ValueError: assignment destination is read-only"),
        ("ForcesAWrite", 4, "the method changed the observed events"),
        ("TracesTooMuch", 4, "theta of the trace of the estimate must be a float array"),
        ("TracesNotANumber", 1, "has theta = [None] after 100 events, where finite numbers are due"),
        ("Quits", 1, "left 2901 of 3001 events on poisson, and no message"),
        ("GlobalRandomMethod", 2, "infer changes numpy.random"),
        ("FixedGlobalSeed", 1, "infer changes numpy.random"),
        ("OwnEntropyMethod", 1, "theta_hat was"),
        ("Remembers", 1, "theta_hat was"),
        ("SwallowsFailure", 1, "made an estimate though the simulator failed"),
        ("MixesThemUp", 1, "theta_hat of carl sound target 0 repetition 0 is ["),
        ("SharesAStream", 1, "theta_hat of carl sound target 1 repetition 0 is ["),
        ("DisguisesFailure", 1, "SimulatorError became RuntimeError: sampling failed"),
    ],
}
"""Faults in tasks and methods, how many checks each breaks, and what is said of the first."""


@pytest.mark.parametrize(
    ("kind", "name", "broken", "why"), [(kind, *fault) for kind, faults in FAULTS.items() for fault in faults]
)
def test_what_is_faulty_fails_on_what_it_breaks(kind, name, broken, why):
    faults = failed(kind, f"faulty:{name}")
    assert len(faults) == broken
    assert why in next(iter(faults.values()))
    assert all(reason and "\n" not in reason for reason in faults.values())


def test_the_command_prints_every_check_and_fails_with_one_line(avobench):
    code, out, err = avobench("check", "task", "faulty:FirstTheta")
    assert code == 1
    assert len(re.findall(r"^pass  [a-z ]", out, re.M)) > 10
    assert len(re.findall(r"^FAIL  [a-z ,]+: at theta = ", out, re.M)) == 1
    assert err.splitlines() == ["avobench: task faulty:FirstTheta does not keep the contract"]
    assert avobench("check", "task", "faulty:SoundTask")[0] == 0
