"""The cells of the studies beyond the paper's: what they compare, and that nothing of the benchmark is among them."""

import numpy as np
import pytest

from avobench.bench.plugins import registry
from paper.studies import dimension, fresh


def test_dimension_tries_every_method_with_and_without_telling_means_few_parameters_first():
    cells = dimension.cells()
    assert len({cell.id for cell in cells}) == len(cells)
    tried = {(cell.task, cell.method) for cell in cells}
    for method, reached in dimension.REACHED.items():
        own = {f"{f}-{p}" for f in dimension.FAMILIES for p in reached}
        own |= {dimension.DETECTOR} if method in dimension.DETECTOR_METHODS else set()
        assert {task for task, by in tried if by == method} == own
    sizes = [int(cell.task.rpartition("-")[2]) for cell in cells]
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("task", fresh.TASKS)
def test_fresh_targets_are_others_than_the_tasks_own_and_pose_the_same_problem(task):
    own, targets = task.of(), task().targets()
    assert targets.shape == (fresh.NUM_FRESH, own.prior.dim)
    assert own.prior.contains_all(targets)
    assert not np.isin(targets, own.targets(fresh.NUM_FRESH)).any()
    assert registry.settings_of(task()) == registry.settings_of(own)
    assert task().floor(targets[0], 1000, 1000) == own.floor(targets[0], 1000, 1000)


def test_fresh_cells_are_complete_target_by_target():
    cells = fresh.cells()
    assert len({cell.id for cell in cells}) == len(cells) == fresh.NUM_FRESH * len(fresh.TASKS) * len(fresh.METHODS)
    assert [cell.target for cell in cells] == sorted(cell.target for cell in cells)
