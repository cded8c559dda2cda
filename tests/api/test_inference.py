"""One inference on a user's own events."""

import json
import os
import time
from dataclasses import dataclass, replace

import numpy as np
import pytest

import avobench
from avobench.bench.plugins import registry
from avobench.methods import Estimate, Method
from avobench.tasks.errors import ProcessEnded, UsageError

RNG = np.random.default_rng(5)
EVENTS = RNG.poisson(7.0, 4000)
FEW = {"population_size": 50}


@pytest.fixture(scope="module")
def found():
    return avobench.infer("poisson", EVENTS, "abc-smc", budget=48_000, settings=FEW)


def test_the_answer_is_near_what_made_the_events(found):
    assert abs(found.theta["log_rate"] - np.log(7)) < 5 * found.std["log_rate"] < 2
    assert found.num_simulations <= 48_000
    assert found.std_of == "posterior"


def test_it_shows_itself(found):
    assert str(found).startswith("log_rate = ")
    assert "<table" in found._repr_html_()
    doubtful = replace(found, estimate=replace(found.estimate, doubt="<b>far off</b>"))
    assert "&lt;b&gt;far off" in doubtful._repr_html_()
    assert "doubtful: <b>far off" in str(doubtful)
    assert doubtful.to_dict()["doubt"] == doubtful.doubt == "<b>far off</b>"
    assert found.to_frame()["value"].to_dict() == found.theta
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["theta"] == found.theta
    assert len(found.plot().axes) == 1


def normals(theta, rng):
    """Two means, of which the second number tells the sum."""
    return rng.normal(np.stack([theta[:, 0], theta.sum(axis=1)], axis=1), 1)


@pytest.fixture(scope="module")
def fitted():
    task = avobench.task(normals, prior={"a": (-2, 2), "b": (-2, 2)}, units={"a": "m"})
    x = normals(np.tile([0.5, -0.3], (4000, 1)), np.random.default_rng(1))
    return avobench.infer(task, x, "smm", budget=100_000)


def test_draws_have_the_covariance_that_theory_says(fitted):
    """Of (a, a + b) it is the identity over n, so of (a, b) it is [[1, -1], [-1, 2]] / n; the budget adds 4 %."""
    expected = np.array([[1, -1], [-1, 2]]) / 4000
    assert fitted.samples_of == "sampling distribution of the estimate"
    assert np.allclose(fitted.covariance, expected, atol=0.3 * expected.max())
    assert np.allclose(np.sqrt(np.diag(fitted.covariance)), list(fitted.std.values()))
    draws = fitted.samples(20_000)
    assert np.allclose(draws.cov(), fitted.covariance, atol=0.1 * expected.max())
    assert np.allclose(draws.mean(), list(fitted.theta.values()), atol=0.001)


def test_draws_of_a_posterior_are_points_that_the_method_has(found):
    assert found.samples_of == "posterior"
    draws = found.samples(2000, seed=1)
    assert set(draws["log_rate"]) <= set(found.estimate.sample.theta[:, 0])
    assert draws["log_rate"].std() == pytest.approx(found.std["log_rate"], rel=0.1)


def test_draws_stay_within_the_support_and_need_the_correlations(fitted):
    at_the_end = replace(fitted.estimate, theta=np.array([2.0, 2.0]), covariance=np.eye(2))
    assert fitted.task.support.contains(replace(fitted, estimate=at_the_end).samples(500)).all()
    unknown = replace(fitted, estimate=replace(fitted.estimate, covariance=None))
    with pytest.raises(avobench.UsageError, match="does not tell how"):
        unknown.samples()


@pytest.mark.parametrize("which", ["found", "fitted"])
def test_a_fit_that_was_saved_is_read_again(which, request, tmp_path):
    fit = request.getfixturevalue(which)
    again = avobench.load(fit.save(tmp_path / "fit.json"))
    assert str(again) == str(fit)
    assert again.to_dict() == fit.to_dict()
    assert again.samples(50).equals(fit.samples(50))
    assert again.to_frame().equals(fit.to_frame())
    assert len(again.plot("pairs").axes) >= len(fit.theta)
    with pytest.raises(avobench.UsageError, match="no simulator"):
        again.task.simulate(np.zeros((1, 2)), RNG)


def test_arviz_is_given_the_draws(fitted):
    arviz = pytest.importorskip("arviz", reason="ArviZ is not installed")
    data = fitted.to_inference_data(400)
    draws = fitted.samples(400)
    assert data.attrs["samples_of"] == fitted.samples_of
    summary = arviz.summary(data, kind="stats", round_to="none")
    assert summary["mean"].to_dict() == pytest.approx(draws.mean().to_dict())
    assert summary["sd"].to_dict() == pytest.approx(draws.std().to_dict())


def counted():
    """A whole number which 100 events tell to be 4.5 +- 0.15, so that it is quoted with the rounding."""
    task = avobench.task(
        lambda theta, rng: rng.normal(theta[:, 0], 1.5), prior={"k": (0, 12)}, kinds={"k": "integer"}, name="counted"
    )
    x = np.random.default_rng(0).normal(size=100)
    return avobench.infer(task, 4.5 + 1.5 * (x - x.mean()) / x.std(), "smm", budget=4000, progress=False)


