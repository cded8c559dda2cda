"""Every figure shows what the records hold, and writes the numbers that it draws."""

import numpy as np
import pandas as pd
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import observe
from avobench.bench.cells.trial import execute
from avobench.reports import cost, efficiency
from avobench.reports.figures import FIGURES
from avobench.reports.style import METHOD_COLOURS, PALETTE, colours
from avobench.tasks.errors import StoreError
from avobench.tasks.weinberg import Weinberg
from paper.figures import alignment, detector, poisson, weinberg
from paper.studies import paper as study


@pytest.fixture(scope="module")
def examples():
    """Runs of the two studies at a hundredth of their length or less, two of each kind."""
    common = {"hidden": [4], "schedule": "shared", "initial_std": 0.5}
    poisson = [("PoissonExample", {**common, "entropy": gamma}) for gamma in (0.0, 1e-4)]
    kinds = [*poisson, ("AlignmentExample", {"hidden": [4], "schedule": "shared"})]
    return [
        execute(Cell(f"paper.studies.paper:{task}", {}, "avo-paper", settings, 0, repetition, 640, 200, 0))
        for task, settings in kinds
        for repetition in range(2)
    ]


def drawn(module, records, folder):
    """The table of a figure, once its three files are there."""
    paths = module.draw(records, folder)
    assert [path.suffix for path in paths] == [".pdf", ".png", ".csv"]
    assert paths[0].read_bytes().startswith(b"%PDF")
    assert paths[1].read_bytes().startswith(b"\x89PNG")
    return pd.read_csv(paths[2])


def test_a_method_has_one_colour_in_every_figure():
    everyone = colours([*METHOD_COLOURS, "mine", "avo batch_size=64"])
    assert len(set(everyone.values())) == len(everyone)
    assert everyone["bolfi"] == colours(["bolfi"])["bolfi"] == METHOD_COLOURS["bolfi"]
    assert set(everyone.values()) <= set(PALETTE)


def test_poisson_draws_each_run_from_its_start_to_its_end(examples, tmp_path):
    table = drawn(poisson, examples, tmp_path)
    runs = table[table["curve"] != "before"].groupby(["panel", "repetition"])["curve"].nunique()
    assert runs["proposals", 0] == runs["loss", 1] == 2
    start = table[table["panel"] == "loss"].groupby(["curve", "repetition"])["y"].first()
    expected = 0.5 * np.log(7) ** 2 / 0.5**2 + np.log(0.5 * np.sqrt(2 * np.pi))
    np.testing.assert_allclose(start, expected, rtol=1e-3)
    for panel, integral in (("proposals", np.trapezoid), ("models", lambda y, x: y.sum())):
        for _, curve in table[table["panel"] == panel].groupby(["curve", "repetition"]):
            assert integral(curve["y"], curve["x"]) == pytest.approx(1, abs=0.01)


def test_the_model_of_a_narrow_proposal_is_the_poisson_itself(examples):
    record = {**examples[0], "trace": [{"simulations": 1, "theta": [np.log(7)], "std": [1e-6]}]}
    counts = np.arange(40)
    np.testing.assert_allclose(poisson.model(record, counts) @ counts, 7, rtol=1e-4)
    wide = {**examples[0], "trace": [{"simulations": 1, "theta": [np.log(7)], "std": [0.3]}]}
    np.testing.assert_allclose(poisson.model(wide, counts) @ counts, 7 * np.exp(0.3**2 / 2), rtol=1e-4)


def test_alignment_draws_distance_and_loss(examples, tmp_path):
    table = drawn(alignment, examples, tmp_path)
    first = table[table["panel"] == "distance"].groupby("repetition").first()
    assert first["x"].tolist() == [0, 0]
    np.testing.assert_allclose(first["y"], 1)  # from 0 to the offset of 1 mm
    for module in (poisson, alignment):
        with pytest.raises(StoreError, match="study"):
            module.draw([], tmp_path)


