"""Hiding effects, finding them without the answers, and scoring."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import kstest, poisson

from avobench.bench.processes.workers import Workers
from avobench.challenge import hide as hiding
from avobench.challenge import solve as solving
from avobench.challenge.case import Case
from avobench.challenge.make import KINDS, make
from avobench.challenge.records import RECORDS, read_records, records
from avobench.challenge.score import rate, score
from avobench.challenge.solve import read_manifest, solve
from avobench.challenge.table import as_text, targets
from avobench.challenge.visibility import visibility
from avobench.diagnosis.schema import Verdict
from avobench.effects.catalogue import catalogue
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg
from diagnoses import diagnosis
from shapes.primitives import Library

FOREIGN = Library("counts")
"""Two shapes that the catalogue does not have."""


@FOREIGN.thin("inefficiency", strength=(0.02, 0.5), variation=(0.1, 0.3))
def uneven_loss(x, at, by, rng):
    """Each pulse is lost with a probability that varies from event to event."""
    return 1 - by.strength * (1 + by.variation * rng.uniform(-1, 1, x.shape))


@FOREIGN.flip("zero_inflation", strength=(0.05, 0.2))
def blank(x, at, by, rng):
    """Some events are blank."""
    return 0 * x


HERE = Workers(in_process=True)
"""In this process, where a diagnosis can be replaced by one that takes no time."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A small challenge of each kind, made once."""
    path = tmp_path_factory.mktemp("challenge") / "poisson"
    make("poisson", 10, 3, path, num_events=1000, shapes=FOREIGN.shapes)
    return path


@pytest.fixture
def fresh(folder, tmp_path):
    """The same without any result and without answers, and where the answers are."""
    copy = tmp_path / "copy"
    copy.mkdir()
    (copy / "data").symlink_to(folder / "data")
    (copy / "manifest.json").write_bytes((folder / "manifest.json").read_bytes())
    return copy, folder / "answers.json"


def named(name, **more):
    return {"name": name, "feature": None, **more}


def said(verdict="no significant disagreement", effects=(), theta=1.0):
    """A diagnosis of a poisson data set; effects are (name, tied names)."""
    gap = {"value": 2.0, "low": 1.0, "high": 3.0}
    value = {"log_rate": {"value": theta, "std": 0.1}}
    combination = {"coefficients": {"log_rate": 0.25}, "value": theta / 4, "std": 0.025}
    after = {"gap_after": {**gap, "value": 1.1}, "theta_after": value, "identified_after": [combination]}
    found = [named(name) | {"parameters": {}, "tied_with": [named(rival) for rival in ties]} for name, ties in effects]
    before = {"p_value_before": 0.5, "gap_before": gap, "theta_before": value, "identified_before": [combination]}
    return diagnosis(verdict, **before, **(after if effects else {}), effects=found)


def test_data_are_repeated_for_a_seed_and_differ_for_another(folder, tmp_path):
    for seed, same in ((3, True), (4, False)):
        make("poisson", 10, seed, tmp_path / str(seed), num_events=1000, shapes=FOREIGN.shapes)
        one, other = ((path / "answers.json").read_bytes() for path in (folder, tmp_path / str(seed)))
        assert (one == other) == same
        x, y = (np.load(path / "data" / "0000.npz")["x"] for path in (folder, tmp_path / str(seed)))
        assert np.array_equal(x, y) == same
        assert (x.shape, x.dtype) == ((1000, 1), np.int64)


def test_kinds_come_in_equal_shares_and_answers_stand_apart(folder):
    answers = json.loads((folder / "answers.json").read_text())["cases"]
    assert sorted(answer["kind"] for answer in answers) == sorted(KINDS * 2)
    number = {"none": 0, "own": 1, "foreign": 1, "two": 2, "withheld": 1}
    for answer in answers:
        assert len({effect["name"] for effect in answer["effects"]}) == number[answer["kind"]]
        assert Poisson.prior.contains(answer["theta"]).all()
    public = read_manifest(folder)
    assert all(set(case) == {"case", "effects"} for case in public["cases"])
    allowed = {case["case"]: case["effects"] for case in public["cases"]}
    for answer in answers:
        if answer["kind"] == "withheld":
            assert answer["effects"][0]["name"] not in allowed[answer["case"]]
            assert len(allowed[answer["case"]]) == len({effect.name for effect in catalogue(Poisson())}) - 1
        else:
            assert allowed[answer["case"]] is None


