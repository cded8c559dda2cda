import json
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic.errors import PydanticSchemaGenerationError

from avobench.bench import registry
from avobench.cli.diagnose import tried
from avobench.diagnosis import Diagnosis, diagnose
from avobench.diagnosis.answer.model_file import describe, kept
from avobench.diagnosis.answer.quoted import scaled_std
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.fit.fit import refine
from avobench.diagnosis.gates.summary import target_of
from avobench.diagnosis.loop import fit_null
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search.candidates import _distinct, _on_all, reshaped
from avobench.diagnosis.search.ranking import TIE, Ranked
from avobench.diagnosis.search.search import Search, _accepted, _pair, _shown
from avobench.diagnosis.search.starts import Sample, screen
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.bins import bins_of
from avobench.effects import Effect, Parameter
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.effects.model_file import AugmentedTask
from avobench.effects.pool import Counted
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

RUTHERFORD_GEIGER = (57, 203, 383, 525, 532, 408, 273, 139, 45, 27, 10, 4, 0, 1, 1)
"""Intervals with 0, 1, ... alpha particles: E. Rutherford, H. Geiger, Phil. Mag. 20 (1910) 698."""
HORSE_KICKS = (109, 65, 22, 3, 1)
"""Corps-years with 0, 1, ... deaths: L. von Bortkiewicz, Das Gesetz der kleinen Zahlen (1898)."""

CLAIMS = (103704, 14075, 1766, 255, 45, 6, 2)
"""Drivers with 0, 1, ... accidents in a year: H. Buehlmann, Mathematical Methods in Risk Theory (1970)."""


def counts(table):
    return np.repeat(np.arange(len(table)), table)[:, None]


def hidden(task, name, theta, phi, n, seed=0):
    effect = next(e for e in catalogue(task) if e.name == name)
    rng = np.random.default_rng(seed)
    return effect.apply(task.simulate, np.tile(theta, (n, 1)), np.tile(phi, (n, 1)), rng)


@pytest.mark.parametrize("table", [RUTHERFORD_GEIGER, HORSE_KICKS])
def test_nothing_is_missing_in_counts_that_are_poisson(table):
    x = counts(table)
    diagnosis = diagnose(Poisson(), x, alpha=0.01)
    assert diagnosis.verdict == Verdict.NOTHING
    assert diagnosis.effects == diagnosis.candidates == diagnosis.regions == []
    rate = diagnosis.theta_before["log_rate"]
    assert rate.value == pytest.approx(np.log(x.mean()), abs=4 * rate.std)  # fitted without a quarter of the events
    assert {row.name for row in diagnosis.identifiability} == {e.name for e in catalogue(Poisson())}


def test_drivers_differ_in_how_careful_they_are():
    diagnosis = diagnose(Poisson(), counts(CLAIMS))
    assert diagnosis.verdict == Verdict.NAMED
    (found,) = diagnosis.effects
    assert found.name == "overdispersion"
    assert found.parameters["variance"].value == pytest.approx(1.0, abs=0.3)  # 1.00 by the method of moments


def test_500_angles_behind_an_acceptance():
    """Not in a shape of the catalogue: a logistic loss beyond |cos| = 0.85."""
    task, rng = Weinberg(), np.random.default_rng(0)
    x = task.simulate(np.tile([45.0, 1.0], (2000, 1)), rng)
    seen = x[rng.random(len(x)) < 1 / (1 + np.exp((np.abs(x[:, 0]) - 0.85) / 0.03))][:500]
    diagnosis = diagnose(task, seen)
    first, *others = diagnosis.effects
    assert "edge_acceptance" in {first.name, *(rival.name for rival in first.tied_with)}
    assert not others
    assert diagnosis.verdict == Verdict.NAMED


