"""The example of a published histogram: workers differ in how liable they are to accidents, as its authors found."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "examples"))
from accidents_table import table, task

import avobench


def test_workers_are_not_equally_liable():
    found = avobench.diagnose(task, table, effects=["overdispersion"], progress=False)
    (effect,) = found.diagnosis.effects
    variance = effect.parameters["variance"]
    assert variance.std > 0.15  # some 0.25 is right for so few workers
    assert abs(variance.value - 1.05) < 3 * variance.std  # by the method of moments, from a variance of 0.69
    assert found.diagnosis.tables[0].name == "workers"
