"""Values that may be missing are a state of their own: compared, told, and named where they are missing too often."""

import numpy as np
import pandas as pd
import pytest
from measurements import entry

import avobench
from avobench.api.diagnosis import require_events
from avobench.bench import conformance
from avobench.bench.events.checks import valid
from avobench.bench.processes.workers import Workers
from avobench.diagnosis.summary.bins import bins_of
from avobench.effects.rejection import accepted
from avobench.tasks.errors import SimulatorError, UsageError
from avobench.tasks.missing import Recorded, filled


def detector(theta, rng, lost=0.2):
    """The energy is missing more often where it is low."""
    energy = rng.exponential(theta[:, 0])
    angle = rng.normal(0.3 * energy, 1)
    energy[rng.random(len(energy)) < lost * np.exp(-energy / 4)] = np.nan
    return np.column_stack([energy, angle])


SAID = {"prior": {"mean": (1, 4)}, "features": ["energy", "angle"]}
TASK = avobench.task(detector, missing=["energy"], **SAID)
THETA = np.full((4000, 1), 2.0)


@pytest.fixture(scope="module")
def too_often():
    """Three samples and their diagnoses: held-out events may veto what is right by chance."""
    samples = [detector(THETA, np.random.default_rng(seed), 0.35) for seed in (1, 2, 3)]
    return [(x, avobench.diagnose(TASK, x, progress=False)) for x in samples]


def test_a_share_that_is_missing_too_often_is_seen_placed_and_named(too_often):
    for x, found in too_often:
        first = found.diagnosis.regions[0]
        assert (first.kind, first.feature, first.low) == ("excess", "energy", None)
        assert f"missing in {100 * np.isnan(x[:, 0]).mean():.3g} %" in found.details()
        assert "excess of events that lack energy" in found.details()
        assert [each.name for each in found.diagnosis.models[0].effects] == ["lost_value"]
    assert sum([each.name for each in found.diagnosis.effects] == ["lost_value"] for _, found in too_often) >= 2


def test_it_is_saved_with_its_figures_and_model(too_often, tmp_path):
    measured, found = next((x, found) for x, found in too_often if found.diagnosis.effects)
    found.save(tmp_path)
    model, (lost,) = avobench.load(tmp_path, trust=True).model, found.diagnosis.effects
    fitted = [found.diagnosis.theta_after["mean"].value, *(each.value for each in lost.parameters.values())]
    x = model.simulate(np.tile(fitted, (4000, 1)), np.random.default_rng(0))
    assert np.isnan(x[:, 0]).mean() == pytest.approx(np.isnan(measured[:, 0]).mean(), abs=0.04)
    assert np.isfinite(x[:, 1]).all()


def test_with_times_those_events_alone_are_dropped_that_the_task_cannot_have():
    """A value that may be missing stays, and so does a column that is no feature; other gaps go with their times."""
    x, rng = detector(THETA, np.random.default_rng(3)), np.random.default_rng(4)
    x[rng.random(4000) < 0.05, 1] = np.nan
    spare = {"quality": np.where(rng.random(4000) < 0.7, np.nan, 1), "flag": rng.random(4000) < 0.5}
    frame = pd.DataFrame({"energy": x[:, 0], "angle": x[:, 1], **spare})
    how = {"drop_invalid": True, "effects": [], "simulations": 100_000, "progress": False}
    found = avobench.diagnose(TASK, frame, time=np.arange(4000), **how).diagnosis
    kept = np.isfinite(x[:, 1])
    assert found.num_events == kept.sum()
    assert found.order is not None
    assert any(f"{(~kept).sum()} of 4000 rows" in note for note in found.notes)
    assert abs(found.theta_before["mean"].value - 2) < 5 * found.theta_before["mean"].std < 0.5
    np.testing.assert_array_equal(valid(TASK, frame), kept)


def test_what_is_missing_as_often_is_no_disagreement_and_tells_theta():
    x = detector(THETA, np.random.default_rng(2))
    assert avobench.diagnose(TASK, x, progress=False).verdict == "no significant disagreement"
    fit = avobench.infer(TASK, x, progress=False)
    assert abs(fit.theta["mean"] - 2) < 4 * fit.std["mean"] < 0.3