def test_angles_within_a_fiducial_cut_of_unequal_ends():
    """Nothing is left beyond the ends, so that theta alone is far off, and a scale beside an offset is as sharp."""
    task, rng = Weinberg(), np.random.default_rng(0)
    x = task.simulate(np.tile([45.0, 1.0], (4000, 1)), rng)
    seen = x[(x[:, 0] > -0.7) & (x[:, 0] < 0.9)][:2000]
    chosen = [e for e in catalogue(task) if e.name in ("edge_acceptance", "offset", "scale", "dead_region")]
    diagnosis = diagnose(task, seen, effects=chosen)
    (found,) = diagnosis.effects
    assert found.name == "edge_acceptance"
    assert found.parameters["low"].value == pytest.approx(-0.7, abs=0.02)
    assert found.parameters["high"].value == pytest.approx(0.9, abs=0.02)
    assert diagnosis.verdict == Verdict.NAMED


def test_counts_of_which_the_zeros_are_not_recorded():
    x = np.random.default_rng(0).poisson(2.0, 6000)
    chosen = [e for e in catalogue(Poisson()) if e.name in ("threshold_loss", "zero_inflation", "inefficiency")]
    diagnosis = diagnose(Poisson(), x[x > 0][:4000, None], effects=chosen)
    (found,) = diagnosis.effects
    assert found.name == "threshold_loss"
    assert diagnosis.verdict == Verdict.NAMED
    log_rate = diagnosis.theta_after["log_rate"]
    assert log_rate.value == pytest.approx(np.log(2), abs=3 * log_rate.std)


@pytest.fixture(scope="module")
def named():
    x = hidden(Poisson(), "overdispersion", [2.5], [0.08], 8000)
    return x, diagnose(Poisson(), x)


def test_any_number_of_processes_finds_the_same_and_counts_the_same(named):
    x, diagnosis = named
    again = diagnose(Poisson(), x, jobs=2)
    assert again.model_dump(exclude={"seconds"}) == diagnosis.model_dump(exclude={"seconds"})


def test_a_few_events_that_the_simulator_cannot_make_are_a_disagreement():
    x = Weinberg().simulate(np.tile([45.0, 1.0], (2000, 1)), np.random.default_rng(0))
    x[:30, 0] = np.random.default_rng(1).uniform(-3, -1.5, 30)
    diagnosis = diagnose(Weinberg(), x, max_effects=0)
    assert diagnosis.gates["summary"].p_value < 1e-6
    assert diagnosis.verdict == Verdict.UNEXPLAINED


def test_several_counts_an_event_have_no_catalogue():
    class Pair(Poisson):
        num_features = 2

    with pytest.raises(UsageError, match="has 2 counts"):
        diagnose(Pair(), np.ones((300, 2), int))


def test_a_clear_effect_is_named_and_its_size_found(named):
    _, diagnosis = named
    assert diagnosis.verdict == Verdict.NAMED
    (found,) = diagnosis.effects
    assert (found.name, found.feature) == ("overdispersion", None)
    variance = found.parameters["variance"]
    assert variance.value == pytest.approx(0.08, abs=max(4 * variance.std, 0.015))
    assert diagnosis.gap_after.value < 2 < diagnosis.gap_before.value
    assert diagnosis.p_value_after > 0.05 > diagnosis.p_value_before
    assert diagnosis.candidates[0].score == 0
    assert {region.kind for region in diagnosis.regions} == {"excess", "deficit"}
    assert len(diagnosis.pictures.spectra[0].edges) == len(diagnosis.pictures.spectra[0].measured) + 1


def test_a_diagnosis_is_valid_json_and_repeats_for_a_seed(named):
    x, diagnosis = named
    text = json.dumps(diagnosis.model_dump(mode="json"), allow_nan=False)
    assert Diagnosis.model_validate_json(text).model_dump() == diagnosis.model_dump()
    again = diagnose(Poisson(), x).model_dump(exclude={"seconds"})
    assert again == diagnosis.model_dump(exclude={"seconds"})


