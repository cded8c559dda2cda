import numpy as np
import pytest
from measurements import Own, with_effect

from avobench.api.diagnosis import require_events
from avobench.bench.plugins import registry
from avobench.diagnosis import diagnose
from avobench.diagnosis.effort import Effort
from avobench.diagnosis.report.model_file import describe
from avobench.diagnosis.report.uncertainties import QuotedFit
from avobench.diagnosis.schema import Verdict
from avobench.effects.catalogue import catalogue
from avobench.effects.model_file import AugmentedTask
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task as task_of
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

RUTHERFORD_GEIGER = (57, 203, 383, 525, 532, 408, 273, 139, 45, 27, 10, 4, 0, 1, 1)
"""Intervals with 0, 1, ... alpha particles: E. Rutherford, H. Geiger, Phil. Mag. 20 (1910) 698."""


def counts(table):
    return np.repeat(np.arange(len(table)), table)[:, None]


def test_nothing_is_missing_in_counts_that_are_poisson():
    x = counts(RUTHERFORD_GEIGER)
    diagnosis = diagnose(Poisson(), x, alpha=0.01).diagnosis
    assert diagnosis.verdict == Verdict.NOTHING
    assert diagnosis.effects == diagnosis.candidates == diagnosis.regions == []
    rate = diagnosis.theta_before["log_rate"]
    assert rate.value == pytest.approx(np.log(x.mean()), abs=4 * rate.std)  # fitted without a quarter of the events
    rows = [row.name for row in diagnosis.identifiability]
    assert sorted(rows) == sorted({e.name for e in catalogue(Poisson())})  # one of each family


def test_angles_within_a_fiducial_cut_of_unequal_ends():
    """Nothing is left beyond the ends, so that theta alone is far off, and a scale beside an offset is as sharp."""
    task, rng = Weinberg(), np.random.default_rng(0)
    x = task.simulate(np.tile([45.0, 1.0], (20_000, 1)), rng)
    seen = x[(x[:, 0] > -0.7) & (x[:, 0] < 0.9)][:10_000]
    chosen = of(task, "edge_acceptance", "offset", "scale", "dead_region")
    diagnosis = diagnose(task, seen, effects=chosen, num_simulations=6_000_000).diagnosis
    (found,) = diagnosis.effects
    assert found.name == "edge_acceptance"
    ends = {name: parameter.value for name, parameter in found.parameters.items()}
    if found.shape == "analysis_window":  # another class of the same family, with other parameters
        ends = {side: ends["centre"] + sign * ends["width"] / 2 for side, sign in (("low", -1), ("high", 1))}
    assert ends["low"] == pytest.approx(-0.7, abs=0.02)
    assert ends["high"] == pytest.approx(0.9, abs=0.02)
    assert diagnosis.verdict == Verdict.NAMED


def test_counts_of_which_the_zeros_are_not_recorded():
    x = np.random.default_rng(0).poisson(2.0, 6000)
    chosen = of(Poisson(), "threshold_loss", "zero_inflation", "inefficiency")
    verdicts = []
    for seed in range(3):  # held-out events reject a right model in one of 40
        diagnosis = diagnose(Poisson(), x[x > 0][:4000, None], effects=chosen, seed=seed).diagnosis
        (found,) = diagnosis.effects
        assert found.name == "threshold_loss"
        log_rate = diagnosis.theta_after["log_rate"]
        assert log_rate.value == pytest.approx(np.log(2), abs=3 * log_rate.std)
        verdicts.append(diagnosis.verdict)
    assert verdicts.count(Verdict.NAMED) >= 2


def of(task, *names):
    """The effects of these names."""
    return [effect for effect in catalogue(task) if effect.name in names]


SCATTERED = with_effect(Poisson(), "overdispersion", [2.5], [0.08], 8000)
SOME = of(Poisson(), "overdispersion", "zero_inflation", "dead_time", "flat_background")
"""Of which only one describes counts whose rate scatters."""


@pytest.fixture(scope="module")
def named():
    return diagnose(Poisson(), SCATTERED, effects=SOME)


def test_a_seed_finds_the_same_again_with_any_number_of_processes_and_counts_the_same(named):
    again = diagnose(Poisson(), SCATTERED, effects=SOME, jobs=2).diagnosis
    assert again.model_dump(exclude={"seconds"}) == named.diagnosis.model_dump(exclude={"seconds"})


def test_a_shift_of_an_exponential_is_tied_with_a_lower_cut_of_it():
    """An exponential has no memory: above any value it is the whole of it, moved there. No data tell them apart."""
    decay = task_of(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"tau": (1, 4)}, name="decay")
    x = 0.5 + np.random.default_rng(0).exponential(2, (4000, 1))
    (first,) = diagnose(decay, x, effects=of(decay, "offset", "edge_acceptance"), max_effects=1).diagnosis.effects
    assert {first.name, *(rival.name for rival in first.tied_with)} == {"offset", "edge_acceptance"}


