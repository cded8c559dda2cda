"""Sweeps and records from Python."""

import pytest

import avobench


def test_a_sweep_gives_a_row_a_cell_and_the_next_one_makes_nothing_again(tmp_path, beside_users_modules):
    swept = {"tasks": "toys:Normal", "methods": ["toys:Moment"], "targets": "0-2", "budget": 400, "observations": 100}
    frame = avobench.run(**swept, results=tmp_path / "r", workers=avobench.Workers(jobs=1))
    assert frame["target"].tolist() == [0, 1, 2]
    assert (frame["status"] == "ok").all()
    again = avobench.run(**swept, results=tmp_path / "r", workers=avobench.Workers(jobs=1))
    assert again["started"].tolist() == frame["started"].tolist()
    assert avobench.records(tmp_path / "r").shape == frame.shape


@pytest.mark.parametrize(
    ("workers", "said"),
    [
        ({"jobs": 0}, "--jobs must be at least 1"),
        ({"backend": "dask"}, "belong together"),
        ({"scheduler": "tcp://nowhere:1"}, "belong together"),
        ({"group": 3}, "--group is for --backend together"),
        ({"backend": "together", "group": 0}, "--group is for --backend together, at least 1"),
        ({"time_limit": 0}, "--time-limit must be a number above 0"),
        ({"memory_limit": float("nan")}, "--memory-limit must be a number above 0"),
        ({"time_limit": 5, "in_process": True}, "--time-limit is not for --in-process"),
        ({"jobs": 2, "in_process": True}, "--in-process is one process"),
        ({"memory_limit": 5, "backend": "dask", "scheduler": "tcp://x:1"}, "--memory-limit is not for --backend dask"),
    ],
)
def test_workers_that_make_no_sense_are_refused(workers, said):
    with pytest.raises(avobench.UsageError, match=said):
        avobench.Workers(**workers)
