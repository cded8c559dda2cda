"""The conformance suite passes what is sound and tells each fault by the check that it breaks."""

import numpy as np
import pytest

from avobench.bench import conformance as check

RECORDABLE = "says what it is, in a form that a record can hold"
DESCRIBED = "names parameters, units, prior, support and features"
TARGETS = "has 15 targets within its prior"
DETERMINES = "says what its events determine of theta"
GENERATES = "detects what it generates, altered or not, as it simulates"
SIMULATES = "simulates 1 and 1000 events of the promised shape and type"
CORNERS = "simulates every corner of its prior and its support"
OUTSIDE = "refuses theta outside its support"
THETA = "leaves theta as it is"
SAME_EVENTS = "repeats its events for a seed, whatever the global seeds"
OTHER_EVENTS = "makes other events for another seed"
GLOBAL_STATE = "leaves global state as it is"
KINDS = "makes features of the kinds that it states"
DEPENDS = "makes events that depend on theta"
OWN = "gives each row its own theta and randomness"
NEIGHBOURS = "makes neighbouring rows independent"
SUMMARY = "summarises events whatever their number and order"
FLOOR = "has a floor that more events do not raise"
PICKLE = "can be sent to a worker process"

MINIMUM = "declares the smallest budget it can use"
LEAST = ("makes an estimate on poisson from 100 events", "makes an estimate on carl from 100 events")
AMPLE = ("makes an estimate on poisson from 3001 events", "makes an estimate on carl from 3001 events")
TRACE = "traces its estimate against the events used"
LEFT_OVER = "says why where it leaves much of the budget"
SAME_ESTIMATE = "repeats its estimate bit for bit for a seed, whatever the global seeds"
TOO_SMALL = "makes no estimate from fewer events than it needs"
FAILURE = "lets errors of the simulator through"
TOGETHER = "makes the same estimates together as alone"


@pytest.fixture(autouse=True)
def _error_state():
    with np.errstate():  # one of the faults changes it
        yield


def failed(kind, name):
    return {result.what: result.why for result in check.run(kind, name) if not result.passed}


@pytest.mark.parametrize("name", ["poisson", "carl", "weinberg", "faulty:SoundTask", "faulty:SoundGenerator"])
def test_sound_tasks_pass(name):
    results = list(check.run("task", name))
    assert [result for result in results if not result.passed] == []
    assert {result.what for result in results} >= {DESCRIBED, SIMULATES, OWN, NEIGHBOURS, FLOOR, PICKLE}
    assert all(result.why == "" for result in results)


@pytest.mark.parametrize("name", ["faulty:SoundMethod", "smm"])
def test_sound_methods_pass(name):
    results = list(check.run("method", name))
    assert [result for result in results if not result.passed] == []
    assert {result.what for result in results} >= {TRACE, SAME_ESTIMATE, GLOBAL_STATE, TOO_SMALL, FAILURE}


@pytest.mark.parametrize(
    ("name", "expected", "why"),
    [
        ("Nameless", {RECORDABLE}, "source must be text, got ''"),
        ("HoldsASet", {RECORDABLE}, "a record cannot hold the settings"),
        ("TwoNames", {DESCRIBED}, "parameter_names must be 1 texts"),
        ("WidePrior", {DESCRIBED}, "must contain the prior"),
        ("TwoKinds", {DESCRIBED}, "feature_kinds must be 1 of count, continuous, angle"),
        ("HalfCounts", {KINDS}, "x1 is a count and was ["),
        ("WideAngle", {KINDS}, "x1 is an angle from -3.142 to 3.142 and was ["),
        ("TargetsElsewhere", {TARGETS}, "a target lies outside the prior"),
        ("NotANumber", {SIMULATES}, "returned NaN or infinity in"),
        ("Burning", {SIMULATES}, "the simulator of sound raised RuntimeError: the detector is on fire"),
        ("FailsAtTheEdge", {CORNERS}, "the first at theta = [-9.0]"),
        ("Anywhere", {OUTSIDE}, "where ValueError is due"),
        ("ChangesTheta", {THETA}, "simulate changed the array"),
        ("OwnEntropy", {SAME_EVENTS, PICKLE}, "two generators of one seed give different events"),
        ("GlobalRandomness", {SAME_EVENTS, GLOBAL_STATE}, "depend on the seed of a global generator"),
        ("SeedsGlobally", {GLOBAL_STATE}, "simulate or summary changes numpy.random"),
        ("Silences", {GLOBAL_STATE}, "changes numpy's floating-point error handling"),
        ("FixedSeed", {OTHER_EVENTS, OWN}, "is the generator ignored?"),
        ("IgnoresTheta", {DEPENDS}, "look alike"),
        ("FirstTheta", {OWN}, "does a row use the theta of another"),
        ("SharedLatent", {OWN}, "a random number drawn once for the batch?"),
        ("PairsOfRows", {NEIGHBOURS}, "rows i and i + 1 of a batch of 2000 are correlated"),
        ("Antithetic", {NEIGHBOURS}, "rows i and i + 1000 of a batch of 2000 are correlated"),
        ("SummaryOfOrder", {SUMMARY}, "depends on the order"),
        ("GrowingSummary", {SUMMARY}, "128 events have a summary (128,), 1000 have (1000,)"),
        ("TableSummary", {SUMMARY}, "must be an array (k,) of floats"),
        ("HalfAFloor", {FLOOR}, "floor_shares must be one a parameter and sum to 1"),
        ("RisingFloor", {FLOOR}, "more simulations raised the floor"),
        ("NoFloor", {FLOOR}, "must be a positive number, or NaN, got 0.0"),
        ("Unpicklable", {PICKLE}, "lambda"),
        ("DeterminesMore", {DETERMINES}, "k from 1 to 1, got array"),
        ("DeterminesAnother", {DETERMINES}, "must return theta itself where it returns as many numbers"),
        ("DeterminesInNothing", {DETERMINES}, "identifiable_scale must be 1 positive numbers, got array([0.])"),
        ("DeterminesTogether", {DETERMINES}, "another value where other rows are beside it"),
        ("GeneratesNothing", {GENERATES}, "takes 3 positional arguments but 4 were given"),
        ("DetectsAnew", {GENERATES}, "detecting what was generated makes other events"),
        ("AltersNothing", {GENERATES}, "`alter` is given [] generated events"),
        ("GeneratesMore", {GENERATES}, "generate made 31 events where 30 were asked for"),
    ],
)
def test_a_faulty_task_fails_on_what_it_breaks(name, expected, why):
    faults = failed("task", f"faulty:{name}")
    assert set(faults) == expected
    assert why in next(iter(faults.values()))
    assert all(reason and "\n" not in reason for reason in faults.values())


