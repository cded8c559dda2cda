from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.effort import Effort, effort_for
from avobench.diagnosis.fit import surrogate as surrogate_module
from avobench.diagnosis.fit.descent import minimise, refine
from avobench.diagnosis.fit.fit import fit_at
from avobench.diagnosis.fit.null import best_null, fit_null
from avobench.diagnosis.fit.scan import SEARCHED, scan
from avobench.diagnosis.fit.sharpening import settled, sharpen
from avobench.diagnosis.fit.surrogate import Design, quadratic, surrogate
from avobench.diagnosis.gates.cells import cell_gate
from avobench.diagnosis.gates.summary import summary_gate
from avobench.diagnosis.summary.bins import bins_of, closed
from avobench.diagnosis.summary.pixels import pixels_of
from avobench.diagnosis.summary.target import target_of, whitening
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

LIGHT = Effort(sharpen=6, covariance=30_000)


def measured(task, theta, n, seed):
    rng = np.random.default_rng(seed)
    return task.simulate(np.tile(theta, (n, 1)), rng), rng


def test_bins_hold_all_events_and_no_count_is_split():
    x, _rng = measured(Poisson(), [2.0], 5000, 0)
    bins = bins_of(x, x)
    assert bins.mean(x).sum() == pytest.approx(1)
    assert all(edge % 1 == 0.5 for edge in bins.edges[0])
    pieces = bins.mean(x, 5)
    np.testing.assert_allclose(pieces.mean(axis=0), bins.mean(x)[0])


@given(
    st.lists(st.floats(-10, 10), min_size=1, max_size=30),
    st.lists(st.integers(-9, 9), max_size=8, unique=True),
)
def test_edges_grow_also_where_only_simulated_events_lie(values, inner):
    inner = np.sort(np.array(inner, dtype=float))
    edges = closed(inner, np.array(values))
    assert (np.diff(edges) > 0).all()
    assert edges[0] <= min(values)
    assert edges[-1] >= max(values)
    np.testing.assert_array_equal(edges[1:-1], inner)


@given(st.integers(0, 30))
def test_the_moments_of_images_add_up_also_where_there_are_none(cut):
    rng = np.random.default_rng(0)
    images, weights = rng.integers(0, 2, (30, 4 * 10)), rng.standard_normal((30, 3))
    summary = pixels_of(images, images, (4, 10))
    first, rest = summary.moments(images[:cut], weights[:cut]), summary.moments(images[cut:], weights[cut:])
    np.testing.assert_allclose(first + rest, summary.moments(images, weights), rtol=1e-5, atol=1e-5)


def test_covariance_is_that_of_the_vectors_and_whitens():
    x, _rng = measured(Carl(), [0.5, -1.0], 4000, 1)
    bins = bins_of(x, x)
    rows = np.zeros((len(x), bins.size))
    np.put_along_axis(rows, bins.indices(x), 1, axis=1)
    cov = bins.covariance(x)
    np.testing.assert_allclose(cov, np.cov(rows.T, bias=True), atol=1e-12)
    w = whitening(cov)
    np.testing.assert_allclose(w.T @ cov @ w, np.eye(w.shape[1]), atol=1e-6)
    assert w.shape[1] == np.linalg.matrix_rank(cov, tol=1e-9)


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


def test_poisson_fit_attains_the_fisher_information():
    task = Poisson()
    pulls = []
    for k in range(6):
        x, rng = measured(task, [1.5], 4000, k)
        fit, target = fit_null(Model(task), x, rng, LIGHT, None)
        _, own, _ = summary_gate(fit, target, rng, LIGHT)
        assert own.std[0] == pytest.approx(np.sqrt((1 + own.noise) / (4000 * np.exp(1.5))), rel=0.3)
        pulls.append((own.params[0] - 1.5) / own.std[0])
    assert np.sqrt(np.mean(np.square(pulls))) < 2