def working():
    """A simulator that fails above 1, of events around 1.2."""

    def simulate(theta, rng):
        return np.where(theta[:, 0] > 1, np.nan, rng.normal(theta[:, 0], 1))

    task = avobench.task(simulate, prior={"m": (-2, 2)}, failed="region")
    x, settings = np.random.default_rng(0).normal(1.2, 1, 300), {"iterations": 20}
    return avobench.infer(task, x, "avo", budget=4000, settings=settings, progress=False)


@pytest.mark.parametrize("made", [counted, working])
def test_a_saved_answer_that_was_made_whole_or_moved_is_read_as_it_was_quoted(made, tmp_path):
    fit = made()
    again = avobench.load(path := fit.save(tmp_path / "fit.json"))
    for one in (fit, again):
        assert one.covariance.to_numpy()[0, 0] == pytest.approx(next(iter(fit.std.values())) ** 2)
    assert (again.theta, again.std, str(again)) == (fit.theta, fit.std, str(fit))
    assert again.samples(100).equals(fit.samples(100))
    content = json.loads(path.read_text())
    content["described"].pop("parameter_kinds")  # as older files
    path.write_text(json.dumps(content))
    assert avobench.load(path).theta == fit.theta


def test_draws_of_an_integer_are_whole_and_no_prior_of_a_real_number(tmp_path):
    fit = counted()
    for one in (fit, avobench.load(fit.save(tmp_path / "fit.json"))):
        draws = one.samples(4000)["k"]
        assert (draws == np.rint(draws)).all()
        assert draws.std() == pytest.approx(fit.std["k"], rel=0.2)
        with pytest.raises(UsageError, match="integer"):
            one.as_prior()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"kind": "avobench-fit"}', '{"kind": 3}', None])
def test_what_is_no_saved_result_is_said_in_a_line(content, tmp_path):
    path = tmp_path / "x.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(avobench.UsageError, match=str(path)):
        avobench.load(path)


def test_the_figure_names_both_bands(fitted):
    shown = {text.get_text() for text in fitted.plot().axes[0].get_legend().get_texts()}
    assert shown == {"spread while it ran", "estimate ± standard error"}
    with pytest.raises(avobench.UsageError, match="has trace, pairs"):
        fitted.plot("corner")


def test_progress_counts_to_what_was_simulated():
    told = []
    fit = avobench.infer("poisson", EVENTS, "smm", budget=4000, progress=lambda *said: told.append(said))
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert told[-1] == ("smm", fit.num_simulations, 4000)


@pytest.mark.parametrize(
    ("task", "x", "options", "said"),
    [
        ("poison", [1, 2], {}, "did you mean poisson"),
        ("poisson", [[1, 2]], {}, "has 1 columns, the data have 2"),
        ("poisson", [1.5, 2.0], {}, "whole numbers"),
        ("poisson", ["a", "b"], {}, "real numbers"),
        (lambda theta, rng: theta, [1, 2], {}, "must be a task, such as avobench.task makes of a function"),
        ("poisson", [1, 2], {"method": "avoo"}, "did you mean avo"),
        ("poisson", [1, 2], {"budget": 1}, "at least"),
        ("poisson", [1, 2], {"seed": -1}, "seed must be a whole number from 0"),
        ("poisson", [[1], [2, 3]], {}, "rows of the events differ in length"),
        ("poisson", [1, 2], {"method": "abc-smc", "settings": {"population": 3}}, "did you mean population_size"),
    ],
)
def test_what_cannot_be_inferred_is_said_in_a_line(task, x, options, said):
    with pytest.raises(avobench.UsageError, match=said):
        avobench.infer(task, x, **options)


def test_the_command_prints_and_keeps_the_same(avobench, tmp_path, found):
    np.save(tmp_path / "x.npy", EVENTS)
    code, out, err = avobench(
        *("infer", "--task", "poisson", "--data", tmp_path / "x.npy", "--method", "abc-smc", "--budget", 48_000),
        *("--set", "abc-smc.population_size=50", "--out", tmp_path / "found.json"),
    )
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == str(found).splitlines()[0]
    assert json.loads((tmp_path / "found.json").read_text())["theta"] == found.theta


def test_without_pytorch_the_default_is_a_method_that_is_installed(monkeypatch):
    present = registry.find_spec
    monkeypatch.setattr(registry, "find_spec", lambda name: None if name == "torch" else present(name))
    found = avobench.infer("poisson", EVENTS, budget=4000)
    assert found.method == "rank-moments"
    assert not avobench.list_methods().loc["avo", "available"]


