from dataclasses import replace

import numpy as np
import pytest
from measurements import with_effect

from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.gates.held_out import HeldOut
from avobench.diagnosis.search.ranking import TIE, Ranked
from avobench.diagnosis.search.search import Search
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks.poisson import Poisson


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_second_effect_stays_only_where_the_first_alone_does_not_do(share):
    effects, rng = {e.name: e for e in catalogue(Poisson())}, np.random.default_rng(1)
    model, params = Model(Poisson(), (effects["zero_inflation"], effects["flat_background"])), [1.5, 0.1, share, 30.0]
    x = model.simulate(np.tile(params, (10_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)
    fit = refine(model, target, model.to_cube(np.array(params)), 0.02, rng, num_events=30_000)
    null = Step(fit, fit, {}, [Ranked(model.effects[0], fit, 0.0)])
    effort = effort_for(Poisson(), "counts", None)
    search = Search(target, x, HeldOut(target, target.mean, 1000), [], 0.05, 3, rng, effort, 1)
    steps = search.without_second([null, null, Step(fit, fit, {}, [])])
    kept = ["zero_inflation", "flat_background"] if share else ["zero_inflation"]
    assert [effect.name for effect in steps[-1].fit.model.effects] == kept
    if not share:
        assert steps[-1].p_value > 0.05
        assert [step.added.effect.name for step in steps[:-1]] == kept


def test_no_further_effect_is_looked_for_after_so_many_simulated_events():
    x, rng = with_effect(Poisson(), "zero_inflation", [1.5], [0.2], 2000), np.random.default_rng(1)
    effort = replace(effort_for(Poisson(), "counts", 200_000), enough=0)
    model = Model(Poisson(), events=Counted(Poisson()))
    null, target = fit_null(model, x, rng, effort, None)
    before = Step.of(null, target, x, rng, effort)
    assert before.p_value < 1e-6
    search = Search(target, x, HeldOut(target, target.mean, 1000), catalogue(Poisson()), 0.05, 3, rng, effort, 1)
    steps, notes = search.steps_from(before)
    assert len(steps) == 1
    assert steps[0] is before
    assert "ended early" in notes[0]


def test_the_first_of_two_effects_is_chosen_anew_beside_the_second():
    """Alone, zeros beside another effect may be described worse than by what imitates both."""
    effects, rng = {e.name: e for e in catalogue(Poisson())}, np.random.default_rng(1)
    zeros, wrong, spread = (effects[name] for name in ("zero_inflation", "dead_time", "overdispersion"))
    truth = [1.5, 0.1, 0.2]
    x = Model(Poisson(), (zeros, spread)).simulate(np.tile(truth, (10_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)

    def fitted(*chosen, start):
        model = Model(Poisson(), chosen)
        return refine(model, target, model.to_cube(np.array(start)), 0.02, rng, num_events=30_000)

    null, alone, other = (
        fitted(*chosen, start=start) for chosen, start in (((), [1.5]), ((wrong,), [1.5, 0.02]), ((zeros,), [1.5, 0.1]))
    )
    pair = fitted(wrong, spread, start=[1.5, 0.02, 0.2])
    ranks = [Ranked(wrong, alone, 0.0), Ranked(zeros, other, TIE / 2)]
    steps = [Step(null, null, {}, ranks), Step(alone, alone, {}, [Ranked(spread, pair, 0.0)]), Step(pair, pair, {})]
    effort = effort_for(Poisson(), "counts", None)
    search = Search(target, x, HeldOut(target, target.mean, 1000), [], 0.05, 3, rng, effort, 1)
    first, second, last = search.first_again(steps)
    assert [effect.name for effect in last.fit.model.effects] == ["zero_inflation", "overdispersion"]
    assert [first.added.effect.name, second.added.effect.name] == ["zero_inflation", "overdispersion"]
    assert first.ties == []
    assert last.p_value > 0.05
    np.testing.assert_allclose(last.fit.params[1:], truth[1:], atol=0.04)
    # The right one stays, and what cannot take its place is no longer tied with it.
    right = [replace(steps[0], ranks=[Ranked(zeros, other, 0.0), Ranked(wrong, alone, TIE / 2)]), second, last]
    first, *_ = search.first_again(right)
    assert first.added.effect.name == "zero_inflation"
    assert first.ties == []