def test_what_cannot_be_made_is_refused_and_leaves_nothing(tmp_path):
    for arguments, kinds, message in [
        (("nothing", 1, 0), ("own",), "there is no task named"),
        (("poisson", 0, 0), ("own",), "--cases"),
        (("poisson", 1, -1), ("own",), "--seed"),
        (("poisson", 1, 0), ("three",), "--kinds must be among"),
        (("poisson", 1, 0), ("foreign",), "--kinds foreign needs --shapes"),
    ]:
        with pytest.raises(UsageError, match=message):
            make(*arguments, tmp_path / "new", kinds=kinds)
    assert not (tmp_path / "new").exists()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    with pytest.raises(UsageError, match="not an empty folder"):
        make("poisson", 1, 0, tmp_path / "full")
    with pytest.raises(UsageError, match="holds no challenge"):
        solve(tmp_path / "full", workers=HERE)


@pytest.mark.parametrize("task", [Poisson(), Weinberg()], ids=lambda task: task.name)
def test_strengths_of_the_catalogue_s_own_shapes_are_log_uniform(task):
    rng = np.random.default_rng(0)
    for effect in hiding.catalogue(task):
        shares = []
        for _ in range(200):
            drawn = hiding.OwnShape.draw([effect], rng)
            strength = drawn.effect.parameters[0]
            bound = strength.high if drawn.phi[0] > strength.null else strength.low
            shares.append((drawn.phi[0] - strength.null) / (bound - strength.null))
            assert all(p.low <= value <= p.high for p, value in zip(drawn.effect.parameters, drawn.phi, strict=True))
        low, high = np.log(hiding.OWN_RANGE)
        assert kstest((np.log(shares) - low) / (high - low), "uniform").pvalue > 1e-4


def test_solving_never_opens_the_answers_and_goes_on_from_where_it_stopped(fresh, monkeypatch):
    folder, answers = fresh
    assert not (folder / "answers.json").exists()
    seen = []

    def diagnose(task, x, *, seed, effects, bank):
        seen.append((seed, x.shape, {effect.name for effect in effects}))
        if len(seen) == 4:
            raise KeyboardInterrupt
        return SimpleNamespace(diagnosis=said())

    monkeypatch.setattr(solving, "diagnose", diagnose)
    with pytest.raises(KeyboardInterrupt):
        solve(folder, workers=HERE)
    assert len(list((folder / "results").iterdir())) == 3
    solve(folder, workers=HERE)
    assert [number for number, _, _ in seen] == [0, 1, 2, 3, *range(3, 10)]
    assert {shape for _, shape, _ in seen} == {(1000, 1)}
    names = {effect.name for effect in hiding.catalogue(Poisson())}
    assert sorted(len(names - allowed) for _, _, allowed in seen) == [0] * 9 + [1, 1]  # a family, with all its classes
    before = {path: path.stat().st_mtime_ns for path in (folder / "results").iterdir()}
    solve(folder, workers=HERE)
    assert before == {path: path.stat().st_mtime_ns for path in (folder / "results").iterdir()}
    with pytest.raises(UsageError, match="there are no answers"):
        records(folder)
    (folder / "answers.json").symlink_to(answers)
    assert score(records(folder))["solved"] == 10


def answers_at_once(task, x, *, seed, effects, bank, alpha=0.05):
    return SimpleNamespace(diagnosis=said())


def test_a_case_that_fails_is_a_row_and_is_tried_again(fresh, monkeypatch):
    folder, answers = fresh

    def fails(task, x, *, seed, effects, bank):
        if seed == 2:
            raise RuntimeError("lost the thread")
        return SimpleNamespace(diagnosis=said())

    monkeypatch.setattr(solving, "diagnose", fails)
    solve(folder, workers=HERE)
    (folder / "answers.json").symlink_to(answers)
    result = score(records(folder))
    assert result["failed"] == {"poisson 0002": "RuntimeError: lost the thread"}
    assert result["solved"] == 9
    monkeypatch.setattr(solving, "diagnose", answers_at_once)
    solve(folder, workers=HERE)
    assert score(records(folder))["failed"] == {}


