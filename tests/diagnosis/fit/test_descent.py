"""Fits by descent: the scan before it, the steps, and what settles them."""

from dataclasses import replace

import numpy as np
import pytest
from measurements import LIGHT, entry, measured

from avobench.diagnosis.fit import surrogate as surrogate_module
from avobench.diagnosis.fit.descent import descend, minimise, refine, scan, settled, sharpen
from avobench.diagnosis.fit.fit import fit_at
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.fit.surrogate import Design, surrogate
from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.model import Model
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


@pytest.mark.parametrize("around", [None, 0.7, 0.3])
def test_a_scan_comes_near_the_best_or_as_near_as_it_may(around):
    task = Poisson()
    x, rng = measured(task, [2.0], 20_000, 4)
    model, target = Model(task), target_of(x, bins_of(x, x), x)
    (u,), near = scan(model, target, rng, around=None if around is None else np.array([around]))
    at = 0.6  # of log rates from -10 to 10
    within = at if around is None else np.clip(at, around - FIT.searched, around + FIT.searched)
    assert u == pytest.approx(within, abs=0.01)
    assert near < 0.01


@pytest.fixture(scope="module")
def background():
    """Counts with a background of 6 %, the fit of the simulator without it, and the simulator with it."""
    model = Model(Poisson(), (entry(Poisson(), "flat_background"),))
    x, rng = measured(model, [1.0, 0.06, 6.0], 20_000, 6)
    return model, *fit_null(Model(Poisson()), x, rng, LIGHT, None)


def test_a_known_base_leaves_only_the_noise_of_what_the_effect_changes(background):
    model, fit, target = background
    rng = np.random.default_rng(0)
    base = fit.reference(target, 400_000, rng)
    design = Design.box(model.to_cube(np.r_[fit.params, 0.03, 6.0]), np.array([1e-3, 0.01, 0.02]))
    ours = base.extended(model, target, base.within(design), 40_000, rng)
    plain = surrogate(model, target, design, 400_000, rng)
    assert ours.inverse[0, 0] < 0.3 / 40_000 + 2 / 400_000
    variance = (ours.inverse[0, 0] + plain.inverse[0, 0]) * np.diag(target.cov)
    assert np.mean((ours.coefficients[0] - plain.coefficients[0]) ** 2 / variance) < 4
    far = Design.box(model.to_cube(np.r_[fit.params + 0.5, 0.03, 6.0]), np.array([1e-3, 0.01, 0.02]))
    assert base.within(far) is None


@pytest.mark.parametrize("start", [(0.02, 5.0), (0.12, 5.0)])
def test_a_fit_goes_to_the_optimum_from_far_off_and_with_few_events(background, start):
    model, fit, target = background
    base = fit.reference(target, 400_000, np.random.default_rng(0))
    design = base.design(model.to_cube(np.r_[fit.params, start]), np.array([0.02, 0.03, 0.08]))
    found = []
    for k in range(3):
        one = descend(model, target, design, np.random.default_rng(k), 80_000, 10, base)
        assert one.noiseless_q - 3 * one.noiseless_q_error < one.dof + 3 * np.sqrt(2 * one.dof) < fit.noiseless_q
        found.append(one.params)
    assert (np.abs(np.median(found, axis=0) - [1.0, 0.06, 6.0]) < [0.02, 0.03, 0.8]).all()


def test_a_fit_is_not_held_back_by_the_noise_of_its_slopes():
    """From few events and far off, a fit still goes to the optimum of its design."""
    task = Weinberg()
    x, rng = measured(task, [46.0, 1.2], 20_000, 4)
    simulated, _ = measured(task, [46.0, 0.9], 20_000, 5)
    target = target_of(x, bins_of(x, simulated), simulated)
    model = Model(task)
    design = Design.box(model.to_cube(np.array([46.0, 0.9])), np.array([1e-3, 0.2]))
    fits = [minimise(model, surrogate(model, target, design, 10_000, rng), target).params[1] for _ in range(5)]
    assert np.mean(fits) == pytest.approx(1.2, abs=0.06)


def test_a_fit_of_hard_edges_goes_on_in_narrower_designs(monkeypatch):
    """A scale moves the ends of the range: over a wide design the bins there are no polynomial of it."""
    task, truth, start = Weinberg(), [45.0, 1.2, 0.08], [45.0, 1.2, 0.074]
    model = Model(task, (replace(entry(task, "scale"), shape="linear"),))
    gaps = {0: [], FIT.narrower: []}
    for seed in range(4):
        x, rng = measured(model, truth, 60_000, seed)
        target = target_of(x, bins_of(x, model.simulate(np.tile(truth, (len(x), 1)), rng)), x)
        first = refine(model, target, model.to_cube(np.array(start)), 0.02, rng, num_events=30_000, max_rounds=1)
        for times, found in gaps.items():
            monkeypatch.setattr(surrogate_module, "FIT", replace(FIT, narrower=times))
            fit = sharpen(first, target, np.random.default_rng(2), 150_000, rounds=10)
            found.append(fit.noiseless_q - fit.dof)
    never, narrowed = gaps.values()
    assert max(narrowed) < max(never) / 2  # one of those that never narrow is stuck
    assert np.mean(narrowed) < np.mean(never)


def test_what_the_data_identify_is_settled_with_more_events():
    """Two directions: of weinberg's theta only one combination shows, and the smearing. From few events neither is
    plain; from more both are, and the error of the smearing is no longer that of its range."""
    task = Weinberg()
    model, truth = Model(task, (entry(task, "resolution", 0),)), np.array([46.0, 1.0, 0.25])
    x, rng = measured(model, truth, 20_000, 4)
    target = target_of(x, bins_of(x, x), x)
    design = Design.box(model.to_cube(truth), np.array([0.01, 0.01, 0.02]))
    few = fit_at(model, surrogate(model, target, design, 10_000, rng), target, model.to_cube(truth))
    assert few.undecided
    assert few.num_identified < 2
    plain = settled(few, target, rng, 20_000, (30, 90))
    assert plain.num_identified == 2
    assert plain.std[2] < 0.01 < 0.1 < few.std[2]
    assert abs(plain.params[2] - truth[2]) < 4 * plain.std[2]