@pytest.mark.parametrize(
    ("name", "expected", "why"),
    [
        ("NoMinimum", {MINIMUM}, "must be a whole number from 1, got 0"),
        ("HoldsATask", {RECORDABLE}, "a record cannot hold the settings"),
        ("UnpicklableMethod", {PICKLE}, "lambda"),
        ("UnderstatesMinimum", {*LEAST}, "budget_exhausted: 150 events asked for"),
        ("Makeshift", {TOO_SMALL}, "status invalid_estimate after 0 events"),
        ("WideEstimate", {*LEAST, *AMPLE}, "invalid_estimate: theta of the estimate must be a float array"),
        ("SaysNothing", {*LEAST, *AMPLE}, "how of the estimate must be text, got ' '"),
        ("WritesPlainly", {*LEAST, *AMPLE}, "method_error: ValueError: assignment destination is read-only"),
        ("ForcesAWrite", {*LEAST, *AMPLE}, "the method changed the observed events"),
        ("TracesTooMuch", {*LEAST, *AMPLE}, "theta of the trace of the estimate must be a float array"),
        ("TracesNotANumber", {TRACE}, "has theta = [None] after 100 events, where finite numbers are due"),
        ("Quits", {LEFT_OVER}, "left 2901 of 3001 events on poisson, and no message"),
        ("GlobalRandomMethod", {GLOBAL_STATE, SAME_ESTIMATE}, "infer changes numpy.random"),
        ("FixedGlobalSeed", {GLOBAL_STATE}, "infer changes numpy.random"),
        ("OwnEntropyMethod", {SAME_ESTIMATE}, "theta_hat was"),
        ("Remembers", {SAME_ESTIMATE}, "theta_hat was"),
        ("SwallowsFailure", {FAILURE}, "made an estimate though the simulator failed"),
        ("MixesThemUp", {TOGETHER}, "theta_hat of carl sound target 0 repetition 0 is ["),
        ("SharesAStream", {TOGETHER}, "theta_hat of carl sound target 1 repetition 0 is ["),
        ("DisguisesFailure", {FAILURE}, "SimulatorError became RuntimeError: sampling failed"),
    ],
)
def test_a_faulty_method_fails_on_what_it_breaks(name, expected, why):
    faults = failed("method", f"faulty:{name}")
    assert set(faults) == expected
    assert why in next(iter(faults.values()))
    assert all(reason and "\n" not in reason for reason in faults.values())


def test_the_command_prints_every_check_and_fails_with_one_line(avobench):
    code, out, err = avobench("check", "task", "faulty:FirstTheta")
    assert code == 1
    assert f"pass  {NEIGHBOURS}\n" in out
    assert f"FAIL  {OWN}: at theta = " in out
    assert err.splitlines() == ["avobench: task faulty:FirstTheta does not keep the contract"]
    assert avobench("check", "task", "faulty:SoundTask")[0] == 0
