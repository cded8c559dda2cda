"""Settings are chosen on targets of their own, and the presets are what was chosen."""

import numpy as np
import pytest

from avobench.bench.cells.trial import blank_record
from avobench.bench.plugins import registry
from avobench.bench.store.status import Status
from avobench.methods.abc_smc import AbcSmc, AbcSmcTuned
from avobench.methods.bolfi import Bolfi, BolfiTuned
from avobench.reports.quantities import efficient_median
from paper.studies import development
from paper.studies.tuning import CANDIDATES, candidate, cells
from paper.tables.tuning import table


def test_no_development_target_is_one_of_the_benchmark():
    for name, kind in development.TASKS.items():
        benchmark = registry.build("task", name, {})
        assert not np.isin(kind().targets(), benchmark.targets()).any()
        assert kind().floor_shares == benchmark.floor_shares
        assert (kind().summary(benchmark.simulate(benchmark.targets(), np.random.default_rng(0))) >= 0).all()


@pytest.mark.parametrize(("tuned", "plain"), [(AbcSmcTuned(), AbcSmc), (BolfiTuned(), Bolfi)])
def test_a_preset_is_one_of_the_candidates(tuned, plain):
    assert registry.settings_of(plain(**_changed(tuned, plain()))) in [
        registry.settings_of(plain(**settings)) for settings in CANDIDATES[plain.name].values()
    ]


def _changed(tuned, plain):
    names = registry.settings_of(tuned).keys()
    return {name: getattr(tuned, name) for name in names if getattr(tuned, name) != getattr(plain, name)}


def test_the_table_is_of_the_targets_that_all_candidates_have():
    records = {}
    for cell in cells():
        record = blank_record(cell, Status.OK, "") | {"theta_hat": [1.001 * t for t in cell.identity["theta_true"]]}
        far = 1.0 if cell.target == 0 else 1000.0
        own = efficient_median(cell.build_task().floor_shares) if "Weinberg" not in cell.task else 1.0
        record |= {"squared_error": far * own, "floor": 1.0, "status": "ok"}
        if cell.target == 0 or "Carl" not in cell.task:  # carl has one target
            records[cell.id] = record
    rows = table(records).set_index(["method", "settings"])
    assert (rows["targets"] == 1).all()
    assert rows["poisson"].tolist() == pytest.approx([1.0] * len(rows))
    failed = candidate("bolfi", {}, "poisson")[0].id
    records[failed] |= {"status": Status.METHOD_ERROR, "theta_hat": None}
    again = table(records)
    assert np.isinf(again.loc[again["method"] == "bolfi", "poisson"].iloc[0])
