"""Where fits of an effect begin, and where two populations are looked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import entry, with_effect

from avobench import task as task_of
from avobench.diagnosis.effort import Effort, effort_for
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.search.candidates import approach, begin, check, go_on, search_again
from avobench.diagnosis.search.populations import best_pairs, populations
from avobench.diagnosis.search.screening import Around, Sample, Start, glance, hidden, looked_again, starts_of
from avobench.effects.model import Model
from avobench.tasks.carl import Carl
from avobench.tasks.weinberg import Weinberg


def screened(null, target, effect, x, rng, effort):
    """The reference at a fit, the sample there, and where fits of an effect may begin, the best first."""
    reference = null.reference(target, int(effort.reference * target.num_events), rng)
    sample = Sample(null, target, effort.sample, rng, Around(reference, target))
    look = looked_again(sample, glance(sample, effect, effect.guess(x), rng, effort), rng)
    return reference, sample, starts_of(sample, look)


def test_what_theta_hides_is_also_begun_where_it_is_strong(counter):
    """In a valley: a longer dead time at a higher rate."""
    effort, found = Effort(), []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        reference, sample, starts = screened(counter.null, counter.target, counter.effect, counter.x, rng, effort)
        starts = hidden(sample, starts[0], rng, effort)
        fits = [begin(start, reference, counter.target, rng, 20_000) for start in starts]
        fits = [go_on(fit, reference, counter.target, rng, 20_000, 7) for fit in fits]
        strong = min(fits, key=lambda fit: abs(fit.params[1] - counter.truth.strong[1]))
        near = np.allclose(strong.params, counter.truth.strong, atol=0.5)
        found.append(near and strong.noiseless_q < strong.dof + 3 * np.sqrt(2 * strong.dof))
    assert sum(found) >= 3


def test_a_start_that_goes_too_far_is_tried_on_the_way():
    task = task_of(lambda theta, rng: rng.normal(theta, 1), prior={"mean": (0, 1)}, name="normal")
    x, rng = with_effect(task, "flat_background", [0.4], [0.1], 8000), np.random.default_rng(2)
    null, target = fit_null(Model(task), x, rng, Effort(), None)
    reference = null.reference(target, int(Effort().reference * target.num_events), rng)
    model = null.model.plus(entry(task, "flat_background"))
    points = [np.r_[null.point, model.to_cube(np.array([*null.params, share]))[1:]] for share in (0.1, 0.25, 0.9)]
    starts = [Start(model, point, np.nan, 0.1) for point in points]
    right, far, farther = (check(start, reference, target, np.random.default_rng(4), 20_000) for start in starts)
    assert right.expected < null.noiseless_q
    np.testing.assert_allclose(far.point, right.point, atol=1e-9)  # 0.4 of the way to 0.25 is 0.1
    assert farther.expected > right.expected


def test_an_effect_that_theta_takes_up_for_the_most_part_is_approached_along_both():
    """An offset of 0.5 moves theta of carl by fifteen of its errors: from there it looks as if it explained little."""
    task, rng = Carl(), np.random.default_rng(0)
    offset = entry(task, "offset", 0)
    middle = np.add(task.prior.low, task.prior.high) / 2
    x = Model(task, (offset,)).simulate(np.tile([*middle, 0.5], (10_000, 1)), rng)
    effort = effort_for(task, "continuous", None, len(x))
    null, target = fit_null(Model(task), x, rng, effort, None)
    reference, _, starts = screened(null, target, offset, x, rng, effort)
    start = check(starts[0], reference, target, rng, effort.fit)
    reached = approach(start, reference, target, rng, effort.fit, null)
    assert reached.expected < 0.7 * start.expected
    assert reached.expected < 300 < start.expected  # 190 degrees of freedom, and an error of 40 by simulation
    before, after = (each.model.from_cube(each.point)[0] for each in (start, reached))
    assert abs(after - middle[0]) < abs(before - middle[0]) - 0.05


@pytest.mark.parametrize("seed", [2, 3])
def test_theta_is_not_expected_beyond_its_range(seed):
    prior, rng = {"mean": (0, 1), "width": (0.5, 2)}, np.random.default_rng(seed)
    task = task_of(lambda theta, rng: rng.normal(*theta.T), prior=prior, name="normal")
    null, target = fit_null(Model(task), rng.normal(2, 1, (8000, 1)), rng, Effort(rounds=3), None)
    reference = null.reference(target, int(Effort().reference * target.num_events), rng)
    nothing = np.zeros((1, target.rank))
    expected = Around(reference, target).expected(nothing, np.zeros(1), np.ones(1), null.point, 4)
    assert null.at_bound[0] == 1
    assert expected.point.max() <= 1
    assert expected.q[0] > null.noiseless_q - 4 * null.noiseless_q_error


def test_a_fit_begins_where_a_gap_is_that_is_narrower_than_any_grid():
    task, at = Weinberg(), 0.795
    x = with_effect(task, "dead_region", [45.5, 1.0], [0.8, at, 0.025], 20_000)
    rng, effort = np.random.default_rng(1), effort_for(task, "continuous", None, 20_000)
    base, target = fit_null(Model(task), x, rng, effort, None)
    _, _, (best, *_) = screened(base, target, entry(task, "dead_region"), x, rng, effort)
    _, centre, width = best.model.from_cube(best.point)[-3:]
    assert centre == pytest.approx(at, abs=0.03)
    assert width < 0.1
    assert best.expected < 0.8 * base.noiseless_q


def test_a_fit_that_went_astray_is_looked_for_all_around():
    """Theta and the edge of an exponential that was moved follow each other along a bent way."""
    task = task_of(lambda theta, rng: rng.exponential(theta), prior={"tau": (1, 4)}, name="decay")
    rng = np.random.default_rng(1)
    null, target = fit_null(Model(task), 0.5 + rng.exponential(2, (4000, 1)), rng, Effort(), None)
    model = null.model.plus(entry(task, "offset"))
    reference = null.reference(target, 20_000, rng)
    start = Start(model, model.to_cube(np.array([3.5, 0.9])), np.nan, 0.05)
    astray = begin(start, reference, target, rng, 4000)
    found = search_again(astray, reference, target, rng, 4000, *Effort().scan)
    assert astray.noiseless_q > 10 * astray.dof
    assert abs(found.params[0] - 2) < 0.4 * abs(astray.params[0] - 2)
    assert found.noiseless_q < 0.3 * astray.noiseless_q


HEIGHTS = task_of(lambda theta, rng: rng.normal(*theta.T), prior={"mean": (-10, 10), "width": (0.2, 8)}, name="heights")


@given(st.floats(0.05, 0.45), st.integers(0, 1000))
def test_the_pair_of_which_a_mean_is_the_mixture_is_found_with_its_share(share, seed):
    rng = np.random.default_rng(seed)
    means = rng.standard_normal((8, 20))
    mixed = (1 - share) * means[2] + share * means[5]
    pairs, shares, q = best_pairs(mixed - means, 0.0, np.ones(8, bool))
    assert pairs[0].tolist() == [2, 5]
    assert shares[0] == pytest.approx(share)
    assert q[0] == pytest.approx(0, abs=1e-9)


def test_two_narrow_populations_far_from_where_one_wide_one_fits_are_found():
    rng = np.random.default_rng(1)
    x = np.concatenate([rng.normal(-4, 0.5, 1400), rng.normal(3, 0.5, 600)])[:, None]
    null, target = fit_null(Model(HEIGHTS), x, rng, Effort(rounds=3), None)
    start = populations(null, target, entry(HEIGHTS, "mixture"), rng, Effort())[0]
    np.testing.assert_allclose(start.model.from_cube(start.point), [-4, 0.5, 0.3, 3, 0.5], atol=0.3)
    assert start.expected < 0.1 * null.noiseless_q
