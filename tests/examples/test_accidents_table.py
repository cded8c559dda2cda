"""The example of a published histogram: workers differ in how liable they are to accidents, as its authors found."""

from accidents_table import table, task

import avobench


def test_workers_are_not_equally_liable():
    """The quarter of 647 workers that is held out is so small that it may veto by chance: one of three seeds may."""
    found = [avobench.diagnose(task, table, effects=["overdispersion"], seed=k, progress=False) for k in range(3)]
    assert all(each.diagnosis.models[0].effects[0].name == "overdispersion" for each in found)
    named = [each.diagnosis for each in found if each.diagnosis.effects]
    assert len(named) > 1
    for diagnosis in named:
        variance = diagnosis.effects[0].parameters["variance"]
        assert variance.std > 0.15  # some 0.25 is right for so few workers
        assert abs(variance.value - 1.05) < 3 * variance.std  # by the method of moments, from a variance of 0.69
        assert diagnosis.tables[0].name == "workers"