@pytest.mark.parametrize("around", [None, 0.7, 0.3])
def test_a_scan_comes_near_the_best_or_as_near_as_it_may(around):
    task = Poisson()
    x, rng = measured(task, [2.0], 20_000, 4)
    model, target = Model(task), target_of(x, bins_of(x, x), x)
    (u,), near = scan(model, target, rng, around=None if around is None else np.array([around]))
    at = 0.6  # of log rates from -10 to 10
    within = at if around is None else np.clip(at, around - SEARCHED, around + SEARCHED)
    assert u == pytest.approx(within, abs=0.01)
    assert near < 0.01


def test_weinberg_identifies_one_direction():
    task = Weinberg()
    x, rng = measured(task, [46.3, 1.2], 8000, 3)
    fit, target = fit_null(Model(task), x, rng, Effort(), None)
    _gate, own, _ = summary_gate(fit, target, rng, Effort())
    assert own.num_identified == 1
    c = task.asymmetry(own.params[None])[0]
    assert c == pytest.approx(task.asymmetry(np.array([[46.3, 1.2]]))[0], abs=5 * 2.2 / np.sqrt(8000))


def test_p_values_of_a_true_model_are_not_small():
    p = []
    for k in range(8):
        x, rng = measured(Poisson(), [0.5 * k], 3000, 100 + k)
        fit, target = fit_null(Model(Poisson()), x, rng, LIGHT, None)
        p.append(summary_gate(fit, target, rng, LIGHT)[0].p_value)
    assert min(p) > 1e-4
    assert sum(v < 0.05 for v in p) <= 3


def test_where_nothing_is_expected_and_nothing_measured_a_fit_makes_nothing():
    """Without counts below 6, the model's own covariance knows none either, and would let the threshold fall."""
    (effect,) = (e for e in catalogue(Poisson()) if e.name == "threshold_loss")
    x = np.random.default_rng(41).poisson(9.0, 40_000)
    x = x[x > 5][:5000, None]
    model = Model(Poisson(), (effect.adapted(x),))
    at = np.array([np.log(9.0), 1.0, 6.0])
    rng = np.random.default_rng(0)
    simulated = Poisson().simulate(np.tile(at[:1], (20_000, 1)), rng)
    target = target_of(x, bins_of(x, simulated), simulated)
    for seed in range(4):
        fit = refine(model, target, model.to_cube(at), 0.005, np.random.default_rng(seed), num_events=20_000)
        gate, own, _ = summary_gate(fit, target, np.random.default_rng(seed), LIGHT)
        assert own.params[2] > 5.9
        assert gate.dof < target.rank - 3  # what cannot be otherwise is no degree of freedom
        assert gate.p_value > 1e-3


@pytest.mark.parametrize("events", [200, 3000])
def test_of_images_one_cell_that_fires_where_none_should_is_seen_and_few_images_suffice(events):
    class Still:
        def simulate(self, params, rng):
            return rng.random((len(params), 64)) < np.where(np.arange(64) < 8, 0.0, 0.002)

    still = SimpleNamespace(model=Still(), params=np.zeros(1))
    rng = np.random.default_rng(0)
    x = Still().simulate(np.zeros((events, 1)), rng)
    assert cell_gate(still, x, rng, LIGHT).p_value > 0.01
    x[:, 3] = rng.random(events) < 0.1
    gate = cell_gate(still, x, rng, LIGHT)
    assert gate.p_value < 1e-9
    assert np.isfinite(gate.statistic)


def test_all_events_of_a_pool_come_once_before_any_comes_again():
    class Numbered:
        def generate(self, num_events, rng):
            yield Piece(np.arange(num_events))

        def detect(self, generated, theta):
            return generated.numbers[:, None]

    class Piece:
        def __init__(self, numbers):
            self.numbers = numbers

        def __len__(self):
            return len(self.numbers)

        def events(self, start, stop):
            return Piece(self.numbers[start:stop])

    model = Model(Poisson(), events=Pool(Numbered(), 150_000, np.random.default_rng(0)))
    drawn = []
    vectors = SimpleNamespace(
        moments=lambda x, b: drawn.append(x) or b.T @ np.ones((len(x), 1)),
        moved=lambda before, after: np.ones(len(before)),
    )
    surrogate(model, vectors, Design.box(np.array([0.5]), np.array([0.1])), 240_000, np.random.default_rng(1))
    assert len(np.unique(np.concatenate(drawn[::2]))) == 120_000


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