def test_the_new_model_is_a_task_that_finds_nothing_missing(named, tmp_path):
    x, diagnosis = named
    path = tmp_path / "model.json"
    path.write_text(describe(diagnosis.model, scaled_std(diagnosis.model), "poisson", {}).model_dump_json())
    task = registry.build("task", str(path), {})
    assert isinstance(task, AugmentedTask)
    assert task.name == "poisson-overdispersion"
    assert task.parameter_names == ("log_rate", "overdispersion_variance")
    theta = np.tile([2.5, 0.08], (20_000, 1))
    y = task.simulate(theta, np.random.default_rng(1))
    assert y.var() == pytest.approx(np.exp(2.5) + 0.08 * np.exp(5.0), rel=0.05)
    with pytest.raises(ValueError, match="outside the support"):
        task.simulate(np.array([[2.5, -1.0]]), np.random.default_rng(1))
    assert diagnose(task, x, effects=[]).verdict == Verdict.NOTHING


@pytest.mark.parametrize("task", [Poisson(), Weinberg(), Carl(), Alignment()], ids=lambda task: task.name)
def test_a_model_file_keeps_what_the_data_decided_of_an_effect(task, tmp_path):
    if task.event_shape:
        x = np.zeros((400, 32 * 32), bool)
        x[:, :40] = x[:, 64:94] = True  # rows, some cells of which are dead, or alone alive
    else:
        x = task.simulate(
            np.tile(np.mean([task.prior.low, task.prior.high], axis=0), (2000, 1)), np.random.default_rng(0)
        )
        x[:1200] = np.round(x[:1200], 1)  # of which some effects read steps and limits
    for effect in catalogue(task):
        if effect.feature not in (None, 0, "all"):
            continue
        for shape in effect.adapted(x).shapes():
            model = Model(task, (shape,))
            fit = SimpleNamespace(model=model, params=model.from_unit(np.full(model.dim, 0.5)))
            path = tmp_path / "model.json"
            path.write_text(describe(fit, np.full(model.dim, 0.1), task.name, {}).model_dump_json())
            assert registry.read_model(str(path)).model.effects == (shape,)


def test_a_model_file_of_an_effect_that_does_not_exist_is_refused(tmp_path):
    path, model = tmp_path / "model.json", Model(Poisson(), (catalogue(Poisson())[0],))
    content = describe(SimpleNamespace(model=model, params=model.low), model.high, "poisson", {})
    for change in ({"shape": "round"}, {"name": "gremlins"}, {"settings": {"colour": "red"}}):
        effects = [content.effects[0].model_copy(update=change)]
        path.write_text(content.model_copy(update={"effects": effects}).model_dump_json())
        with pytest.raises(UsageError, match="does not apply to poisson"):
            registry.build("task", str(path), {})


def test_the_model_of_a_model_makes_the_events_that_were_fitted(tmp_path):
    """An effect that was found later comes after all of the model before, and one may be found again."""
    task, at = Weinberg(), [45.5, 1.0]
    for name, phi in (("quantisation", [0.3]), ("resolution", [0.2]), ("resolution", [0.1])):
        effect = next(effect for effect in catalogue(task) if effect.name == name)
        model, at = Model(task, (effect,)), [*at, *phi, *(p.high for p in effect.parameters[1:])]
        fit = SimpleNamespace(model=model, params=np.array(at))
        path = tmp_path / "model.json"
        path.write_text(describe(fit, np.full(model.dim, 0.1), "weinberg", {}).model_dump_json())
        task = registry.read_model(str(path))
    assert len(set(task.parameter_names)) == len(at)
    fitted, kept = (each.simulate(np.tile(at, (500, 1)), np.random.default_rng(0)) for each in (model, task))
    np.testing.assert_array_equal(fitted, kept)
    assert len(np.unique(kept)) == 500


