"""Both surrogates are timed on the same cell, and their errors are paired."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from avobench.tasks.errors import AvobenchError
from paper.speed.bolfi import compare, main, summary


def test_a_run_that_fails_is_not_a_time():
    with pytest.raises(AvobenchError, match="poisson target 0 with fast: budget_exhausted"):
        compare("poisson", 5, [0])


@pytest.mark.parametrize(("factor", "least", "most"), [(1.0, 0.1, 1), (30.0, 0, 0.05)])
def test_the_summary_tells_whether_the_errors_differ(factor, least, most):
    errors, noise = np.random.default_rng(0).lognormal(size=(2, 15))
    columns = {"ratio": 3.0, "gpy squared error": errors, "fast squared error": factor * errors * noise}
    line = summary(pd.DataFrame(columns))
    assert "median ratio 3.0" in line
    assert least <= float(line.split("p = ")[1].split()[0]) <= most


def test_the_command_prints_a_table_and_its_summary():
    result = CliRunner().invoke(main, ["--poisson", "12", "--carl", "0", "--targets", "0"])
    assert result.exit_code == 0, result.output
    assert "gpy [s]" in result.output
    assert "poisson: median ratio" in result.output
    assert "carl" not in result.output
