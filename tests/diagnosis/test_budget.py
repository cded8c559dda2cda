"""A diagnosis never simulates more than it may, and says what it left out."""

import json
from dataclasses import replace

import numpy as np
import pytest
from measurements import entry

import avobench
from avobench.bench.events.checks import SHARE
from avobench.diagnosis import Diagnosis, diagnose
from avobench.diagnosis.checks import Checks
from avobench.diagnosis.effort import effort_for, first_fit_events
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.settings import BUDGET, TEST
from avobench.effects.catalogue import catalogue, domain
from avobench.reports.diagnosis.text import meaning
from avobench.tasks.carl import Carl
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson
from paper.cases.case import Case
from paper.studies.cases import CASES
from paper.studies.detection import events


class Counting(Poisson):
    """Poisson that counts what it is asked for itself."""

    made = 0

    def simulate(self, theta, rng):
        object.__setattr__(self, "made", self.made + len(theta))
        return super().simulate(theta, rng)


@pytest.fixture(scope="module")
def often_off():
    rng = np.random.default_rng(0)
    x = rng.poisson(7, (1000, 1))
    x[rng.random(1000) < 0.1] = 0
    return x


@pytest.mark.parametrize("allowed", [20_000, 60_000, 300_000])
def test_the_limit_holds_whatever_is_found(often_off, allowed):
    task = Counting()
    effects = [e for e in catalogue(task) if e.name in ("zero_inflation", "overdispersion", "dead_time")]
    diagnosis = diagnose(task, often_off, effects=effects, num_simulations=allowed).diagnosis
    assert diagnosis.num_simulations == task.made <= allowed
    assert diagnosis.verdict != Verdict.NOTHING
    assert not any("did not suffice for the tests of the effects" in note for note in diagnosis.notes)
    assert short(diagnosis) or diagnosis.effects[0].name == "zero_inflation"


def short(diagnosis):
    """Whether it is said that more simulated events would tell more."""
    return any("did not suffice for" in note for note in diagnosis.notes)


def test_too_few_simulated_events_are_refused_with_a_number_that_suffices(often_off):
    """A right simulator needs the first fit and the tests alone, and a wrong one perhaps a second search for theta."""

    def asked(task, x, allowed):
        """The p-value, or the number that a refusal names."""
        try:
            return diagnose(task, x, num_simulations=allowed, max_effects=0).diagnosis.p_value_before
        except UsageError as error:
            return int(str(error).split()[-1])

    right, task = np.random.default_rng(0).poisson(7, (1000, 1)), Counting()
    least = asked(task, right, 1000)
    assert 0.05 < asked(task, right, least) <= 1
    assert task.made <= least
    numbers = [1000, asked(task, often_off, 1000)]
    if (more := asked(task, often_off, numbers[-1])) > 1:
        numbers.append(more)
    assert numbers == sorted(numbers)
    assert asked(task, often_off, numbers[-1]) < 0.05


@pytest.mark.parametrize(("num_events", "allowed"), [(200, 2e4), (2000, 4e4), (50_000, 1e6), (2_000_000, 4e7)])
@pytest.mark.parametrize("task", [Poisson(), Carl()], ids=lambda task: task.name)
def test_twenty_simulated_events_a_measured_one_are_never_too_few(task, num_events, allowed):
    """The effort that they pay for leaves room for the search, whatever the checks took."""
    fitted, checks = num_events - int(TEST.held_out_share * num_events), int(allowed) // SHARE
    effort = effort_for(task, domain(task), int(allowed), fitted, checks)
    assert first_fit_events(effort, task, fitted) <= allowed - checks


def test_a_second_question_from_a_kept_bank_simulates_nothing(tmp_path, often_off):
    answers = []
    for _ in range(2):
        checks = Checks(task := Counting(), len(often_off), folder=tmp_path)
        x, _ = checks.events(often_off)
        answers.append(diagnose(task, x, effects=checks.entries()[:2], bank=checks.bank).diagnosis)
        assert task.made == answers[-1].num_simulations
    first, again = answers
    assert first.num_simulations > again.num_simulations == 0
    same = {"seconds", "num_simulations"}
    assert first.model_dump(exclude=same) == again.model_dump(exclude=same)


def test_a_search_that_fitted_nothing_claims_nothing(often_off):
    """That nothing in the catalogue is missing has no probability where the catalogue was not tried."""
    diagnosis = diagnose(Poisson(), often_off, num_simulations=17_000).diagnosis
    assert short(diagnosis)
    assert (diagnosis.outside, diagnosis.probabilities, diagnosis.effects) == (None, [], [])
    assert "no effect was fitted" in meaning(diagnosis)


def test_what_was_fitted_until_the_events_ended_is_weighed_and_tested(often_off):
    diagnosis = diagnose(Poisson(), often_off, num_simulations=22_000).diagnosis
    assert short(diagnosis)
    assert [one.name for one in diagnosis.effects] == ["zero_inflation"]
    assert diagnosis.outside < 0.5


def test_several_workers_keep_the_limit_too(often_off):
    effects = [e for e in catalogue(Poisson()) if e.name in ("zero_inflation", "overdispersion")]
    found = diagnose(Poisson(), often_off, effects=effects, num_simulations=400_000, jobs=2)
    assert found.diagnosis.num_simulations <= 400_000


