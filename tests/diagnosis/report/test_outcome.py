"""The verdict follows from the gates and from the gap on the events kept aside, and never against one of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.goodness_of_fit.gates import ExtendedModel
from avobench.diagnosis.report.outcome import Outcome, prior_notes, share_left, unconfirmed
from avobench.diagnosis.schema import Gap, GateResult, Verdict
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.settings import TEST
from avobench.effects.model import Model
from avobench.tasks.function import task


def model(p, gap, *effects):
    """A model whose summary test has the p-value p before it is divided by its share of alpha, 0.8."""
    fit = SimpleNamespace(model=SimpleNamespace(effects=effects), gap=gap)
    return ExtendedModel(fit, fit, None, {"summary": GateResult(statistic=1.0, dof=1, p_value=p, share=0.8)})


def outcome(null, extended=None, posterior=None, shrank=lambda new, old: new.gap.value < old.gap.low):
    held_out = SimpleNamespace(gap=lambda fit, rng, num_simulated: fit.gap, shrank=shrank)
    return Outcome.of(null, extended, posterior, 0.05, held_out, np.random.default_rng(0), Effort())


def gap(low, value, high):
    return Gap(value=value, low=low, high=high)


EFFECT = SimpleNamespace(name="dead_time")
LARGE = gap(65, 70, 75)


@pytest.mark.parametrize(
    ("before", "p_before", "after", "p_after", "verdict"),
    [
        (LARGE, 1e-30, gap(0.8, 1.1, 1.6), 0.4, Verdict.NAMED),
        (LARGE, 1e-30, gap(1.08, 1.64, 2.19), 0.4, Verdict.FAMILY),  # the events kept aside contradict
        (LARGE, 1e-30, gap(0.8, 1.1, 1.6), 1e-3, Verdict.FAMILY),  # the gates contradict
        (gap(0.9, 1.02, 1.2), 1e-30, gap(0.9, 1.01, 1.2), 1e-3, Verdict.UNEXPLAINED),  # less than its error
        (LARGE, 1e-30, gap(62, 67, 72), 1e-30, Verdict.UNEXPLAINED),
        (LARGE, 1e-30, gap(70, 75, 80), 0.4, Verdict.UNEXPLAINED),  # it grew
        (LARGE, 1e-30, gap(35, 40, 45), 1e-30, Verdict.UNEXPLAINED),  # more than half is left
        (LARGE, 1e-30, gap(8, 10, 12), 1e-30, Verdict.FAMILY),
        (gap(0.9, 1.02, 1.2), 0.01, gap(0.9, 1.01, 1.2), 0.4, Verdict.NAMED),
        (gap(0.9, 1.02, 1.2), 0.01, gap(0.9, 1.03, 1.2), 0.4, Verdict.UNEXPLAINED),  # it fits, but not better
    ],
)
def test_the_verdict_contradicts_neither_the_gates_nor_the_gap(before, p_before, after, p_after, verdict):
    one = outcome(model(p_before, before), model(p_after, after, EFFECT))
    assert one.verdict == verdict
    left_out = verdict == Verdict.UNEXPLAINED
    assert (one.gap_after is None) == left_out
    assert (one.effects, one.withdrawn) == (((), (EFFECT,)) if left_out else ((EFFECT,), ()))


P = st.floats(-300, 0).map(lambda power: 10**power)
GAPS = st.lists(st.floats(0.2, 900), min_size=3, max_size=3).map(lambda ends: gap(*sorted(ends)))


@given(P, GAPS, P, GAPS, st.booleans())
def test_no_answer_contradicts_a_number_beside_it(p_before, before, p_after, after, shrank):
    posterior = Posterior({frozenset({("dead_time", None)}): 1.0}, {})
    one = outcome(model(p_before, before), model(p_after, after, EFFECT), posterior, lambda new, old: shrank)
    if one.effects:
        assert one.gap_after.value < one.gap_before.value
        assert not one.withdrawn
    if one.verdict == Verdict.NAMED:
        assert one.final.p_value >= TEST.rejected_share * 0.05
        assert one.gap_after.low <= 1
    if one.verdict == Verdict.FAMILY:
        assert one.posterior.outside < 0.5
        assert share_left(before, after) <= 0.5
    if one.verdict == Verdict.UNEXPLAINED:
        assert one.why


def test_a_p_value_below_alpha_but_not_below_its_share_of_it_is_no_disagreement():
    assert outcome(model(0.044, gap(0.7, 1.0, 1.3))).verdict == Verdict.NOTHING  # 0.044 / 0.8 = 0.055
    assert outcome(model(0.039, gap(0.7, 1.0, 1.3))).verdict == Verdict.UNEXPLAINED


def test_a_gap_of_one_beside_a_small_p_value_is_explained():
    gates = {
        "summary": GateResult(statistic=1.0, dof=1, p_value=0.3, share=0.8),
        "classifier": GateResult(statistic=13.6, dof=None, p_value=3e-42, share=0.2),
    }
    one = outcome(replace(model(1.0, gap(0.7, 0.93, 1.2)), gates=gates))
    assert one.verdict == Verdict.UNEXPLAINED
    said = "The gap is of the summary, and does not show what rejects the simulator: the classifier."
    assert unconfirmed(one) == said
    few = outcome(model(1e-3, gap(0.7, 1.2, 1.9)))
    assert unconfirmed(few) == "What was held out is too little to show by itself what the rest shows."


def test_a_theta_outside_the_prior_is_told():
    wide = task(lambda theta, rng: rng.normal(theta[:, 0]), prior={"mu": (-1, 1)}, support={"mu": (-9, 9)}, name="wide")
    fit = SimpleNamespace(model=Model(wide), params=np.array([2.94]))
    (told,) = prior_notes(fit, "without effects")
    assert told == "mu = 2.94, fitted without effects, lies outside its prior, -1 to 1."
    assert prior_notes(SimpleNamespace(model=Model(wide), params=np.array([0.9])), "without effects") == []
