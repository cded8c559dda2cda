"""Records carried out again."""

from pathlib import Path

import pytest

from avobench.bench.store.store import Store
from avobench.tasks.errors import UsageError
from paper.studies.again import table

RECORDS = Path(__file__).parents[3] / "results/smm"


@pytest.fixture(scope="module")
def first():
    return next(r for r in Store(RECORDS).read_all() if (r["task"], r["target"]) == ("poisson", 0))


def test_a_committed_record_comes_out_again_and_another_estimate_is_told(first):
    assert table([first], "poisson", "smm", [0])["difference"].item() < 1e-6
    moved = {**first, "theta_hat": [first["theta_hat"][0] + 0.4]}
    assert table([moved], "poisson", "smm", [0])["difference"].item() == pytest.approx(0.1, rel=1e-4)  # of U(0, 4)


def test_what_cannot_be_compared_is_one_line(first):
    with pytest.raises(UsageError, match="no record of avo on poisson"):
        table([first], "poisson", "avo", [0])
    with pytest.raises(UsageError, match="another version"):
        table([{**first, "id": "0" * 64}], "poisson", "smm", [0])