def test_effort_follows_the_number_of_simulations():
    task = Poisson()
    assert effort_for(task, "counts", None) == Effort()
    less = effort_for(task, "counts", 400_000)
    assert less.fit < Effort().fit
    assert less.fit >= 3000


@pytest.fixture(scope="module")
def background():
    """Counts with a background of 6 %, the fit of the simulator without it, and the simulator with it."""
    effect = next(e for e in catalogue(Poisson()) if e.name == "flat_background")
    rng = np.random.default_rng(6)
    theta, phi = np.tile([1.0], (20_000, 1)), np.tile([0.06, 6.0], (20_000, 1))
    x = effect.apply(Poisson().simulate, theta, phi, rng)
    fit, target = fit_null(Model(Poisson()), x, rng, LIGHT, None)
    return Model(Poisson(), (effect,)), fit, target


def test_a_known_base_leaves_only_the_noise_of_what_the_effect_changes(background):
    model, fit, target = background
    rng = np.random.default_rng(0)
    base = fit.known(target, 400_000, rng)
    design = Design.box(model.to_cube(np.r_[fit.params, 0.03, 6.0]), np.array([1e-3, 0.01, 0.02]))
    ours = base.extended(model, target, base.within(design), 40_000, rng)
    plain = surrogate(model, target, design, 400_000, rng)
    assert ours.inverse[0, 0] < 0.3 / 40_000 + 2 / 400_000
    pull = (ours.coefficients[0] - plain.coefficients[0]) / np.sqrt(
        (ours.inverse[0, 0] + plain.inverse[0, 0]) * np.diag(target.cov)
    )
    assert np.sqrt(np.mean(pull**2)) < 2
    far = Design.box(model.to_cube(np.r_[fit.params + 0.5, 0.03, 6.0]), np.array([1e-3, 0.01, 0.02]))
    assert base.within(far) is None


@pytest.mark.parametrize("start", [(0.02, 5.0), (0.12, 5.0)])
def test_a_fit_goes_to_the_optimum_from_far_off_and_with_few_events(background, start):
    model, fit, target = background
    base = fit.known(target, 400_000, np.random.default_rng(0))
    unit, half = model.to_cube(np.r_[fit.params, start]), [0.02, 0.03, 0.08]
    fits = [
        refine(model, target, unit, half, np.random.default_rng(k), num_events=80_000, known=base) for k in range(3)
    ]
    for found in fits:
        assert (
            found.noiseless_q - 3 * found.noiseless_q_error < found.dof + 3 * np.sqrt(2 * found.dof) < fit.noiseless_q
        )
    assert (np.abs(np.median([found.params for found in fits], axis=0) - [1.0, 0.06, 6.0]) < [0.02, 0.03, 0.8]).all()


def test_a_fit_that_leaves_much_is_the_same_whatever_the_seed():
    """Counts with a long tail, which no rate describes: a search that stops short would show in the gap."""
    rng = np.random.default_rng(7)
    x = rng.poisson(4 * rng.pareto(2.5, 8000) + 0.5)[:, None]
    found = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        fit, target = fit_null(Model(Poisson()), x, rng, LIGHT, None)
        found.append(best_null([fit], target, rng, LIGHT).params[0])
    assert np.ptp(found) < 0.1