def test_a_dead_region_is_found_where_it_is():
    x = hidden(Weinberg(), "dead_region", [45.5, 1.0], [0.8, 0.3, 0.15], 8000)
    diagnosis = diagnose(Weinberg(), x, max_effects=1)
    assert diagnosis.effects[0].name == "dead_region"
    deficit = next(region for region in diagnosis.regions if region.kind == "deficit")
    assert deficit.low < 0.3 < deficit.high
    assert diagnosis.effects[0].feature == "cos_angle"


def test_a_fit_begins_where_a_gap_is_that_is_narrower_than_any_grid():
    task, at = Weinberg(), 0.795
    x = hidden(task, "dead_region", [45.5, 1.0], [0.8, at, 0.025], 20_000)
    rng, effort = np.random.default_rng(1), effort_for(task, "continuous", None)
    base, target = fit_null(Model(task), x, rng, effort, None)
    effect = next(e for e in catalogue(task) if e.name == "dead_region")
    (best, *_) = screen(Sample(base, target, effort.sample, rng), effect, x, rng, effort)
    _, centre, width = best.model.from_unit(best.unit)[-3:]
    assert centre == pytest.approx(at, abs=0.03)
    assert width < 0.1
    assert best.expected < 0.8 * base.gap


@pytest.mark.parametrize(("count", "events"), [(2, 1000), (4, 300)])
def test_counts_that_are_all_alike_are_those_of_a_counter_that_is_blind_for_most_of_the_time(count, events):
    """A dead time of nearly so large a part of the window, at a high rate: all measured events are in one bin."""
    found = diagnose(Poisson(), np.full((events, 1), count), num_simulations=100_000)
    assert (found.verdict, [effect.name for effect in found.effects]) == ("missing effect named", ["dead_time"])
    assert found.p_value_before < 1e-6


def test_pairs_of_counts_that_theta_nearly_makes_up_for_are_found():
    rng = np.random.default_rng(1)
    x = rng.poisson(np.exp(3.84), (10_000, 1))
    x += rng.binomial(x, 0.23)
    diagnosis = diagnose(Poisson(), x)
    (found,) = diagnosis.effects
    assert "double_counting" in {found.name, *(rival.name for rival in found.tied_with)}
    assert diagnosis.verdict == Verdict.NAMED


def test_an_effect_that_is_not_in_the_catalogue_is_not_made_up():
    x = hidden(Poisson(), "overdispersion", [2.5], [0.08], 8000)
    wrong = [e for e in catalogue(Poisson()) if e.name in ("dead_time", "inefficiency")]
    diagnosis = diagnose(Poisson(), x, effects=wrong)
    assert diagnosis.verdict == Verdict.UNEXPLAINED
    assert diagnosis.correction.weights.mean() == pytest.approx(1)


@pytest.mark.parametrize(("arguments", "message"), [({"alpha": 2.0}, "alpha must lie"), ({"fit": "magic"}, "magic")])
def test_impossible_requests_are_refused(arguments, message):
    with pytest.raises(UsageError, match=message):
        diagnose(Poisson(), counts(HORSE_KICKS), **arguments)


def test_a_file_that_is_no_model_is_refused(tmp_path):
    path = tmp_path / "model.json"
    path.write_text("{}")
    with pytest.raises(UsageError, match="is not a model"):
        registry.build("task", str(path), {})


class Own(Effect):
    """A user's effect that does what it is told."""

    name = "own"
    parameters = (Parameter("strength", 0, 1, 0, "1"),)

    def __init__(self, events):
        self.events = events

    def apply(self, simulate, theta, phi, rng):
        return self.events(simulate(theta, rng))


def test_an_effect_of_the_users_is_tried_before_anything_is_fitted():
    tried("mod:Own", Own(lambda x: x), Weinberg())
    with pytest.raises(UsageError, match="'mod:Own' cannot be used, it raised ZeroDivisionError"):
        tried("mod:Own", Own(lambda x: 1 / 0), Weinberg())
    with pytest.raises(UsageError, match=r"'mod:Own' makes events of shape \(50,\), not \(50, 1\)"):
        tried("mod:Own", Own(lambda x: x[:, 0]), Weinberg())
    with pytest.raises(UsageError, match="must make finite events of float64, and makes float64: "):
        tried("mod:Own", Own(lambda x: x * np.nan), Weinberg())
    with pytest.raises(UsageError, match="must make finite events of int64, and makes float64: "):
        tried("mod:Own", Own(lambda x: x / 2), Poisson())