def test_detector_draws_two_averages_and_six_events(tmp_path):
    record = study.detector(tmp_path / "detector.json", num_events=50)
    table = drawn(detector, [record], tmp_path)
    assert table.groupby("theta").size().tolist() == [1024, 1024]
    shown = table[table["theta"] == 1].reset_index()
    assert shown.index[shown["event_2"] == 1].tolist() == record["responses"][1]["events"][2]
    assert shown.loc[77, "row"] * 32 + shown.loc[77, "column"] == 77
    np.testing.assert_allclose(shown["mean"], record["responses"][1]["mean"], rtol=1e-5)


def test_weinberg_draws_the_very_observation_and_the_density_at_the_estimate(benchmark, tmp_path):
    table = drawn(weinberg, benchmark, tmp_path)
    assert set(table["method"]) == {"avo", "avo-paper", "abc-smc", "bolfi"}
    assert set(table["target"]) == {0, 1, 2, 3}
    panel = table[(table["target"] == 1) & (table["method"] == "bolfi")]
    x = observe(Weinberg(), 1, 2_000, 0)
    np.testing.assert_allclose(panel["observed_density"], np.histogram(x, 20, (-1, 1), density=True)[0], rtol=1e-5)
    theta = Weinberg().targets()[1] - 1e-2
    np.testing.assert_allclose(panel["e_beam_hat"], theta[0], rtol=1e-5)
    np.testing.assert_allclose(panel["fitted_density"], Weinberg().density(panel["cos_a"], theta), rtol=1e-5)
    with pytest.raises(StoreError, match="weinberg"):
        weinberg.draw(benchmark[:2], tmp_path)


def test_efficiency_reads_the_trace_as_it_was_known_at_the_time(make_record):
    record = make_record("poisson", "avo", 0, 0.1)
    errors = efficiency.errors_at(record, np.array([7_999, 8_000, 15_999, 16_000, 10**6]))
    np.testing.assert_allclose(errors, [np.nan, 1, 1, 0.01, 0.01])


def test_efficiency_shows_medians_from_the_first_estimate_of_all(benchmark, tmp_path):
    table = drawn(efficiency, [record for record in benchmark if record["task"] == "poisson"], tmp_path)
    own = table[(table["task"] == "poisson") & (table["method"] == "bolfi")]
    assert own["simulations"].min() >= 8_000
    assert own["simulations"].max() == 16_000
    np.testing.assert_allclose(own[own["simulations"] < 16_000]["median"], 1e-2, rtol=1e-5)
    np.testing.assert_allclose(own["median"].iloc[-1], 1e-4, rtol=1e-5)
    floors = [record["floor"] for record in benchmark if (record["task"], record["method"]) == ("poisson", "bolfi")]
    assert own["floor"].iloc[-1] == pytest.approx(np.median(floors), rel=1e-4)
    assert own["floor"].is_monotonic_decreasing


def test_cost_shows_the_medians(benchmark, tmp_path):
    shown = [record for record in benchmark if record["task"] in ("carl", "weinberg")]
    table = drawn(cost, shown, tmp_path).set_index(["task", "method"])
    assert table.loc[("carl", "bolfi"), "cells"] == 6
    assert table.loc[("carl", "bolfi"), "median_seconds"] == pytest.approx(1 + 10 * 1.25)
    assert table.loc[("carl", "bolfi"), "median_squared_error"] == pytest.approx(2e-4)


def test_failures_and_a_users_task_leave_the_others_to_be_drawn(benchmark, make_record, tmp_path):
    mine, known = [{**record, "task": "mine"} for record in benchmark[:8]], benchmark[:16]
    records = [*mine, *known, make_record("poisson", "bolfi", 5, None), make_record("poisson", "avo", 5, None)]
    for module in (efficiency, cost):
        table = drawn(module, records, tmp_path)
        assert {"mine", "poisson"} <= set(table["task"])


def test_the_command_draws_several(avobench, make_record, tmp_path):
    from avobench.bench.store.store import Store

    store = Store(tmp_path / "results", create=True)
    store.write(make_record("poisson", "avo", 0, 0.1))
    code, out, err = avobench("figure", "cost", "efficiency", "--results", store.path, "--out", tmp_path / "figures")
    assert code == 0, err
    assert len(out.splitlines()) == 6
    code, _, err = avobench("figure", "nonsense")
    assert (code, all(name in err for name in FIGURES)) == (2, True)