def test_other_methods_see_it_as_a_feature_of_its_own():
    x = detector(THETA, np.random.default_rng(2))
    known = Recorded(TASK, x)
    full, twin = known.events(x), known.task(TASK).with_reference(known.events(x))
    np.testing.assert_array_equal(known.bare(full), x)
    np.testing.assert_array_equal(full[:, 2], np.isnan(x[:, 0]))
    made = twin.simulate(THETA, np.random.default_rng(3))
    assert made.shape == (4000, twin.num_features)
    assert np.isfinite(made).all()
    assert twin.summary(made)[-1] == made[:, 2].mean()
    samples = x, detector(THETA, np.random.default_rng(2), 0.6)
    how = {"budget": 30_000, "settings": {"population_size": 20}, "progress": False}
    fit, other = (avobench.infer(TASK, each, "abc-smc", **how) for each in samples)
    assert abs(fit.theta["mean"] - 2) < 4 * fit.std["mean"]
    assert other.estimate.doubt


def test_it_keeps_the_contract_and_a_sweep_takes_it(tmp_path):
    assert not [each.what for each in conformance.run("task", f"{__file__}:TASK") if not each.passed]
    how = {"budget": 6000, "observations": 2000, "workers": Workers(in_process=True)}
    frame = avobench.run(f"{__file__}:TASK", "smm", "0-2", results=tmp_path, **how)
    assert (frame["status"] == "ok").all()
    assert (frame["squared_error"] < 0.1).all()


def test_an_effect_that_is_given_may_make_missing_values():
    require_events(entry(TASK, "lost_value"), TASK, TASK.simulate)


def test_two_samples_that_both_lack_a_value_need_no_word():
    rng, sizes = np.random.default_rng(3), ((40_000, 0.2), (4000, 0.4))
    a, b = (pd.DataFrame(detector(np.full((n, 1), 2.0), rng, lost), columns=["e", "a"]) for n, lost in sizes)
    found = avobench.diagnose(a, b, effects=["lost_value", "scale"], progress=False)
    assert set(zip(found.effects["effect"], found.effects["feature"], strict=True)) == {("lost_value", "e")}


def test_it_has_a_bin_of_its_own_and_the_others_are_as_without():
    rng = np.random.default_rng(4)
    x, simulated = (detector(np.full((n, 1), 2.0), rng) for n in (3000, 9000))
    bins = bins_of(x, simulated)
    own = len(bins.edges[0])
    assert bins.mean(x)[0, own] == np.isnan(x[:, 0]).mean()
    spans = bins.view(x).spans
    assert [span.of_missing for span in spans] == [False, True, False]
    assert np.isfinite(spans[0].ends).all()
    assert bins.mean(x)[0, : own + 1].sum() == pytest.approx(1)


def test_a_selection_does_not_change_how_often_values_are_missing():
    rng = np.random.default_rng(5)
    x = accepted(detector, np.full((20_000, 1), 2.0), lambda x, rows: 1.0 * (x[:, 0] > 2) + 0 * x[:, 0], rng)
    assert abs(np.isnan(x[:, 0]).mean() - 0.2 / 1.5) < 0.02
    assert np.nanmin(x[:, 0]) > 2


def test_what_is_filled_in_is_recorded_and_hardly_repeats():
    x = detector(THETA, np.random.default_rng(6))
    full = filled(x)
    assert np.isin(full, x[~np.isnan(x)]).all()
    assert np.unique(full[:, 0], return_counts=True)[1].max() == 2


def test_other_values_that_are_not_finite_are_faults():
    rng = np.random.default_rng(7)
    x = detector(THETA, rng)
    infinite, missing = np.where(np.arange(4000)[:, None] == 0, np.inf, x), {"missing": ["energy"]}
    for make, stated, measured, said in (
        (lambda theta, rng: detector(theta, rng)[:, ::-1], missing, 1 + rng.random((300, 2)), "NaN or infinity"),
        (lambda theta, rng: filled(detector(theta, rng)), {}, x, "which features may be `missing`"),
        (detector, missing, infinite, "1 of 4000 rows"),
        (lambda theta, rng: detector(theta, rng) * [np.nan, 1], missing, x, "never makes a value of energy"),
    ):
        with pytest.raises((SimulatorError, UsageError), match=said):
            avobench.diagnose(avobench.task(make, **stated, **SAID), measured)
    with pytest.raises(UsageError, match="missing names 'x'"):
        avobench.task(detector, missing=["x"], **SAID)
    with pytest.raises(UsageError, match="missing names 'x'"):
        avobench.bank(x, missing=["x"])
