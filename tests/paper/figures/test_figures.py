"""The paper's figures show what the records hold."""

import numpy as np
import pandas as pd
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import observe
from avobench.bench.cells.trial import execute
from avobench.tasks.errors import StoreError
from avobench.tasks.weinberg import Weinberg
from paper.figures import alignment, detector, poisson, weinberg
from paper.studies import detector as response
from paper.tasks import AlignmentExample, PoissonExample, spec


@pytest.fixture(scope="module")
def examples():
    """Runs of the two studies at a hundredth of their length or less, two of each kind."""
    common = {"hidden": [4], "schedule": "shared", "initial_std": 0.5}
    poisson = [(PoissonExample, {**common, "entropy": gamma}) for gamma in (0.0, 1e-4)]
    kinds = [*poisson, (AlignmentExample, {"hidden": [4], "schedule": "shared"})]
    return [
        execute(Cell(spec(task), {}, "avo-paper", settings, 0, repetition, 640, 200, 0))
        for task, settings in kinds
        for repetition in range(2)
    ]


def drawn(module, records, folder):
    """The table of a figure, of which the third file is the numbers."""
    return pd.read_csv(module.draw(records, folder)[2])


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
    record = response.made(tmp_path / "detector.json", num_events=50)
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
