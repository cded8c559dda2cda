"""The benchmark of growth measures what it says."""

from paper.speed.growth import sweep


def test_memory_does_not_grow_with_the_number_of_cells(tmp_path):
    """The leader keeps some kilobytes a cell: its records without their traces."""
    few = sweep(1, 2, 1, 480, tmp_path / "few")
    many = sweep(6, 3, 1, 480, tmp_path / "many")
    assert many["cells"] == 18
    assert many["of it new [MiB]"] < few["of it new [MiB]"] + 3
