"""What a user asks for becomes cells in a useful order, and what cannot be met is said in one line."""

import pytest

from avobench.bench.plugins import registry
from avobench.bench.sweep.plan import parse_targets, plan
from avobench.tasks.errors import UsageError

COMMON = {
    "tasks": ["toys:Normal", "weinberg"],
    "methods": ["toys:Moment", "avo-paper"],
    "targets": "0-2",
    "repetitions": 2,
    "budget": 4800,
    "observations": 100,
    "seed": 0,
    "settings": [],
}


def cells(**changes):
    return plan(**{**COMMON, **changes})


def test_an_interrupted_sweep_is_a_complete_comparison_over_fewer_targets():
    planned = cells()
    assert len(planned) == 2 * 3 * 2 * 2
    first = [(cell.identity["task"], cell.identity["method"]) for cell in planned[:4]]
    assert first == [("normal", "moment"), ("weinberg", "moment"), ("normal", "avo-paper"), ("weinberg", "avo-paper")]
    order = [(cell.repetition, cell.target) for cell in planned]
    assert order == sorted(order)


def test_targets_do_not_move_with_the_seed():
    assert [cell.identity["theta_true"] for cell in cells()] == [cell.identity["theta_true"] for cell in cells(seed=7)]


def test_everything_that_determines_a_result_changes_the_identity():
    changes = [{}, {"budget": 4801}, {"observations": 101}, {"seed": 1}, {"targets": "1"}, {"tasks": ["weinberg"]}]
    changes += [{"settings": ["moment.steps=5"]}, {"settings": ["normal.scale=2"]}, {"methods": ["avo-paper"]}]
    ids = [cells(**{"targets": "0", "repetitions": 1, **change})[0].id for change in changes]
    assert len(set(ids)) == len(ids)
    assert ids[0] == cells(settings=["moment.steps=4", "normal.scale=1"])[0].id  # a default said aloud is the default
    repeated = cells(targets="0")
    assert len({cell.id for cell in repeated}) == len(repeated)


@pytest.mark.parametrize(
    ("text", "expected"), [("0", [0]), ("0-14", list(range(15))), ("3,1,7-9,8", [3, 1, 7, 8, 9]), (" 2 , 4", [2, 4])]
)
def test_targets_are_indices_and_ranges(text, expected):
    assert parse_targets(text) == expected


@pytest.mark.parametrize("text", ["15", "3-1", "-1", "a", "", "1,,2", "0-", "1.5", "0-99"])
def test_impossible_targets_are_refused(text):
    with pytest.raises(UsageError, match="--targets"):
        parse_targets(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tasks": ["poison"]}, "no task named 'poison'; did you mean poisson?"),
        ({"tasks": ["zzz"]}, "known: alignment, alignment-3, carl, means-10,"),
        ({"methods": ["bolfy"]}, "did you mean bolfi?"),
        ({"tasks": ["nowhere:Task"]}, "there is no module 'nowhere'"),
        ({"tasks": ["toys:Norml"]}, "did you mean Normal?"),
        ({"tasks": ["toys:Moment"]}, "not a subclass"),
        ({"budget": 0}, "--budget must be at least 1"),
        ({"budget": -5}, "--budget must be at least 1"),
        ({"budget": 2**63}, "--budget must be below 2^63"),
        ({"observations": 0}, "--observations must be at least 1"),
        ({"repetitions": 0}, "--repetitions must be at least 1"),
        ({"seed": -1}, "--seed must lie between"),
        ({"seed": 2**63}, "--seed must lie between"),
        ({"tasks": ["toys:Careless"]}, "the simulator of careless ignores its generator"),
        (
            {"tasks": ["toys:Unready"]},
            "needs no_such_package, which is not installed: in a clone of avobench, pip install '.[unready]'",
        ),
        ({"tasks": ["toys:Fragile"]}, "task 'toys:Fragile' cannot be used, it raised RuntimeError: out of order"),
        ({"settings": ["avo-paper.learning_rate=nan"]}, "settings must be finite numbers"),
        ({"methods": ["abc-smc"], "budget": 10**6, "settings": ["abc-smc.population_size=2"]}, "population_size > 2"),
        ({"budget": 47}, "--budget 47 is too small for avo-paper on normal: at least 48"),
        ({"tasks": ["warped-20"], "methods": ["bolfi"], "budget": 10**6}, "too small for bolfi on warped-20: at least"),
        ({"tasks": ["warped-20"], "methods": ["bsl"], "budget": 10**6}, "bsl.sets = 16 is too few for the covariance"),
        ({"settings": ["moment.step=3"]}, "no setting 'step'; did you mean steps?"),
        ({"settings": ["moment.steps=many"]}, "setting steps of method moment"),
        ({"settings": ["bolfi.update_interval=3"]}, "'bolfi' is not part of this run"),
        ({"settings": ["steps=3"]}, "METHOD.PARAM=VALUE"),
        ({"settings": ["moment.steps"]}, "METHOD.PARAM=VALUE"),
        ({"settings": ["avo-paper.batch_size=31"]}, "batch_size must be even"),
        ({"settings": ["avo-paper.schedule=both"]}, "setting schedule of method avo-paper: Input should be"),
    ],
)
def test_what_cannot_be_met_is_said_before_anything_is_simulated(change, message):
    with pytest.raises(UsageError) as error:
        cells(**change)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("method", "package", "extra"),
    [("nre", "sbi", "sbi"), ("tsnpe", "sbi", "sbi"), ("bolfi", "elfi", "bolfi"), ("bsl", "elfi", "bolfi")],
)
def test_a_method_whose_package_is_absent_is_refused_in_one_line(method, package, extra, monkeypatch):
    found = registry.find_spec
    monkeypatch.setattr(registry, "find_spec", lambda name: None if name == package else found(name))
    said = rf"method {method} needs {package}, which is not installed.*'\.\[{extra}\]'"
    with pytest.raises(UsageError, match=said):
        cells(methods=[method])
