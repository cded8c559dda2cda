"""Every figure shows what the records hold, and writes the numbers that it draws."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from avobench.bench.cells.trial import execute
from avobench.bench.sweep.plan import plan
from avobench.reports import benchmark as boxes
from avobench.reports import coverage
from avobench.reports.efficiency import errors_at
from avobench.reports.figures import FIGURES, draw, drawn
from avobench.reports.style import METHOD_COLOURS, PALETTE, colours
from avobench.tasks.errors import StoreError
from paper.tables.experiments import coverage as coverage_table


def test_a_method_has_one_colour_in_every_figure():
    everyone = colours([*METHOD_COLOURS, "mine", "avo batch_size=64"])
    assert len(set(everyone.values())) == len(everyone)
    assert everyone["bolfi"] == colours(["bolfi"])["bolfi"] == METHOD_COLOURS["bolfi"]
    assert set(everyone.values()) <= set(PALETTE)


@pytest.mark.parametrize("points", [2, 1])
def test_efficiency_reads_the_trace_as_it_was_known_at_the_time_and_ends_at_the_estimate(make_record, points):
    record = make_record("poisson", "avo", 0, 0.1)
    record["trace"] = record["trace"][:points]  # the first at half the budget, ten times as far
    errors = errors_at(record, np.array([7_999, 8_000, 15_999, 16_000, 10**6]))
    np.testing.assert_allclose(errors, [np.nan, 1, 1, 0.01, 0.01])


def test_efficiency_shows_medians_from_the_first_estimate_of_all(benchmark, make_record):
    lost = make_record("poisson", "bolfi", 5, 3.0)  # one far run moves no median
    others = [record for record in benchmark if record["task"] == "poisson" and record["id"] != lost["id"]]
    _, table = drawn("efficiency", [*others, lost])
    own = table[(table["task"] == "poisson") & (table["method"] == "bolfi")]
    assert own["simulations"].min() >= 8_000
    assert own["simulations"].max() == 16_000
    np.testing.assert_allclose(own[own["simulations"] < 16_000]["median"], 1e-2, rtol=1e-5)
    np.testing.assert_allclose(own["median"].iloc[-1], 1e-4, rtol=1e-5)
    floors = [record["floor"] for record in benchmark if (record["task"], record["method"]) == ("poisson", "bolfi")]
    assert own["floor"].iloc[-1] == pytest.approx(np.median(floors), rel=1e-4)
    assert own["floor"].is_monotonic_decreasing


def test_failures_and_a_users_task_leave_the_others_to_be_drawn(benchmark, make_record, tmp_path):
    mine, known = [{**record, "task": "mine"} for record in benchmark[:8]], benchmark[:16]
    untraced = [{**record, "task": "untraced", "trace": []} for record in benchmark[:8]]
    failed = [make_record(*of, 5, None) for of in (("poisson", "bolfi"), ("poisson", "avo"), ("weinberg", "avo"))]
    for name in FIGURES[:2]:
        pdf, png, csv = draw(name, [*mine, *known, *untraced, *failed], tmp_path)
        assert pdf.read_bytes().startswith(b"%PDF")
        assert png.read_bytes().startswith(b"\x89PNG")
        assert {"mine", "untraced", "poisson"} <= set(pd.read_csv(csv)["task"])


@pytest.fixture(scope="module")
def executed():
    """Five targets each: poisson, weinberg, and poisson with another network."""
    cells = []
    for task, hidden in (("poisson", 4), ("weinberg", 4), ("poisson", 5)):
        cells += plan([task], ["avo-paper"], "0-4", 1, 480, 300, 0, [f"avo-paper.hidden=[{hidden}]"])
    return [execute(cell) for cell in cells]


def failed(record):
    return {**record, "status": "method_error", "squared_error": None, "theta_hat": None, "mean": None, "std": None}


def test_the_table_holds_the_quartiles_of_what_is_ok(executed):
    (row,) = boxes.drawn([*executed[:4], failed(executed[4])])[1].to_dict("records")
    errors = [record["squared_error"] for record in executed[:4]]
    assert (row["task"], row["cells"], row["failed"], row["targets"]) == ("poisson", 5, 1, 5)
    names = ("min", "lower_quartile", "median", "upper_quartile", "max")
    np.testing.assert_allclose([row[name] for name in names], np.quantile(errors, [0, 0.25, 0.5, 0.75, 1]), rtol=1e-5)
    ratios = [record["squared_error"] / record["floor"] for record in executed[:4]]
    assert row["median_error_over_floor"] == pytest.approx(np.median(ratios), rel=1e-5)


def test_a_box_a_method_and_setting_and_a_panel_a_task_with_its_floor(executed):
    figure, _ = boxes.drawn(executed)
    panels = [axis for axis in figure.axes if axis.get_visible()]
    assert [axis.get_title() for axis in panels] == ["poisson: 5 targets", "weinberg: 5 targets"]
    assert [len(axis.get_xticks()) for axis in panels] == [2, 1]
    for axis, shown in zip(panels, (executed[:5] + executed[10:], executed[5:10]), strict=True):
        assert axis.get_yscale() == "log"
        floor = np.median([record["floor"] for record in shown])
        assert any(np.allclose(line.get_ydata(), floor) for line in axis.lines if line.get_linestyle() == "--")
    points = np.concatenate([np.asarray(group.get_offsets())[:, 1] for group in panels[1].collections])
    np.testing.assert_allclose(np.sort(points), np.sort([record["squared_error"] for record in executed[5:10]]))


def test_only_targets_that_all_methods_have_are_compared(executed):
    weinberg, other = executed[5:10], [{**record, "method": "other"} for record in executed[6:8]]
    table = boxes.drawn([*weinberg, *other])[1].set_index("method")
    assert table["targets"].tolist() == [2, 2]
    assert table.loc["avo-paper", "median"] == pytest.approx(table.loc["other", "median"])


def quoted(record, pull, how="standard_error"):
    """The record with an estimate so many standard errors from the truth."""
    true = np.array(record["theta_true"])
    middle, spread = (true + 0.1 * pull).tolist(), [0.1] * len(true)
    if how == "standard_error":
        return {**record, "theta_hat": middle, "standard_error": spread, "spread_of": "proposal"}
    return {**record, "mean": middle, "std": spread, "spread_of": how}


def test_a_curve_of_gaussian_pulls_is_the_diagonal_and_of_too_narrow_ones_below(benchmark):
    one = next(record for record in benchmark if (record["task"], record["method"]) == ("poisson", "avo"))
    pulls = norm.ppf((np.arange(400) + 0.5) / 400)
    told = [quoted(one, pull) for pull in pulls]
    told += [quoted({**one, "method": "abc-smc"}, 2 * pull, "posterior") for pull in pulls]
    rows = coverage_table(told).set_index("method")
    assert rows["parameters"].tolist() == [400, 400]
    assert rows.loc["avo", ["within 68%", "within 95%"]].tolist() == ["68%", "95%"]
    half = 100 * (norm.cdf(norm.ppf(0.84) / 2) * 2 - 1)
    assert float(rows.loc["abc-smc", "within 68%"].rstrip("%")) == pytest.approx(half, abs=0.6)
    drawn = coverage.drawn(told)[1].set_index("method")
    assert np.abs(drawn.loc["avo", "empirical"] - drawn.loc["avo", "nominal"]).max() < 0.006


def test_a_proposal_and_a_failure_quote_nothing_and_an_unknown_spread_holds_nothing(benchmark):
    proposal = quoted(benchmark[0], 0.5, "proposal")
    assert coverage.distances(proposal) is None
    assert coverage.distances({**quoted(benchmark[0], 0.5), "status": "crashed"}) is None
    unknown = quoted(benchmark[0], 0.5, "posterior")
    unknown["std"] = [None] * len(unknown["std"])
    assert np.isinf(coverage.distances(unknown)).all()
    with pytest.raises(StoreError, match="no coverage to draw"):
        coverage.drawn([proposal])