def test_results_of_other_options_are_not_mixed(fresh, monkeypatch):
    folder, _ = fresh
    monkeypatch.setattr(solving, "diagnose", answers_at_once)
    solve(folder, workers=HERE)
    with pytest.raises(UsageError, match="was made with"):
        solve(folder, workers=HERE, options={"alpha": 0.01})


NAMED, FAMILY = Verdict.NAMED.value, Verdict.FAMILY.value
UNEXPLAINED = "disagreement not explained by the catalogue"


def row(case, kind, hidden=(), diagnosis=None, power=1.0, theta=1.0, source="own", beside=1.0):
    """A line of records."""
    seen = {"distance": 1.0, "power": power, "beside": beside}
    effects = [named(name, shape="", settings={}, **seen) for name in hidden]
    answer = {"case": f"{case:04d}", "kind": kind, "set": source, "theta": [theta], "effects": effects, "error": None}
    return answer | {"seconds": 2.0, "cpu_seconds": 1.5, "diagnosis": (diagnosis or said()).model_dump(mode="json")}


@pytest.mark.parametrize(("g_f", "pull"), [(1.2, 0.0), (1.26, 2.0)])
def test_theta_of_weinberg_is_judged_by_what_the_data_determine(g_f, pull):
    """c = 2 tanh(v) G: theta far away on the curve of the same c is right, and an error of G alone is one of c."""
    task = Weinberg()
    width = np.subtract(task.support.high, task.support.low)
    estimate = np.array([46.0, 1.2])
    same = np.array([45.4, 0.0])
    same[1] = g_f * np.tanh(10 * (2 * 46.0 - 90) / 90) / np.tanh(10 * (2 * same[0] - 90) / 90)
    known = {"coefficients": {"e_beam": 0.0, "g_f": 1 / width[1]}, "value": 1.2 / width[1], "std": 0.03 / width[1]}
    theta = {name: {"value": v, "std": None} for name, v in zip(task.parameter_names, estimate, strict=True)}
    case = Case(task, {"theta": same.tolist()}, {"theta_before": theta, "identified_before": [known]})
    assert case.pull("before") == pytest.approx(pull, abs=1e-6)


