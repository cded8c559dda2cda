"""Every figure shows what the records hold, and writes the numbers that it draws."""

import numpy as np
import pandas as pd
import pytest

from avobench.reports.efficiency import errors_at
from avobench.reports.figures import FIGURES, draw, drawn
from avobench.reports.style import METHOD_COLOURS, PALETTE, colours


def test_a_method_has_one_colour_in_every_figure():
    everyone = colours([*METHOD_COLOURS, "mine", "avo batch_size=64"])
    assert len(set(everyone.values())) == len(everyone)
    assert everyone["bolfi"] == colours(["bolfi"])["bolfi"] == METHOD_COLOURS["bolfi"]
    assert set(everyone.values()) <= set(PALETTE)


def test_efficiency_reads_the_trace_as_it_was_known_at_the_time(make_record):
    record = make_record("poisson", "avo", 0, 0.1)
    errors = errors_at(record, np.array([7_999, 8_000, 15_999, 16_000, 10**6]))
    np.testing.assert_allclose(errors, [np.nan, 1, 1, 0.01, 0.01])


def test_efficiency_ends_at_the_estimate_where_the_trace_ends_before(make_record):
    record = make_record("poisson", "avo", 0, 0.1)
    record["trace"] = record["trace"][:1]  # at half the budget, ten times as far
    np.testing.assert_allclose(errors_at(record, np.array([15_999, 16_000])), [1, record["squared_error"]])


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