def test_a_few_events_that_the_simulator_cannot_make_are_a_disagreement():
    x = Weinberg().simulate(np.tile([45.0, 1.0], (2000, 1)), np.random.default_rng(0))
    x[:30, 0] = np.random.default_rng(1).uniform(-3, -1.5, 30)
    diagnosis = diagnose(Weinberg(), x, max_effects=0).diagnosis
    assert diagnosis.gates["summary"].p_value < 1e-6
    assert diagnosis.verdict == Verdict.UNEXPLAINED


def test_an_effect_on_one_of_several_counts_an_event_is_named_with_it():
    rng = np.random.default_rng(0)
    two = task_of(lambda theta, rng: rng.poisson(np.exp(theta[:, [0, 0]])), prior={"log_rate": (0, 3)}, name="two")
    x = two.simulate(np.full((3000, 1), 1.5), rng)
    x[rng.random(3000) < 0.15, 1] = 0
    found = diagnose(two, x, effects=of(two, "zero_inflation", "dead_time"), max_effects=1).diagnosis
    assert [(effect.name, effect.feature) for effect in found.effects] == [("zero_inflation", "x2")]


def test_a_clear_effect_is_named_and_its_size_found(named):
    diagnosis, pictures = named.diagnosis, named.pictures
    assert diagnosis.verdict == Verdict.NAMED
    (found,) = diagnosis.effects
    assert (found.name, found.feature) == ("overdispersion", None)
    variance = found.parameters["variance"]
    assert variance.value == pytest.approx(0.08, abs=max(4 * variance.std, 0.015))
    assert diagnosis.gap_after.value < 2 < diagnosis.gap_before.value
    assert diagnosis.p_value_after > 0.05 > diagnosis.p_value_before
    assert diagnosis.candidates[0].score == 0
    assert {region.kind for region in diagnosis.regions} == {"excess", "deficit"}
    assert len(pictures.spectra[0].edges) == len(pictures.spectra[0].measured) + 1


def test_the_new_model_is_a_task_that_finds_nothing_missing(named, tmp_path):
    path = tmp_path / "model.json"
    path.write_text(describe(named.fit, QuotedFit(named.fit).std, "poisson", {}).model_dump_json())
    task = registry.build("task", str(path), {})
    assert isinstance(task, AugmentedTask)
    assert task.name == "poisson-overdispersion"
    assert task.parameter_names[:2] == ("log_rate", "overdispersion_variance")
    shape = named.fit.params[2:]  # whatever shape of it fits best: all have this variance
    theta = np.tile([2.5, 0.08, *shape], (20_000, 1))
    y = task.simulate(theta, np.random.default_rng(1))
    assert y.var() == pytest.approx(np.exp(2.5) + 0.08 * np.exp(5.0), rel=0.05)
    with pytest.raises(ValueError, match="outside the support"):
        task.simulate(np.array([[2.5, -1.0, *shape]]), np.random.default_rng(1))
    assert diagnose(task, SCATTERED, effects=[]).diagnosis.verdict == Verdict.NOTHING


def test_counts_that_are_all_alike_are_those_of_a_counter_that_is_blind_for_most_of_the_time(monkeypatch):
    """A dead time of nearly so large a part of the window, at a high rate: all measured events are in one bin."""
    monkeypatch.setattr("avobench.diagnosis.run.effort_for", lambda *_: Effort().scaled(0.1))
    # All at one limit describes such counts as well, and so does a low rate above a threshold.
    chosen = [e for e in catalogue(Poisson()) if e.name not in ("censoring", "truncation", "threshold_loss")]
    found = diagnose(Poisson(), np.full((1000, 1), 2), effects=chosen).diagnosis
    assert found.probabilities[0].name == "dead_time"
    assert found.p_value_before < 1e-6


def test_an_effect_that_is_not_in_the_catalogue_is_not_made_up():
    wrong = of(Poisson(), "dead_time", "inefficiency")
    result = diagnose(Poisson(), SCATTERED, effects=wrong, num_simulations=4_000_000)
    assert result.diagnosis.verdict == Verdict.UNEXPLAINED
    assert result.correction.weights.mean() == pytest.approx(1)


@pytest.mark.parametrize(("arguments", "message"), [({"alpha": 2.0}, "alpha must lie"), ({"fit": "magic"}, "magic")])
def test_impossible_requests_are_refused(arguments, message):
    with pytest.raises(UsageError, match=message):
        diagnose(Poisson(), counts(RUTHERFORD_GEIGER), **arguments)