@pytest.mark.parametrize("known", [False, True])
def test_a_design_over_which_the_events_are_no_quadratic_is_narrowed(known):
    """A narrow peak whose place is not known to its width: what is spread over the design says another mean there."""
    task, truth = Weinberg(), [45.0, 1.2, 0.05, 0.1, 0.01]
    model = Model(task, (next(effect for effect in catalogue(task) if effect.name == "peak_background"),))
    x, rng = measured(model, truth, 40_000, 0)
    target, unit = target_of(x, bins_of(x, x), x), model.to_cube(np.array(truth))
    without = refine(Model(task), target, unit[:2], 0.02, rng, num_events=30_000).known(target, 400_000, rng)
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


@pytest.mark.parametrize(("name", "strength"), [("offset", 0.1), ("scale", 0.02), ("flat_background", 0.1)])
def test_the_noise_of_what_an_effect_changes_is_known(name, strength):
    """The squared difference of the means with and without it, beyond what more events would leave."""
    task, rng, n = Carl(), np.random.default_rng(0), 4000
    theta = np.tile([0.1, -0.5], (n, 1))
    x = task.simulate(theta, rng)
    target = target_of(x, bins_of(x, x), x)
    effect = next(e for e in catalogue(task, x) if e.key == (name, 4)).adapted(x)
    phi = np.full((n, 1), strength)
    steps, moved = [], []
    for _ in range(60):
        before = task.simulate(theta, rng)
        after = effect.apply(lambda theta, rng, x=before: x.copy(), theta, phi, rng)
        steps.append(target.whiten(target.summary.mean(after)[0] - target.summary.mean(before)[0]))
        moved.append(target.moved(before, after).mean())
    assert np.var(steps, axis=0, ddof=1).mean() == pytest.approx(np.mean(moved), rel=0.15)
    apart = target.moved(task.simulate(theta, rng), task.simulate(theta, rng)).mean()
    assert apart == pytest.approx(2, rel=0.1)


def test_a_fit_of_hard_edges_goes_on_in_narrower_designs(monkeypatch):
    """A scale moves the ends of the range: over a wide design the bins there are no polynomial of it."""
    task, truth, start = Weinberg(), [45.0, 1.2, 0.08], [45.0, 1.2, 0.074]
    scale = next(effect for effect in catalogue(task) if effect.name == "scale")
    model = Model(task, (replace(scale, shape="linear"),))
    gaps = {0: [], surrogate_module.NARROWER: []}
    for seed in range(4):
        x, rng = measured(model, truth, 60_000, seed)
        target = target_of(x, bins_of(x, model.simulate(np.tile(truth, (len(x), 1)), rng)), x)
        first = refine(model, target, model.to_cube(np.array(start)), 0.02, rng, num_events=30_000, max_rounds=1)
        for times, found in gaps.items():
            monkeypatch.setattr(surrogate_module, "NARROWER", times)
            fit = sharpen(first, target, np.random.default_rng(2), 150_000, rounds=10)
            found.append(fit.noiseless_q - fit.dof)
    never, narrowed = gaps.values()
    assert max(narrowed) < max(never) / 2  # one of those that never narrow is stuck
    assert np.mean(narrowed) < np.mean(never)


def test_what_the_data_identify_is_settled_with_more_events():
    """Two directions: of weinberg's theta only one combination shows, and the smearing. From few events neither is
    plain; from more both are, and the error of the smearing is no longer that of its range."""
    task = Weinberg()
    (smearing,) = [effect for effect in catalogue(task) if effect.key == ("resolution", 0)]
    model, truth = Model(task, (smearing,)), np.array([46.0, 1.0, 0.25])
    rng = np.random.default_rng(4)
    x = model.simulate(np.tile(truth, (20_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)
    design = Design.box(model.to_cube(truth), np.array([0.01, 0.01, 0.02]))
    few = fit_at(model, surrogate(model, target, design, 10_000, rng), target, model.to_cube(truth))
    assert few.undecided
    assert few.num_identified < 2
    plain = settled(few, target, rng, 20_000, (30, 90))
    assert plain.num_identified == 2
    assert plain.std[2] < 0.01 < 0.1 < few.std[2]
    assert abs(plain.params[2] - truth[2]) < 4 * plain.std[2]
