"""Coverage is the share of true parameters within what was quoted."""

import numpy as np
import pytest
from scipy.stats import norm

from avobench.reports import coverage
from avobench.tasks.errors import StoreError
from paper.tables.coverage import table


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
    rows = table(told).set_index("method")
    assert rows["parameters"].tolist() == [400, 400]
    assert rows.loc["avo", ["within 68%", "within 95%"]].tolist() == ["68%", "95%"]
    half = norm.cdf(norm.ppf(0.84) / 2) * 2 - 1
    assert float(rows.loc["abc-smc", "within 68%"].rstrip("%")) / 100 == pytest.approx(half, abs=0.006)
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
