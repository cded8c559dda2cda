"""The benchmark of growth measures what it says."""

from paper.speed import growth


def test_memory_does_not_grow_with_the_number_of_cells(tmp_path, monkeypatch):
    """The leader keeps some kilobytes a cell, whatever its method: its records without their traces."""
    monkeypatch.setitem(growth.TINY, "smm", (400, []))  # which loads no network
    few = growth.sweep(1, 2, 1, 400, tmp_path / "few", "smm")
    many = growth.sweep(6, 3, 1, 400, tmp_path / "many", "smm")
    assert many["cells"] == 18
    assert many["of it new [MiB]"] < few["of it new [MiB]"] + 3
