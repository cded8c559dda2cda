"""Several data sets, events beside tables, fitted and diagnosed with one theta."""

import numpy as np
import pytest
from scipy import stats

import avobench
from avobench.tasks.errors import UsageError

SECONDS = {"slow": 1.0, "middle": 3.0, "fast": 10.0}


def rates(seconds, calls=None):
    def counts(theta, rng):
        if calls is not None:
            calls.append(len(theta))
        return rng.poisson(seconds * theta[:, 0])

    return avobench.task(counts, name="counts", prior={"rate": (0.5, 5)}, features=["count"])


def measured(seed, *, lost=0.0, tables=()):
    """Counts at three exposures, of different numbers; of the last a share is lost."""
    rng, found = np.random.default_rng(seed), {}
    for (name, seconds), n in zip(SECONDS.items(), (3000, 1500, 2500), strict=True):
        x = rng.poisson(2.0 * seconds * (1 - lost * (name == "fast")), n)
        found[name] = avobench.Table(np.arange(x.max() + 2) - 0.5, np.bincount(x)) if name in tables else x
    return found


def joint(x, calls=None):
    return avobench.joint({name: (rates(SECONDS[name], calls), x[name]) for name in x})


@pytest.fixture(scope="module")
def found():
    return avobench.diagnose(
        joint(measured(0, lost=0.1)), effects=["inefficiency", "zero_inflation"], max_effects=1, progress=False
    )


def test_a_loss_that_one_sample_takes_as_theta_is_named_by_its_set(found):
    """Theta of the fast set alone is lower by a tenth, and nothing is missing there."""
    (effect,) = found.diagnosis.effects
    assert (effect.name, effect.feature) == ("inefficiency", "fast: count")
    assert effect.probability > 0.5
    lost, rate = effect.parameters["lost"], found.diagnosis.theta_after["rate"]
    assert abs(lost.value - 0.1) < 3 * lost.std < 0.1
    assert abs(rate.value - 2) < 3 * rate.std < 0.2
    alone = avobench.diagnose(rates(10.0), measured(0, lost=0.1)["fast"], max_effects=0, progress=False)
    assert alone.diagnosis.p_value_before > 0.01
    assert alone.diagnosis.theta_before["rate"].value == pytest.approx(1.8, abs=0.05)


def test_the_answer_tells_each_set_and_is_kept(found, tmp_path):
    rows = found.diagnosis.tables
    assert [(row.name, row.kind) for row in rows] == [(name, "events") for name in SECONDS]
    assert all(row.chi_squared_after < 3 * row.dof for row in rows)
    assert "3 data sets" in str(found)
    assert [each.feature for each in found.result.pictures.spectra] == [f"{name}: count" for name in SECONDS]
    with pytest.warns(UserWarning, match=r"no model\.json"):
        found.save(tmp_path)
    assert avobench.load(tmp_path).details() == found.details()


def test_a_set_whose_features_depend_closely_on_each_other_has_its_distance():
    """Most cells of their pair are empty, measured and simulated."""

    def twice(theta, rng):
        z = theta[:, 0] + rng.standard_normal(len(theta))
        return np.stack([z, z + 0.02 * rng.standard_normal(len(theta))], axis=1)

    task, rng = avobench.task(twice, prior={"mean": (-2, 2)}, features=["here", "there"]), np.random.default_rng(3)
    sets = avobench.joint({name: (task, twice(np.full((n, 1), 0.4), rng)) for name, n in (("a", 3000), ("b", 4000))})
    rows = avobench.diagnose(sets, effects=[], max_effects=0, progress=False).diagnosis.tables
    assert all(row.dof > 20 for row in rows)
    assert all(stats.chi2.sf(row.chi_squared_before, row.dof) > 1e-4 for row in rows)


