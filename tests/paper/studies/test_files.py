"""An interrupted study goes on, and a damaged record is told."""

import pytest

from avobench.tasks.errors import StoreError
from paper.studies.files import StudyFile

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
