"""The verdict follows from the gates and from the gap on the events kept aside, and never against one of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.report.found import Found
from avobench.diagnosis.report.notes import prior_notes, unseen
from avobench.diagnosis.schema import Gap, Gate, Verdict
from avobench.diagnosis.search.tested import Step
from avobench.effects.model import Model
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson


def step(p, gap, *effects):
    """A model whose summary gate has the p-value p before it is divided by its share of alpha, 0.8."""
    fit = SimpleNamespace(model=SimpleNamespace(effects=effects), gap=gap)
    return Step(fit, fit, {"summary": Gate(statistic=1.0, dof=1, p_value=p)})


def found(*steps):
    held_out = SimpleNamespace(
        gap=lambda fit, rng, num_simulated: fit.gap, shrank=lambda new, old: new.gap.value < old.gap.low
    )
    return Found.of(Poisson(), None, None, held_out, list(steps), None, 0.05, np.random.default_rng(0), Effort())


def gap(low, value, high):
    return Gap(value=value, low=low, high=high)


EFFECT = SimpleNamespace(name="dead_time")
LARGE = gap(65, 70, 75)


@pytest.mark.parametrize(
    ("before", "p_before", "after", "p_after", "verdict"),
    [
        (LARGE, 1e-30, gap(0.8, 1.1, 1.6), 0.4, Verdict.NAMED),
        (LARGE, 1e-30, gap(1.08, 1.64, 2.19), 0.4, Verdict.REDUCED),  # the events kept aside contradict
        (LARGE, 1e-30, gap(0.8, 1.1, 1.6), 1e-3, Verdict.REDUCED),  # the gates contradict
        (gap(0.9, 1.02, 1.2), 1e-30, gap(0.9, 1.01, 1.2), 1e-3, Verdict.UNEXPLAINED),  # less than its error
        (LARGE, 1e-30, gap(62, 67, 72), 1e-30, Verdict.UNEXPLAINED),
        (LARGE, 1e-30, gap(70, 75, 80), 0.4, Verdict.UNEXPLAINED),  # it grew
        (LARGE, 1e-30, gap(35, 40, 45), 1e-30, Verdict.REDUCED),
        (gap(0.9, 1.02, 1.2), 0.01, gap(0.9, 1.01, 1.2), 0.4, Verdict.NAMED),
    ],
)
def test_the_verdict_contradicts_neither_the_gates_nor_the_gap(before, p_before, after, p_after, verdict):
    one = found(step(p_before, before), step(p_after, after, EFFECT))
    assert one.verdict == verdict
    left_out = verdict == Verdict.UNEXPLAINED
    assert (one.gap_after is None, one.effects, one.withdrawn) == (
        left_out,
        () if left_out else (EFFECT,),
        (EFFECT,) if left_out else (),
    )


def test_a_p_value_below_alpha_but_not_below_its_share_of_it_is_no_disagreement():
    assert found(step(0.044, gap(0.7, 1.0, 1.3))).verdict == Verdict.NOTHING  # 0.044 / 0.8 = 0.055
    assert found(step(0.039, gap(0.7, 1.0, 1.3))).verdict == Verdict.UNEXPLAINED


def test_a_gap_of_one_beside_a_small_p_value_is_explained():
    gates = {
        "summary": Gate(statistic=1.0, dof=1, p_value=0.3),
        "classifier": Gate(statistic=13.6, dof=None, p_value=3e-42),
    }
    one = found(replace(step(1.0, gap(0.7, 0.93, 1.2)), gates=gates))
    assert one.verdict == Verdict.UNEXPLAINED
    assert unseen(one) == "the gap is of the summary, and does not show what the classifier saw"
    few = found(step(1e-3, gap(0.7, 1.2, 1.9)))
    assert unseen(few) == "the events kept aside are too few to show by themselves what the others show"


def test_a_theta_outside_the_prior_is_told():
    wide = task(lambda theta, rng: rng.normal(theta[:, 0]), prior={"mu": (-1, 1)}, support={"mu": (-9, 9)}, name="wide")
    fit = SimpleNamespace(model=Model(wide), params=np.array([2.94]))
    assert prior_notes(fit, "without effects") == ["mu = 2.94, fitted without effects, lies outside its prior, -1 to 1"]
    assert prior_notes(SimpleNamespace(model=Model(wide), params=np.array([0.9])), "without effects") == []