def test_the_score_counts_what_it_says():
    head = {**RECORDS, "task": "poisson", "num_events": 1000, "seed": 0, "cases": 20, "options": {}}
    lines = [
        row(0, "none"),
        row(1, "none", diagnosis=said(NAMED, [("pile_up", ())])),
        row(2, "own", ["pile_up"], power=0.06),  # absorbed by theta: undetectable
        row(3, "own", ["dead_time"], power=0.95),  # missed
        row(4, "own", ["dead_time"], said(NAMED, [("dead_time", ["pile_up"])], theta=1.1)),
        row(5, "own", ["dead_time"], said(FAMILY, [("pile_up", ["dead_time"])])),
        row(6, "own", ["dead_time"], said(NAMED, [("inefficiency", [])], theta=1.3)),
        row(7, "foreign", ["dead_time"], said(UNEXPLAINED), source="foreign"),
        row(8, "withheld", ["dead_time"], said(NAMED, [("pile_up", [])])),
        row(9, "withheld", ["dead_time"], said(UNEXPLAINED)),
        row(10, "withheld", ["pile_up"], power=0.1),
        row(11, "two", ["dead_time", "pile_up"], said(NAMED, [("pile_up", []), ("dead_time", [])])),
        row(12, "two", ["dead_time", "pile_up"], said(NAMED, [("pile_up", ["inefficiency"])]), beside=0.5),
        row(13, "two", ["dead_time", "pile_up"], said(NAMED, [("inefficiency", ["dead_time", "pile_up"])])),
    ]
    result = score([head, *lines])

    def counts(part):
        return part["count"], part["of"]

    assert counts(result["none"]["false_alarms"]) == (1, 2)
    own = result["one"]["own"]
    assert (own["cases"], own["undetectable"]) == (5, 1)
    assert [counts(part) for part in own["power"]] == [(0, 1), (0, 0), (0, 0), (0, 1), (3, 3)]
    assert [counts(part) for part in own["right_first_by_gap"]] == [(0, 0), (1, 3), (0, 0), (0, 0)]
    parts = {"right_first": (1, 3), "in_tie_set": (2, 3), "visible_right_first": (1, 4), "visible_in_tie_set": (2, 4)}
    parts |= {"another_would_do": (3, 3), "explained": (2, 3), "theta_within_2": (1, 2), "more_named": (0, 3)}
    assert {name: counts(own[name]) for name in parts} == parts
    assert own["tie_size"] == pytest.approx(5 / 3)
    assert (own["gap_before"], own["gap_after"]) == (2.0, 1.1)
    assert own["bias_after"] == pytest.approx(0.1 / 4)
    assert len(own["mistaken"]) == 2
    foreign = result["one"]["foreign"]
    assert counts(foreign["right_first"]) == (0, 1)
    assert counts(foreign["in_tie_set"]) == (0, 1)
    assert foreign["tie_size"] is None
    assert "taken for nothing" in foreign["mistaken"][0]
    withheld = result["withheld"]["own"]
    assert counts(withheld["falsely_explained"]) == (1, 2)
    assert [counts(part) for part in withheld["falsely_explained_by_gap"]] == [(0, 0), (1, 2), (0, 0), (0, 0)]
    two = result["two"]["own"]
    parts = {"both": (1, 3), "at_least_one": (2, 3), "both_with_ties": (2, 3), "visible_missed_explained": (1, 1)}
    parts |= dict.fromkeys(["visible_both", "visible_at_least_one"], (1, 2))
    assert {name: counts(two[name]) for name in parts} == parts
    missed = score([head, *lines, row(14, "two", ["dead_time", "pile_up"])])["two"]["own"]
    assert {counts(missed[name]) for name in ("visible_both", "visible_at_least_one", "both")} == {(1, 3)}
    assert counts(missed["visible_missed_explained"]) == (1, 2)
    both = score([head, *lines], [{**head, "seed": 1}, row(3, "own", ["dead_time"], power=0.95), row(0, "none")])
    assert counts(both["none"]["false_alarms"]) == (1, 3)
    assert (both["cases"], both["solved"], both["one"]["own"]["cases"]) == (40, 16, 6)
    assert both["two"]["all"] == both["two"]["own"]
    text = as_text(result)
    assert "all shapes" not in text  # there is one set of shapes alone for each kind that has all
    assert re.search(r"^false alarms +1/2 = 50% \(1% to 99%\)$", text, re.M)
    assert re.search(r"^right name first, chi2/ndf before to 3 +1/3 = 33% +0/1 = 0%$", text, re.M)
    assert "poisson 0006: dead_time taken for inefficiency" in text
    told = targets([head, *lines], [{**head, "seed": 1}, row(0, "none")]).splitlines()
    alarms, explained = (line for line in told if "false alarms" in line or "falsely explained" in line)
    assert "1/3 = 33%" in alarms
    assert alarms.endswith("  met")  # of three data sets, one may be by chance
    assert explained.endswith("not met")


def test_intervals_are_those_of_clopper_and_pearson():
    none = rate([False] * 20)
    assert (none["low"], none["high"]) == (0, pytest.approx(1 - 0.025 ** (1 / 20)))
    assert rate([True] * 20)["low"] == pytest.approx(0.025 ** (1 / 20))
    assert rate([])["share"] is None


