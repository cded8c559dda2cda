"""A diagnosis of published tables in place of events."""

import numpy as np
import pytest

import avobench
from avobench.diagnosis.summary.published import tables_of
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

ZEROS = {"effects": ["zero_inflation"], "progress": False}


@pytest.fixture(scope="module")
def counts():
    """Poisson counts, of which one in twelve is zero instead."""
    rng = np.random.default_rng(0)
    x = rng.poisson(7.0, 3000) * (rng.random(3000) > 1 / 12)
    return avobench.Table(np.arange(x.max() + 2) - 0.5, np.bincount(x))


@pytest.fixture(scope="module")
def found(counts):
    return avobench.diagnose(Poisson(), counts, **ZEROS)


def test_an_effect_is_named_and_sized_from_a_histogram(found):
    assert found.verdict == "missing effect named"
    assert found.effects["effect"].unique().tolist() == ["zero_inflation"]
    fraction = found.effects.set_index("parameter").loc["fraction"]
    assert abs(fraction["value"] - 1 / 12) < 3 * fraction["std"]
    told, (table,) = found.diagnosis, found.diagnosis.tables
    assert told.num_events is None
    assert told.gates.keys() == {"summary"}
    assert (table.name, table.chi_squared_before > 100) == ("count", True)
    assert table.chi_squared_after < 3 * table.dof
    assert any(region.feature == "count" and region.low == -0.5 for region in told.regions)
    assert told.gap_before.low > 1 >= told.gap_after.low


def test_the_figure_shows_the_table_as_it_is_published(found, counts):
    drawn = found.result.pictures.spectra[0]
    before = np.searchsorted(counts.edges, drawn.edges)
    merged = np.add.reduceat(counts.values, before[:-1])
    np.testing.assert_allclose(drawn.measured, merged / counts.values.sum())
    assert drawn.before.sum() == pytest.approx(1)


def test_it_is_saved_and_read_again(found, tmp_path):
    found.save(tmp_path)
    again = avobench.load(tmp_path)
    assert again.details() == found.details()
    assert again.diagnosis == found.diagnosis
    assert "kept aside" in (tmp_path / "report.html").read_text()
    assert again.model.parameter_names[0] == "log_rate"


def test_every_call_of_the_simulator_is_counted(counts):
    calls = []

    def simulate(theta, rng):
        calls.append(len(theta))
        return rng.poisson(np.exp(theta[:, 0]))

    task = avobench.task(simulate, prior={"log_rate": (0, 3)}, kinds={"count": "count"}, features=["count"])
    found = avobench.diagnose(task, counts, simulations=200_000, **ZEROS)
    assert sum(calls) - found.diagnosis.num_simulations in range(100)  # beside those of a task's own check
    assert found.diagnosis.num_simulations <= 200_000


def test_a_right_simulator_is_not_rejected_by_densities_with_a_covariance():
    """Two normalised tables of the same angles, whose errors are common in part."""
    task, rng = Weinberg(), np.random.default_rng(4)
    x = task.simulate(np.tile([44.0, 1.0], (6000, 1)), rng)
    edges, tables, blocks = np.linspace(-0.9, 0.9, 13), [], []
    for part in np.array_split(x, 2):
        n = np.histogram(part, edges)[0] / 0.15
        tables.append(avobench.Table(edges, n / len(part), errors=np.sqrt(n), normalised=True, density=True))
        blocks.append(np.diag(n / 0.15) / len(part) ** 2)
    common = 0.01 * np.linspace(-1, 1, 24)
    joint = np.block([[blocks[0], np.zeros((12, 12))], [np.zeros((12, 12)), blocks[1]]]) + np.outer(common, common)
    found = avobench.diagnose(task, avobench.Tables(tables, covariance=joint), effects=[], progress=False)
    assert found.diagnosis.p_value_before > 0.01
    assert [table.dof for table in found.diagnosis.tables] == [11, 11]
    assert [table.name for table in found.diagnosis.tables] == ["cos_angle", "cos_angle (2)"]


@pytest.mark.parametrize("unit", ["keV", "KEV", ""])
def test_the_unit_of_a_table_is_that_of_its_feature_also_in_capitals(unit):
    tables = avobench.Tables.of(avobench.Table([0, 1, 2], [60, 40], unit=unit))
    assert [table.unit for table in tables_of(decays(feature_units={"time": "keV"}), tables)] == ["keV"]