def test_progress_goes_through_the_phases_and_never_back(often_off):
    told, effects = [], [entry(Poisson(), "zero_inflation")]
    how = {"num_simulations": 1_000_000, "progress": lambda *each: told.append(each)}
    result = diagnose(Poisson(), often_off, effects=effects, **how)
    phases, done, total = zip(*told, strict=True)
    seen = list(dict.fromkeys(phases))
    assert seen[:4] == ["first fit", "gates", "search", "search for effect 1"]
    assert seen[-1] == "checks"
    assert list(done) == sorted(done)
    assert all(d <= t for d, t in zip(done, total, strict=True))
    assert done[-1] == result.diagnosis.num_simulations


def test_order_changes_nothing_else():
    """Without the option the field is null, and with it all else is the same."""
    x = np.random.default_rng(0).poisson(7, (600, 1))
    x = np.r_[x, np.random.default_rng(1).poisson(8, (600, 1))]
    how = {"effects": [], "num_simulations": 250_000}
    plain, ordered = (diagnose(Poisson(), x, ordered=option, **how).diagnosis for option in (False, True))
    assert plain.order is None
    assert [(one.kind, one.feature, one.of) for one in ordered.order] == [("change point", None, "level")]
    assert ordered.order[0].at == pytest.approx(600, abs=100)
    same = {"order", "seconds"}
    assert plain.model_dump(exclude=same) == ordered.model_dump(exclude=same)
    text = json.dumps(ordered.model_dump(mode="json"), allow_nan=False)
    assert Diagnosis.model_validate_json(text) == ordered


def test_of_millions_of_events_a_random_sample_is_compared(monkeypatch):
    monkeypatch.setattr("avobench.diagnosis.run.BUDGET", replace(BUDGET, most_events=1000))
    x = np.r_[np.random.default_rng(0).poisson(7, (1500, 1)), np.random.default_rng(1).poisson(9, (1500, 1))]
    diagnosis = diagnose(Poisson(), x, effects=[], num_simulations=250_000, ordered=True).diagnosis
    assert diagnosis.num_events == 1000
    assert any("A random 1000 of the 3000 events were compared" in note for note in diagnosis.notes)
    assert diagnosis.order[0].at == pytest.approx(1500, abs=150)  # an index of all events


def test_where_events_end_while_effects_are_screened_the_others_are_weighed():
    """Spread and mixture have all events simulated anew: where that is too much, the rest of the search goes on."""
    prior = dict.fromkeys(["shape", "scale"], (0.5, 5))
    task = avobench.task(lambda theta, rng: rng.gamma(*theta.T), prior=prior, features=["time"], name="gamma")
    rng = np.random.default_rng(4)
    x = rng.gamma(2, 2, 5000)
    x = np.where(rng.random(5000) < 0.06, rng.normal(6, 0.15, 5000), x)
    said = avobench.diagnose(task, x, simulations=300_000, progress=False).diagnosis
    assert said.num_simulations <= 300_000
    assert "peak_background" in [effect.name for model in said.models for effect in model.effects]


def opened(name: str) -> Case:
    """An opened case in which the simulator is right."""
    return next(case for case in CASES["opened"]["simulated"] if case.name == name)


@pytest.mark.parametrize(("name", "seed", "share"), [("marathon_as_told", 0, 20), ("star_plain", 5, None)])
def test_a_right_simulator_is_not_rejected_by_a_limit_or_the_covariance_of_another_theta(name, seed, share):
    """The bins of the first hold few of the events of which a model's covariance is, if these are few; of the second
    two parameters are hardly told apart, and some bins are nearly empty."""
    case = opened(name)
    limit = share and share * len(case.x())
    assert (
        diagnose(case.task, case.x(), num_simulations=limit, seed=seed, max_effects=0).diagnosis.p_value_before > 1e-3
    )


@pytest.mark.parametrize("seed", [18, 20])
def test_a_right_simulator_is_not_rejected_where_features_depend_closely_on_each_other(seed):
    """Along some combinations of its bins hardly an event differs. Theta is found within its quoted error."""
    case = opened("star_plain")
    x = events(case, seed)
    said = diagnose(case.task, x, seed=seed, max_effects=0).diagnosis
    assert said.p_value_before > 1e-3
    colour = (x[:, 0] - x[:, 4]) / 1.85
    for name, truth in (("colour", colour.mean()), ("width", np.sqrt(colour.var() - 2 * (0.03 / 1.85) ** 2))):
        assert abs(said.theta_before[name].value - truth) < 4 * said.theta_before[name].std


def test_nor_is_it_where_such_events_are_one_of_several_data_sets():
    """The other set is so small that on average there are too few events for bins of pairs."""
    task, rng = opened("star_plain").task, np.random.default_rng([4, 5])
    low, high = np.array(task.prior.low), np.array(task.prior.high)
    theta = low + (high - low) * rng.uniform(0.25, 0.75, len(low))
    sets = {name: (task, task.simulate(np.tile(theta, (n, 1)), rng)) for name, n in (("large", 2700), ("small", 400))}
    said = avobench.diagnose(avobench.joint(sets), seed=4, effects=[], max_effects=0, progress=False).diagnosis
    assert said.p_value_before > 0.01  # 0.004 by the covariance of 5157 events