@dataclass(frozen=True)
class Table(Own):
    """Of an unusual type, as a user's field may be."""

    table: np.ndarray = field(default_factory=lambda: np.zeros(3))


def test_a_file_keeps_what_follows_the_data_or_says_that_it_cannot(monkeypatch):
    monkeypatch.setattr(registry, "effect", lambda source: Table())
    assert kept(Table(), Poisson(), "mod:Table").settings == {}
    with pytest.raises(PydanticSchemaGenerationError, match="ndarray"):
        kept(Table(np.ones(3)), Poisson(), "mod:Table")


def test_beside_a_second_effect_the_first_is_tried_in_its_other_shapes():
    """Alone, rounding down imitates rounding to the nearest and zeros beside it. Together both have their size."""
    effects, rng = {e.name: e for e in catalogue(Poisson())}, np.random.default_rng(1)
    zeros, shapes = effects["zero_inflation"], {s.shape: s for s in effects["quantisation"].shapes()}
    x = Model(Poisson(), (zeros, shapes["4 nearest"])).simulate(np.tile([1.5, 0.05, 0.1], (10_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)

    def fitted(*chosen, start):
        model = Model(Poisson(), chosen)
        return refine(model, target, model.to_unit(np.array(start)), 0.02, rng, num_events=30_000)

    down, nearest = (fitted(shapes[name], start=[1.5, 0.1]) for name in ("4 down", "4 nearest"))
    assert down.gap < nearest.gap
    pair = fitted(shapes["4 down"], zeros, start=[1.5, 0.1, 0.01])
    known = down.known(target, 100_000, rng)
    ((better, beside),) = reshaped([pair], known, (nearest,), target, rng, effort_for(Poisson(), "counts", None), 1e4)
    assert [effect.shape for effect in better.model.effects] == ["4 nearest", "dead"]
    assert beside.model.effects == (shapes["4 nearest"],)
    assert better.gap < better.dof + 4 * np.sqrt(2 * better.dof)
    assert better.gap < pair.gap - TIE
    np.testing.assert_allclose(better.params[1:], [0.1, 0.05], atol=0.02)


def test_a_pair_is_accepted_only_if_it_leaves_next_to_nothing():
    """Fits stand for themselves by what they leave: two firsts, and what a second one leaves beside each."""
    effects = {e.name: e for e in catalogue(Poisson())}

    def leaving(gap, *names):
        model = Model(Poisson(), tuple(effects[name] for name in names))
        unit = np.full(model.dim, 0.5)
        return SimpleNamespace(model=model, gap=gap, gap_error=0.0, dof=10, unit=unit, params=model.from_unit(unit))

    def ranked(fit):
        return Ranked(fit.model.effects[-1], fit, 0.0)

    null = Step(leaving(1010.0), None, {}, [ranked(leaving(610.0, "dead_time")), ranked(leaving(710.0, "pile_up"))])
    beside = {name: leaving(gap, name, "quantisation") for name, gap in (("dead_time", 200.0), ("pile_up", 40.0))}

    def search(fit, leaves, others):
        return [ranked(beside[fit.model.effects[-1].name])], fit

    steps, known = _pair([null], search, lambda new, old: False)
    assert steps[-1].ranks[0].fit is beside["pile_up"]
    assert known.model.effects == (effects["pile_up"],)
    assert steps[0].ties == []
    assert _pair([null], search, lambda new, old: True) is None  # it grew on the events kept aside
    beside["pile_up"] = leaving(150.0, "pile_up", "quantisation")
    assert _pair([null], search, lambda new, old: False) is None
    beside |= {name: leaving(gap, name, "quantisation") for name, gap in (("dead_time", 42.0), ("pile_up", 40.0))}
    steps, _ = _pair([null], search, lambda new, old: False)
    assert [tie.effect.name for tie in steps[0].ties] == ["dead_time"]
    closed = Step(leaving(1010.0), None, {}, [ranked(leaving(8.0, "dead_time"))])  # beside it nothing is left to close
    assert _pair([closed], search, lambda new, old: False) is None
    # What the first was tied with may be a better first, if with it much less is left than the first left.
    first = Step(leaving(610.0, "dead_time"), None, {}, [])
    steps, _ = _pair([null, first], search, lambda new, old: False)
    assert [effect.name for effect in steps[-1].added.fit.model.effects] == ["pile_up", "quantisation"]
    assert steps[0].added.effect.name == "pile_up"
    first = Step(leaving(100.0, "dead_time"), None, {}, [])
    assert _pair([null, first], search, lambda new, old: False) is None


def test_of_a_family_fits_of_other_shapes_are_repeated_first():
    """The right shape may be seen worse than two fits of a wrong one, as long as events are few."""
    scale = next(e for e in catalogue(Weinberg()) if e.name == "scale")
    shapes = {s.shape: s for s in scale.shapes()}

    def fitted(shape, gap):
        model = Model(Weinberg(), (shapes[shape],))
        return SimpleNamespace(model=model, gap=gap, unit=np.full(model.dim, gap / 100))

    fits = [fitted("cubic", 10.0), fitted("cubic", 10.1), fitted("cubic", 20.0), fitted("linear", 40.0)]
    assert [fit.gap for fit in _distinct(fits)] == [10.0, 20.0, 40.0]
    assert [fit.gap for fit in _distinct(fits, 2)] == [10.0, 40.0]


@pytest.mark.parametrize(
    ("gap", "p_value", "rejected", "shown"),
    [(105.0, 0.3, True, False), (150.0, 0.001, True, True), (150.0, 0.3, False, False), (150.0, 0.03, False, True)],
)
def test_what_only_the_classifier_sees_beside_an_effect_has_no_name(gap, p_value, rejected, shown):
    gates = {"summary": SimpleNamespace(p_value=p_value), "classifier": SimpleNamespace(p_value=0.0001)}
    assert _shown(Step(SimpleNamespace(gap=gap, dof=100), None, gates), rejected, 0.05) == shown


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_second_effect_stays_only_where_the_first_alone_does_not_do(share):
    effects, rng = {e.name: e for e in catalogue(Poisson())}, np.random.default_rng(1)
    model, params = Model(Poisson(), (effects["zero_inflation"], effects["flat_background"])), [1.5, 0.1, share, 30.0]
    x = model.simulate(np.tile(params, (10_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)
    fit = refine(model, target, model.to_unit(np.array(params)), 0.02, rng, num_events=30_000)
    null = Step(fit, fit, {}, [Ranked(model.effects[0], fit, 0.0)])
    effort = effort_for(Poisson(), "counts", None)
    search = Search(target, x, target.mean, 1000, [], 0.05, 3, rng, effort, 1)
    steps = search._without_second([null, null, Step(fit, fit, {}, [])])
    kept = ["zero_inflation", "flat_background"] if share else ["zero_inflation"]
    assert [effect.name for effect in steps[-1].fit.model.effects] == kept
    if not share:
        assert steps[-1].p_value > 0.05
        assert [step.added.effect.name for step in steps[:-1]] == kept


def test_no_further_effect_is_looked_for_after_so_many_simulated_events():
    x, rng = hidden(Poisson(), "zero_inflation", [1.5], [0.2], 2000), np.random.default_rng(1)
    effort = replace(effort_for(Poisson(), "counts", 100_000), enough=0)
    model = Model(Poisson(), events=Counted(Poisson()))
    null, target = fit_null(model, x, rng, effort, None)
    before = Step.of(null, target, x, rng, effort)
    assert before.p_value < 1e-6
    search = Search(target, x, target.mean, 1000, catalogue(Poisson()), 0.05, 3, rng, effort, 1)
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
        return refine(model, target, model.to_unit(np.array(start)), 0.02, rng, num_events=30_000)

    null, alone, other = (
        fitted(*chosen, start=start) for chosen, start in (((), [1.5]), ((wrong,), [1.5, 0.02]), ((zeros,), [1.5, 0.1]))
    )
    pair = fitted(wrong, spread, start=[1.5, 0.02, 0.2])
    ranks = [Ranked(wrong, alone, 0.0), Ranked(zeros, other, TIE / 2)]
    steps = [Step(null, null, {}, ranks), Step(alone, alone, {}, [Ranked(spread, pair, 0.0)]), Step(pair, pair, {})]
    effort = effort_for(Poisson(), "counts", None)
    search = Search(target, x, target.mean, 1000, [], 0.05, 3, rng, effort, 1)
    first, second, last = search._first_again(steps)
    assert [effect.name for effect in last.fit.model.effects] == ["zero_inflation", "overdispersion"]
    assert [first.added.effect.name, second.added.effect.name] == ["zero_inflation", "overdispersion"]
    assert first.ties == []
    assert last.p_value > 0.05
    np.testing.assert_allclose(last.fit.params[1:], truth[1:], atol=0.04)
    # The right one stays, and what cannot take its place is no longer tied with it.
    right = [replace(steps[0], ranks=[Ranked(zeros, other, 0.0), Ranked(wrong, alone, TIE / 2)]), second, last]
    first, *_ = search._first_again(right)
    assert first.added.effect.name == "zero_inflation"
    assert first.ties == []


def test_what_acts_on_one_feature_is_tried_on_all():
    effects = {e.key: e for e in catalogue(Carl())}

    def fit(name, feature, shape, phi):
        chosen = next(e for e in effects[name, feature].shapes() if e.shape == shape)
        return SimpleNamespace(model=Model(Carl(), (chosen,)), params=np.array([0.5, -1.0, *phi]))

    def starts(*arguments):
        return _on_all([fit(*arguments)], list(effects.values()))

    (start,) = starts("saturation", 2, "below", (0.04, 0.25))
    assert [(*effect.key, effect.shape) for effect in start.model.effects] == [("saturation", "all", "below")]
    np.testing.assert_allclose(start.model.from_unit(start.unit), [0.5, -1.0, 0.04, 0.25])
    assert starts("saturation", "all", "below", (0.04, 0.25)) == []
    assert starts("dead_region", 2, "box", (0.5, 1.0, 0.5)) == []  # places are in units of each range where all


def test_a_feature_that_is_cleared_counts_where_nothing_closes_the_whole_gap():
    effects = {e.key: e for e in catalogue(Carl())}

    def fit(gap, *keys):
        model = Model(Carl(), tuple(effects[key] for key in keys))
        return SimpleNamespace(model=model, gap=gap, gap_error=0.0, dof=100)

    keys = [("saturation", 4), ("resolution", 0), ("offset", 0), ("scale", 1)]
    ranks = [
        Ranked(effects[key], fit(700.0, key), score) for key, score in zip(keys, (0.0, 5.0, 9.0, 9.0), strict=True)
    ]
    null = Step(fit(1000.0), None, {}, ranks)

    def accepted(cleared, grew=()):
        step = _accepted(
            [null],
            lambda new, old: new.model.effects[-1].key in grew,
            lambda new, old: new.model.effects[-1].key in cleared,
            True,
        )
        return step and (step.added.effect.key, [tie.effect.key for tie in step.ties])

    assert accepted([]) is None
    assert accepted(keys[1:]) == (keys[1], [keys[2]])  # a tie of another feature is none
    assert accepted(keys[1:], grew=[keys[1]]) == (keys[2], [keys[1]])