@pytest.mark.parametrize("tables", [(), ("slow", "fast")])
def test_theta_is_that_of_all_sets_and_each_simulated_event_is_counted(tables):
    errors, events = [], 3000 * 1 + 1500 * 3 + 2500 * 10
    for seed in range(3):
        calls = []
        fit = avobench.infer(joint(measured(seed, tables=tables), calls), budget=300_000)
        assert abs(fit.theta["rate"] - 2) < 3.5 * fit.std["rate"]
        assert fit.num_simulations <= 300_000
        assert 0 <= sum(calls) - fit.num_simulations < 500  # beside those with which a task is checked when it is made
        assert not fit.estimate.doubt
        assert fit.num_events == fit.to_dict()["num_events"] == 3000 + 1500 + 2500
        errors.append(fit.std["rate"])
    assert np.median(errors) == pytest.approx(np.sqrt(2 / events), rel=0.25)  # Poisson, and a little of simulation


def test_right_simulators_are_rejected_as_rarely_as_alpha_says():
    """Events, and events beside tables."""
    p = []
    for seed in range(8):
        x = measured(seed, tables=("middle",) if seed % 2 else ())
        p.append(avobench.diagnose(joint(x), effects=[], max_effects=0, progress=False).diagnosis.p_value_before)
    assert stats.kstest(np.minimum(p, 1), "uniform").pvalue > 0.005


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda j: avobench.joint({"near": rates(1.0)}), "a task and what was measured by the name"),
        (lambda j: avobench.joint({"near": (rates(1.0), [1])}), "two data sets at least"),
        (lambda j: avobench.joint({"a": (avobench.bank(np.ones(400)), [1]), "b": (rates(1.0), [1])}), "simulators"),
        (lambda j: avobench.joint({"a": (rates(1.0), []), "b": (rates(1.0), [1])}), "^a: there are no events"),
        (lambda j: avobench.diagnose(joint(measured(0) | {"fast": [20] * 50})), "^fast: 50 events are too few"),
        (lambda j: avobench.infer(j, method="avo"), "fitted by smm"),
        (lambda j: avobench.infer(j, [1, 2]), "leave x out"),
        (lambda j: avobench.diagnose(j, [1, 2]), "which has it"),
        (lambda j: avobench.diagnose(j, ordered=True), "no single sample"),
        (lambda j: avobench.diagnose(rates(1.0)), "give what was measured"),
        (lambda j: avobench.infer(j, budget=6000), "too few"),
    ],
)
def test_what_cannot_be_joined_is_told_in_one_line(call, word):
    with pytest.raises(UsageError, match=word) as raised:
        call(joint(measured(0)))
    assert "\n" not in str(raised.value)


def shifts(**prior):
    return avobench.task(
        lambda theta, rng: rng.normal(theta.sum(axis=1)), name="shifts", prior={"mu": (-2, 2), **prior}, features=["x"]
    )


@pytest.mark.parametrize("how", ["bank", "joint"])
def test_a_prior_that_is_not_uniform_counts_where_the_events_leave_it_open(how, tmp_path):
    """Events know the sum of two parameters, so the prior of one is all that is known of it, and the other's error."""
    task, x = shifts(b=stats.norm(0.2, 0.1)), np.random.default_rng(0).normal(1, 1, 1000)
    if how == "bank":
        fit = avobench.infer(task, x, bank=tmp_path, budget=200_000, progress=False)
    else:
        halves = avobench.joint({"a": (task, x[:500]), "b": (task, x[500:])})
        fit = avobench.infer(halves, budget=400_000, progress=False)
    assert fit.theta["b"] == pytest.approx(0.2, abs=0.03)
    assert fit.std["b"] == pytest.approx(0.1, rel=0.1)
    assert fit.theta["mu"] == pytest.approx(x.mean() - 0.2, abs=0.1)
    assert 0.07 < fit.std["mu"] < 0.16


@pytest.mark.parametrize("other", [stats.norm(0.2, 0.2), (-1, 1), (0.1, 0.3)])
def test_data_sets_share_a_law_and_no_two_of_them(other):
    law, x = stats.norm(0.2, 0.1), np.random.default_rng(0).normal(1, 1, 300)
    sets = {"a": (shifts(b=law), x), "b": (shifts(b=other), x)}
    if other == (-1, 1):  # it holds all of the law
        assert avobench.joint(sets).task.prior.std == pytest.approx([4 / np.sqrt(12), 0.1], rel=0.01)
    else:
        with pytest.raises(UsageError, match="priors of b differ"):
            avobench.joint(sets)
