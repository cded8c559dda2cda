"""The paper's figures; what they show of the committed records is compared in tests/docs/test_published.py."""

import numpy as np
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import observe
from avobench.bench.cells.trial import execute
from avobench.tasks.errors import StoreError
from avobench.tasks.weinberg import Weinberg
from paper.figures import alignment, dimension, poisson, weinberg


@pytest.mark.parametrize(("std", "mean"), [(1e-6, 7), (0.3, 7 * np.exp(0.3**2 / 2))])
def test_the_model_of_a_proposal_has_the_mean_of_a_poisson_of_a_lognormal_rate(std, mean):
    record = {"trace": [{"simulations": 1, "theta": [np.log(7)], "std": [std]}]}
    counts = np.arange(40)
    np.testing.assert_allclose(poisson.model(record, counts) @ counts, mean, rtol=1e-4)


def test_weinberg_draws_the_very_observation_and_the_density_at_the_estimate(benchmark):
    _, table = weinberg.drawn(benchmark)
    panel = table[(table["target"] == 1) & (table["method"] == "bolfi")]
    x = observe(Weinberg(), 1, 2_000, 0)
    np.testing.assert_allclose(panel["observed_density"], np.histogram(x, 20, (-1, 1), density=True)[0], rtol=1e-5)
    theta = Weinberg().targets()[1] - 1e-2
    np.testing.assert_allclose(panel["fitted_density"], Weinberg().density(panel["cos_a"], theta), rtol=1e-5)


NEEDS = [(poisson, "study"), (alignment, "study"), (weinberg, "weinberg"), (dimension, "study dimension")]


@pytest.mark.parametrize(("figure", "said"), NEEDS)
def test_without_the_records_that_it_needs_a_figure_says_so(figure, said):
    with pytest.raises(StoreError, match=said):
        figure.drawn([])


@pytest.fixture(scope="module")
def records():
    """Runs of smm on both families and two numbers of parameters, with few events."""
    return [
        execute(Cell(f"{family}-{p}", {}, "smm", {}, target, 0, 4000, 2000, 0))
        for family in ("warped", "means")
        for p in (5, 2)
        for target in range(2)
    ]


def at(record, ratio, status="ok"):
    """The record with an estimate whose squared error is so many floors, at two of its quoted standard errors."""
    p, error = len(record["theta_true"]), np.sqrt(ratio * record["floor"] / len(record["theta_true"]))
    found = (np.array(record["theta_true"]) + error).tolist()
    own = {"theta_hat": found, "squared_error": ratio * record["floor"], "standard_error": [error / 2] * p}
    return {**record, **own, "status": status}


def test_a_row_has_the_numbers_of_its_family_parameters_and_method(records):
    told = [at(record, 1000 if record["task"] == "warped-5" else 0.5) for record in records]
    told[0]["status"] = "doubtful"
    assert told[0]["task"] == "warped-5"
    rows = dimension.table([*told, {**told[0], "task": "poisson"}]).set_index(["family", "parameters"])
    assert rows.index.tolist() == [("warped", 2), ("warped", 5), ("means", 2), ("means", 5)]
    assert rows["targets"].tolist() == [2] * 4
    assert rows["above 100"].tolist() == [0, 2, 0, 0]
    assert rows["of these ok"].tolist() == [0, 1, 0, 0]
    assert rows.loc[("means", 2), "inefficiency"] == pytest.approx(0.5 / np.log(2), rel=0.01)  # chi2 of 2, its median
    assert rows.loc[("warped", 5), "worst run / floor"] == pytest.approx(1000)
    assert dimension.drawn(told)[1]["inefficiency"].to_numpy() == pytest.approx(rows["inefficiency"], rel=1e-5)
