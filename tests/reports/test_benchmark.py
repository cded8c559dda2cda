"""The box plots show what the records hold."""

import numpy as np
import pytest

from avobench.bench.cells.trial import execute
from avobench.bench.sweep.plan import plan
from avobench.reports import benchmark


@pytest.fixture(scope="module")
def records():
    """Five targets each: poisson, weinberg, and poisson with another network."""
    cells = []
    for task, hidden in (("poisson", 4), ("weinberg", 4), ("poisson", 5)):
        cells += plan([task], ["avo-paper"], "0-4", 1, 480, 300, 0, [f"avo-paper.hidden=[{hidden}]"])
    return [execute(cell) for cell in cells]


def failed(record):
    return {**record, "status": "method_error", "squared_error": None, "theta_hat": None, "mean": None, "std": None}


def test_the_table_holds_the_quartiles_of_what_is_ok(records):
    (row,) = benchmark.drawn([*records[:4], failed(records[4])])[1].to_dict("records")
    errors = [record["squared_error"] for record in records[:4]]
    assert (row["task"], row["cells"], row["failed"], row["targets"]) == ("poisson", 5, 1, 5)
    names = ("min", "lower_quartile", "median", "upper_quartile", "max")
    np.testing.assert_allclose([row[name] for name in names], np.quantile(errors, [0, 0.25, 0.5, 0.75, 1]), rtol=1e-5)
    ratios = [record["squared_error"] / record["floor"] for record in records[:4]]
    assert row["median_error_over_floor"] == pytest.approx(np.median(ratios), rel=1e-5)


def test_a_box_a_method_and_setting_and_a_panel_a_task_with_its_floor(records):
    figure, _ = benchmark.drawn(records)
    panels = [axis for axis in figure.axes if axis.get_visible()]
    assert [axis.get_title() for axis in panels] == ["poisson: 5 targets", "weinberg: 5 targets"]
    assert [len(axis.get_xticks()) for axis in panels] == [2, 1]
    for axis, shown in zip(panels, (records[:5] + records[10:], records[5:10]), strict=True):
        assert axis.get_yscale() == "log"
        floor = np.median([record["floor"] for record in shown])
        assert any(np.allclose(line.get_ydata(), floor) for line in axis.lines if line.get_linestyle() == "--")
    points = np.concatenate([np.asarray(group.get_offsets())[:, 1] for group in panels[1].collections])
    np.testing.assert_allclose(np.sort(points), np.sort([record["squared_error"] for record in records[5:10]]))


def test_only_targets_that_all_methods_have_are_compared(records):
    weinberg, other = records[5:10], [{**record, "method": "other"} for record in records[6:8]]
    table = benchmark.drawn([*weinberg, *other])[1].set_index("method")
    assert table["targets"].tolist() == [2, 2]
    assert table.loc["avo-paper", "median"] == pytest.approx(table.loc["other", "median"])