def decays(**stated):
    prior, stated = {"mean": (1, 4)}, {"features": ["time"], **stated}
    return avobench.task(lambda theta, rng: rng.exponential(theta), prior=prior, name="times", **stated)


@pytest.mark.parametrize("last", [np.inf, 1e9])
def test_an_open_last_bin_tells_theta_as_one_with_a_far_edge(last, tmp_path):
    table = avobench.Table([0, 1, 2, 3, last], [1574, 954, 579, 893])  # of a mean of 2
    task = decays()
    fit = avobench.infer(task, table, budget=80_000)
    assert abs(fit.theta["mean"] - 2) < 3 * fit.std["mean"] < 0.3
    found = avobench.diagnose(task, table, effects=[], progress=False)
    assert found.diagnosis.p_value_before > 0.01
    with pytest.warns(UserWarning, match=r"no model\.json"):
        found.save(tmp_path)
    assert (tmp_path / "distribution-1.png").is_file()
    assert avobench.load(tmp_path).details() == found.details()


@pytest.mark.parametrize(
    ("changed", "number"),
    [
        ([{}], 4000),
        ([{"num_events": 5000}], 5000),
        ([{}, {}], 4000),
        ([{}, {"num_events": 5000}], None),
        ([{"errors": [90, 90, 90], "normalised": True}], None),
    ],
)
def test_a_fit_tells_how_many_events_the_tables_are_of(changed, number, tmp_path):
    """By num_events or their counts, and not by how many events would tell as much."""
    tables = [avobench.Table([0, 1, 2, 40], [1574, 954, 1472], **each) for each in changed]
    fit = avobench.infer(decays(), tables, budget=40_000)
    kept = avobench.load(fit.save(tmp_path / "fit.json"))
    for each in (fit, kept):
        assert each.num_events == each.to_dict()["num_events"] == number
        assert f"{len(tables)} table" in str(each)
        assert f"{3 * len(tables)} bins" in str(each)
        assert number is None or f"({number} events)" in str(each)


@pytest.mark.parametrize(
    ("tables", "options", "word"),
    [
        ({"feature": "energy"}, {}, "no feature energy; it has: count"),
        ({}, {"ordered": True}, "no single sample"),
        ({}, {"fit": "smm"}, "no single sample"),
        ({"edges": [0, 1], "values": [900]}, {}, "tell no more than the 1 parameters"),
        ({"edges": [500, 501, 502], "values": [900, 900]}, {}, "no simulated event has an entry in its bins"),
    ],
)
def test_tables_that_cannot_be_diagnosed_are_told_in_one_line(tables, options, word):
    table = avobench.Table(**{"edges": [0, 2, 4, 6], "values": [90, 80, 70], **tables})
    with pytest.raises(avobench.UsageError, match=word) as raised:
        avobench.diagnose(Poisson(), table, progress=False, **options)
    assert "\n" not in str(raised.value)


def test_the_command_takes_tables_from_files(counts, tmp_path, done):
    rows = zip(counts.edges, counts.edges[1:], counts.values, strict=False)
    (tmp_path / "a.csv").write_text("low,high,value\n" + "".join(f"{a},{b},{v:.0f}\n" for a, b, v in rows))
    command = ["diagnose", "--task", "poisson", "--effects", "zero_inflation", "--out", tmp_path / "out"]
    told = done("--in-process", *command, "--table", tmp_path / "a.csv:a", "--columns", "count")
    assert "missing: zero_inflation" in told


@pytest.mark.parametrize(("num", "budget"), [(500, 2000), (4000, 20_000)])
def test_a_budget_that_is_too_small_for_a_table_is_told_with_one_that_suffices(num, budget):
    edges = [0, 1, 2, 4, 8, 16, np.inf]
    table = avobench.Table(edges, np.histogram(np.random.default_rng(0).exponential(2, num), edges)[0])
    with pytest.raises(avobench.UsageError, match=rf"^{budget} .* allow \d+$") as refused:
        avobench.infer(decays(), table, budget=budget, progress=False)
    enough = int(str(refused.value).split()[-1])
    fit = avobench.infer(decays(), table, budget=enough, progress=False)
    assert budget < fit.num_simulations <= enough
    assert abs(fit.theta["mean"] - 2) < 4 * fit.std["mean"]
