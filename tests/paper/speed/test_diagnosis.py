from avobench.bench.plugins import registry
from avobench.effects.catalogue import catalogue
from paper.speed.diagnosis import HIDDEN, measure, memory


def test_a_row_tells_what_a_diagnosis_took_and_that_it_was_right():
    row = measure("poisson", 2000, 0.2)
    share = round(0.2 * len(catalogue(registry.build("task", "poisson", {}))))
    assert row["named"] == HIDDEN["poisson"][0]
    assert (row["events"], row["effects"]) == (2000, share)
    assert row["seconds"] > 0
    assert row["simulated"] > 2000


def test_a_row_of_memory_tells_the_peak(monkeypatch):
    monkeypatch.setattr("paper.speed.diagnosis.LARGE_SIMULATIONS", 300_000)
    row = memory("poisson", 2000)
    assert row["events"] == row["compared"] == 2000
    assert 0 < row["GB before"] <= row["GB at most"]
    assert row["simulated"] <= 300_000