def test_zeros_in_excess_are_as_visible_as_their_distribution_says():
    """Noncentrality of the chi-square test, at the best theta, from exact probabilities."""
    rate_, share, n = 6.0, 0.03, 5000
    counts = np.arange(40)
    hidden = (1 - share) * poisson.pmf(counts, rate_) + share * (counts == 0)

    def best(start):  # the covariance is that of the measured events and of those simulated at the start, together
        both = (hidden + poisson.pmf(counts, start)) / 2
        distance = lambda other: n * ((poisson.pmf(counts, other) - hidden) ** 2 / both).sum()  # noqa: E731
        return minimize_scalar(distance, (5, 6)).fun

    expected = min(best(rate_), best((1 - share) * rate_))  # from the truth, and from where the means agree
    rng, task, theta = np.random.default_rng(0), Poisson(), np.log([rate_])
    x = task.simulate(np.tile(theta, (400_000, 1)), rng)
    x[rng.permutation(400_000)[:12_000]] = 0
    seen = visibility(task, x, theta, n, rng)
    low, high = np.quantile(x, [0.005, 0.995])
    ndf = len(np.unique(np.clip(x, low - 1, high + 1))) - 2  # bins with events, less the total and theta
    assert seen.distance * ndf == pytest.approx(expected, rel=0.1)
    assert seen.power > 0.99


def test_what_theta_absorbs_is_invisible():
    rng, task = np.random.default_rng(0), Poisson()
    theta = np.array([1.5])
    x = task.simulate(np.tile(theta, (100_000, 1)), rng)
    for events in (x, x + rng.poisson(0.1, x.shape), x + rng.poisson(4, x.shape), rng.binomial(x, 0.9)):
        assert visibility(task, events, theta, 10_000, rng).power < 0.2
    blind = rng.binomial(task.simulate(np.tile(theta, (100_000, 1)), rng), 0.9)
    blind[rng.random(len(blind)) < 0.05] = 0

    def zeros(factor):
        return lambda theta, rng: task.simulate(theta, rng) * (rng.random((len(theta), 1)) >= factor * 0.05)

    assert visibility(task, blind, theta, 10_000, rng).power > 0.99
    assert visibility(task, blind, theta, 10_000, rng, zeros).power < 0.2  # beside the zeros a loss is absorbed as well
    rare = np.array([-3.0])
    few = task.simulate(np.tile(rare, (100_000, 1)), rng)  # zeros, ones and next to no more tell no more than theta
    assert visibility(task, few, rare, 10_000, rng, zeros).power == pytest.approx(0.05)
    constant = np.ones_like(x)
    assert visibility(task, constant, np.array([1.0]), 10_000, rng).power > 0.99
    blind[rng.random(len(blind)) < 0.02] = 0
    assert visibility(task, blind, theta, 10_000, rng, zeros).power < 0.2  # and more zeros by a larger share of them
    turned = -Weinberg().simulate(np.full((100_000, 2), [44.0, 1.0]), rng)  # charge taken wrongly: another c
    assert visibility(Weinberg(), turned, np.array([44.0, 1.0]), 10_000, rng).power < 0.2


def test_from_the_command_line(avobench, done, tmp_path):
    folder = tmp_path / "challenge"
    made = ("challenge", "make", "--task", "poisson", "--cases", 2, "--out", folder, "--events", 1000)
    done(*made, "--kinds", "none")
    solve_it = ("challenge", "solve", folder, "--simulations", 20_000, "--bank", tmp_path / "bank")
    assert avobench(*solve_it, "--jobs", 2)[0] == 2
    done(*solve_it)
    used = [json.loads(path.read_text())["diagnosis"]["num_simulations"] for path in folder.glob("results/*.json")]
    assert min(used) < max(used)  # the second case has events of the first
    out = done("challenge", "score", folder, "--format", "json", "--records", tmp_path / "records.jsonl")
    assert json.loads(out)["solved"] == 2
    out = done("challenge", "score", tmp_path / "records.jsonl")
    assert "poisson: 2 of 2 cases solved, 0 failed, 1000 events each" in out
    assert score(read_records(tmp_path / "records.jsonl")) == score(records(folder))
    (tmp_path / "records.jsonl").write_text("{}\n")
    with pytest.raises(UsageError, match="does not hold records"):
        read_records(tmp_path / "records.jsonl")
    for wrong in ((), ("--shapes", "math:pi"), ("--shapes", "nowhere:SHAPES"), ("--kinds", "foreign")):
        code, _, error = avobench(*made, *wrong)
        assert code == 2
        assert len(error.strip().splitlines()) == 1