def test_an_effect_of_the_users_is_tried_before_anything_is_fitted():
    require_events(Own(lambda x: x), Weinberg(), Weinberg().simulate)
    for task, makes, said in (
        (Weinberg(), lambda x: 1 / 0, "effect own cannot be used, it raised ZeroDivisionError"),
        (Weinberg(), lambda x: x[:, 0], r"effect own makes events of shape \(50,\), not \(50, 1\)"),
        (Weinberg(), lambda x: x * np.nan, "must make finite events of float64, and makes float64: "),
        (Poisson(), lambda x: x / 2, "must make finite events of int64, and makes float64: "),
    ):
        with pytest.raises(UsageError, match=said):
            require_events(Own(makes), task, task.simulate)


def theta_of(simulate, prior, x, seed):
    """The first parameter of a plain fit without effects."""
    found = diagnose(task_of(simulate, prior=prior, features=["x"]), x, seed=seed, max_effects=0).diagnosis
    return next(iter(found.theta_before.values())), found.p_value_before


def test_few_events_tell_a_parameter_by_its_error():
    """By few simulated events its slope hid in their noise, and its error was its whole range for one in ten."""
    for seed in range(8):
        x = np.random.default_rng(seed).exponential(1.2, (200, 1))
        mean, _ = theta_of(lambda theta, rng: rng.exponential(theta), {"mean": (0.5, 3)}, x, seed + 100)
        assert mean.std < 4 * 1.2 / np.sqrt(200)
        assert abs(mean.value - 1.2) < 4 * mean.std


def test_the_error_of_a_lifetime_is_that_of_its_mean_near_an_end_of_the_prior():
    """Over a tenth of the range the slopes were mostly noise, and the error the whole range for one in three."""
    exact, errors, pulls = 2.8 / np.sqrt(0.75 * 2000), [], []
    for seed in range(3000, 3016):
        x = np.random.default_rng(seed).exponential(2.8, (2000, 1))
        value, _ = theta_of(lambda theta, rng: rng.exponential(theta), {"mean": (1, 3)}, x, seed)
        errors.append(value.std / exact)
        pulls.append((value.value - 2.8) / value.std)
    assert np.sum(np.array(errors) > 3) <= 2
    assert np.sqrt(np.mean(np.square(pulls))) < 1.45  # of sixteen right ones above in one of 500


def test_the_error_of_a_sharp_end_is_by_the_scatter_where_theta_is():
    """Where the first fit was too low, the outermost bin was expected nearly empty, and its scatter next to nothing."""
    pulls = []
    for seed in range(8):
        x = np.random.default_rng(seed).uniform(0, 2.37, (5000, 1))
        value, _ = theta_of(lambda theta, rng: rng.uniform(0, 1, (len(theta), 1)) * theta, {"end": (1, 5)}, x, seed)
        pulls.append((value.value - 2.37) / value.std)
    assert np.sqrt(np.mean(np.square(pulls))) < 1.6  # of eight right ones above in one of 100


def test_a_peak_of_unknown_place_is_mostly_found_before_anything_is_said_to_be_missing():
    """A search of few points went past it, and right simulators were rejected with p below 1e-10, one of four."""

    def simulate(theta, rng):
        within = rng.random(len(theta)) < theta[:, 1]
        return np.where(within, rng.normal(theta[:, 0], 0.03), rng.uniform(0, 1, len(theta)))[:, None]

    missed = 0
    for seed in range(16):
        x = simulate(np.tile([0.437, 0.15], (2000, 1)), np.random.default_rng(seed))
        _, p = theta_of(simulate, {"place": (0.1, 0.9), "share": (0, 1)}, x, seed)
        missed += p < 1e-10
    assert missed <= 2


def test_a_model_with_a_narrow_peak_describes_its_own_events():
    """Its prior knows where the peak is; a search over all of its support missed it and rejected the model."""

    def peak(theta, rng):
        tau, share, centre, width = theta.T
        return np.where(rng.random(len(theta)) < share, rng.normal(centre, width), rng.exponential(tau))

    support = {"tau": (1, 4), "share": (0, 0.9), "centre": (0, 11), "width": (0.05, 2)}
    prior = {"tau": (1, 4), "share": (0.05, 0.13), "centre": (4.9, 5.2), "width": (0.05, 0.25)}
    fitted = task_of(peak, prior=prior, support=support, name="fitted")
    x = fitted.simulate(np.tile([2.2, 0.09, 5.05, 0.15], (3000, 1)), np.random.default_rng(0))
    found = diagnose(fitted, x, effects=[]).diagnosis
    assert found.verdict == Verdict.NOTHING
