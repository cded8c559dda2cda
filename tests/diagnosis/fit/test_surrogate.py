from types import SimpleNamespace

import numpy as np
import pytest
from measurements import entry, measured

from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.surrogate import Design, quadratic, surrogate
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.bank import Bank
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.tasks.meter import Meter
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


def test_twins_of_one_seed_make_slopes_precise():
    """The same seed gives nearly the same events at neighbouring theta, so slopes are known better than from a
    regression: its noise is what the covariance of the coefficients says."""
    task = Weinberg()
    model = Model(task)
    x, rng = measured(task, [46.0, 1.0], 2000, 2)
    summary = bins_of(x, x)
    target = target_of(x, summary, x)
    design = Design.box(model.to_cube(np.array([46.0, 1.0])), np.array([0.02, 0.02]))
    s = surrogate(model, target, design, 20_000, rng)
    assert s.inverse[1, 1] < 0.5 / 20_000 * 3 * 2
    fits = [surrogate(model, target, design, 20_000, np.random.default_rng(k)).coefficients[1] for k in range(20)]
    shares = summary.mean(x)[0]
    expected = np.sqrt(s.inverse[1, 1] * (shares * (1 - shares)).mean())
    assert np.sqrt(np.var(fits, axis=0).mean()) == pytest.approx(expected, rel=0.5)


@pytest.mark.parametrize("half", [0.002, 0.016], ids=["within a cell", "over some nodes"])
def test_events_that_others_had_of_the_same_nodes_make_a_surrogate_precise_and_cost_nothing(half):
    """The mean of a Poisson count is its rate, and that of the summary is the distribution of such counts."""
    task, meter = Poisson(), Meter()
    bank = Bank(task, meter, 0)
    bank.resolve(np.array([0.02]))
    model = Model(task, events=bank)
    theta = np.array([1.9])
    x, rng = measured(task, theta, 2000, 2)
    target = target_of(x, bins_of(x, x), x)
    design = Design.box(model.to_cube(theta), np.array([half]))
    alone = surrogate(model, target, design, 2000, np.random.default_rng(1))
    surrogate(model, target, design, 100_000, rng)
    made = meter.used
    shared = surrogate(model, target, design, 2000, np.random.default_rng(1))
    assert meter.used == made
    assert shared.inverse[0, 0] < alone.inverse[0, 0] / 10
    truth = target.summary.mean(task.simulate(np.tile(theta, (400_000, 1)), rng))[0]
    off = target.whiten(shared.at(model.to_cube(theta))[0] - truth)
    assert off @ off < target.num_events * target.rank * (shared.inverse[0, 0] + 1 / 400_000) * 4


def test_all_events_of_a_pool_come_once_before_any_comes_again():
    class Piece(np.ndarray):
        def events(self, start, stop):
            return self[start:stop]

    numbered = SimpleNamespace(
        generate=lambda num_events, rng: iter([np.arange(num_events).view(Piece)]),
        detect=lambda generated, theta: np.asarray(generated)[:, None],
    )
    model = Model(Poisson(), events=Pool(numbered, 150_000, np.random.default_rng(0)))
    drawn = []
    vectors = SimpleNamespace(
        moments=lambda x, b: drawn.append(x) or b.T @ np.ones((len(x), 1)),
        moved=lambda before, after: np.ones(len(before)),
    )
    surrogate(model, vectors, Design.box(np.array([0.5]), np.array([0.1])), 240_000, np.random.default_rng(1))
    assert len(np.unique(np.concatenate(drawn[::2]))) == 120_000


@pytest.mark.parametrize("known", [False, True])
def test_a_design_over_which_the_events_are_no_quadratic_is_narrowed(known):
    """A narrow peak whose place is not known to its width: what is spread over the design says another mean there."""
    task, truth = Weinberg(), [45.0, 1.2, 0.05, 0.1, 0.01]
    model = Model(task, (entry(task, "peak_background"),))
    x, rng = measured(model, truth, 40_000, 0)
    target, unit = target_of(x, bins_of(x, x), x), model.to_cube(np.array(truth))
    without = refine(Model(task), target, unit[:2], 0.02, rng, num_events=30_000).reference(target, 400_000, rng)
    wide = Design.box(unit, np.array([0.02, 0.02, 0.01, 0.05, 0.02]))

    def make(design):
        if known:
            return without.extended(model, target, design, 100_000, rng)
        return surrogate(model, target, design, 100_000, rng)

    assert make(wide).bends(target)
    narrower = quadratic(make, wide, target)
    assert not narrower.bends(target)
    np.testing.assert_allclose(np.diag(narrower.design.axes) / np.diag(wide.axes), narrower.design.axes[3, 3] / 0.05)
    assert narrower.design.axes[3, 3] <= 0.05 / 3
    smooth = Design.box(unit[:2], np.array([0.02, 0.02]))
    assert not surrogate(Model(task), target, smooth, 100_000, rng).bends(target)


def test_a_design_stays_wide_where_a_narrower_one_lacks_as_much():
    """Then it is noise, or a jump, and a narrow design only makes the slopes unknown."""

    def make(lacks):
        left = iter(lacks)

        def of(design):
            lack = next(left)
            return SimpleNamespace(design=design, lack=lambda _: (lack, 1.0), bends=lambda _: lack > 3)

        return of

    wide = Design.box(np.full(1, 0.5), np.full(1, 0.09))
    for lacks, half in ((2.0,), 0.09), ((90.0, 80.0), 0.09), ((90.0, 10.0, 9.0), 0.03), ((90.0, 10.0, 1.0), 0.01):
        assert quadratic(make(lacks), wide, None).design.axes[0, 0] == pytest.approx(half)