def test_a_limit_of_time_ends_a_simulator_of_a_script_and_changes_no_answer():
    def simulate(theta, rng):
        time.sleep(600 * (len(theta) > limit))
        return rng.normal(theta)

    limit, x = 10**6, RNG.normal(0.3, 1, 500)
    task = avobench.task(simulate, prior={"mean": (-1, 1)}, name="own")
    limited = avobench.infer(task, x, "smm", budget=1000, seconds=300)
    assert limited.theta == pytest.approx(avobench.infer(task, x, "smm", budget=1000).theta, rel=1e-9)
    limit = 20
    for ask in (avobench.infer, avobench.diagnose):
        with pytest.raises(ProcessEnded, match=r"ended after 0\.5 s, the limit of time"):
            ask(task, x, seconds=0.5)
        with pytest.raises(UsageError, match="seconds must be a number above 0"):
            ask(task, x, seconds=-1)


def test_other_processes_make_the_events_and_their_number_changes_no_answer(tmp_path):
    def simulate(theta, rng):
        with (tmp_path / "calls").open("a") as file:
            file.write(f"{os.getpid()} {len(theta)}\n")
        if len(theta) > 200:
            raise RuntimeError("no memory")
        return rng.normal(theta[:, 0])

    task, x = avobench.task(simulate, prior={"mean": (-1, 1)}, name="own"), RNG.normal(0.3, 1, 500)
    found = []
    for jobs in (1, 2):
        (tmp_path / "calls").unlink()
        found.append(avobench.infer(task, x, "smm", budget=1000, jobs=jobs))
        calls = np.loadtxt(tmp_path / "calls", int)
        assert calls[:, 1].sum() == found[-1].num_simulations
        assert (os.getpid() in calls[:, 0]) == (jobs == 1)
    assert found[0].theta == found[1].theta
    with pytest.raises(avobench.SimulatorError, match="own raised RuntimeError: no memory"):
        avobench.infer(task, x, "smm", budget=100_000, jobs=2)


def test_events_that_were_simulated_before_are_enough_for_smm_and_their_noise_counts():
    rng = np.random.default_rng(0)
    rates = np.repeat(np.linspace(5.0, 9.0, 5), 4000)
    bank = avobench.bank(rng.poisson(rates), theta={"rate": rates})
    found = avobench.infer(bank, EVENTS)
    assert abs(found.theta["rate"] - EVENTS.mean()) < 3 * found.std["rate"]
    assert np.sqrt(7 / 4000) < found.std["rate"] < 3 * np.sqrt(7 / 4000)
    assert found.num_simulations == 20_000
    with pytest.raises(UsageError, match="of a bank take smm, abc"):
        avobench.infer(bank, EVENTS, "abc-smc")
    line = avobench.infer(bank, EVENTS, Line(), progress=False)
    assert abs(line.theta["rate"] - EVENTS.mean()) < 4 * line.std["rate"] < 0.3
    assert line.num_simulations == 20_000
    assert not any("were used" in note for note in line.warnings)


@dataclass(frozen=True)
class Line(Method):
    """A straight line through all events, at thetas of the prior."""

    name = "line"
    source = "a test"
    from_prior = True

    def min_simulations(self, num_parameters):
        return 100

    def infer(self, problem, rng):
        theta = problem.prior.sample(problem.simulate.remaining, rng)
        slope, start = np.polyfit(theta[:, 0], problem.simulate(theta)[:, 0], 1)
        found = (problem.x_observed.mean(keepdims=True)[0] - start) / slope
        return Estimate(found, "a line", "proposal", found, np.array([0.05]))


def test_other_data_find_what_a_method_drew_from_the_prior(tmp_path):
    rng = np.random.default_rng(1)
    task = avobench.task(lambda theta, rng: rng.poisson(theta[:, 0]), name="p", prior={"rate": (4, 10)})
    cost = []
    for rate in (6.0, 8.0):
        found = avobench.infer(task, rng.poisson(rate, 2000), Line(), budget=20_000, bank=tmp_path, progress=False)
        assert abs(found.theta["rate"] - rate) < 0.25
        cost.append(found.num_simulations)
    assert cost[0] > 19_000
    assert cost[1] <= 20_000 // 10  # fresh events at the new estimate are compared with those that were observed


def test_what_was_simulated_for_a_fit_is_used_again(tmp_path):
    first, again = (avobench.infer("poisson", EVENTS, "smm", bank=tmp_path) for _ in range(2))
    assert abs(first.theta["log_rate"] - np.log(7)) < 4 * first.std["log_rate"] < 0.05
    assert abs(again.theta["log_rate"] - first.theta["log_rate"]) < first.std["log_rate"]
    assert again.num_simulations < first.num_simulations / 5


def test_a_small_budget_is_used_to_know_theta_and_its_error(tmp_path):
    task, away = avobench.task(lambda theta, rng: rng.exponential(theta[:, 0]), prior={"life": (1, 4)}, name="own"), []
    for seed in range(6):
        x = np.random.default_rng(seed).exponential(2.0, 2000)
        fit = avobench.infer(task, x, bank=tmp_path / str(seed), budget=40_000, progress=False)
        assert fit.num_simulations <= 40_000
        assert fit.std["life"] < 0.1
        away.append((fit.theta["life"] - 2) / fit.std["life"])
    assert np.sqrt(np.mean(np.square(away))) < 2
    with pytest.raises(avobench.UsageError, match="too few"):
        avobench.infer(task, x, bank=tmp_path / "other", budget=20_000, progress=False)
