"""An interrupted study goes on, and a damaged record is told."""

import pytest

from avobench.tasks.errors import StoreError
from paper.studies.files import StudyFile, add_lines, read_lines

FILE = StudyFile("numbers")


def test_what_is_lacking_is_made_once_and_written_at_once(tmp_path):
    path, begun = tmp_path / FILE.name, []

    def made(stop=None):
        def square(n):
            begun.append(n)
            if n == stop:
                raise KeyboardInterrupt
            return {"square": n * n}

        wanted = [({"n": n}, lambda n=n: square(n)) for n in range(3)]
        return FILE.completed(path, "rows", wanted, seed=0)

    with pytest.raises(KeyboardInterrupt):
        made(stop=1)
    record = made()
    assert begun == [0, 1, 1, 2]
    assert record["rows"] == [{"n": 0, "square": 0}, {"n": 1, "square": 1}, {"n": 2, "square": 4}]
    assert FILE.read(tmp_path) == record == made()
    assert FILE.begun(path, "rows", seed=1)["rows"] == []
    path.write_bytes(path.read_bytes().replace(b"square", b"sqaure"))
    with pytest.raises(StoreError, match="was changed after it was written"):
        FILE.read(tmp_path)
    with pytest.raises(StoreError, match="study numbers"):
        FILE.read(tmp_path / "nowhere")


def test_a_row_takes_the_place_of_an_earlier_version(tmp_path):
    def made(version, names):
        wanted = [({"name": name, "version": version}, dict) for name in names]
        return FILE.completed(path, "rows", wanted)["rows"]

    path = tmp_path / FILE.name
    made("1", "ab")
    assert made("2", "b") == [{"name": "a", "version": "1"}, {"name": "b", "version": "2"}]


def test_lines_are_added_for_what_a_file_lacks(tmp_path):
    path = tmp_path / "rows.jsonl"
    for last in (2, 4):
        add_lines(path, (({"n": n}, lambda n=n, last=last: {"n": n, "of": last}) for n in range(last)))
    assert [row["of"] for row in read_lines(path)] == [2, 2, 4, 4]
