"""A results folder from elsewhere, in which a name leads to a user's own files, or to a pipe."""

import os
from pathlib import Path

import pytest

from avobench.bench.store.files import write_file
from avobench.bench.store.pack import pack
from avobench.bench.store.store import NAMES, Store
from avobench.tasks.errors import UsageError

REFERENCE = Store(Path(__file__).parents[3] / "results" / "bolfi-gpy")


@pytest.fixture
def store(tmp_path):
    """A store with two records as files."""
    made = Store(tmp_path / "store", create=True)
    for record in REFERENCE.read_all()[:2]:
        made.write(record)
    return made


@pytest.fixture
def home(tmp_path):
    """A user's own folder with a file."""
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.json").write_text("mine")
    return tmp_path / "home"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["folder", "file", "dangling", "pipe"])
def test_no_name_of_a_store_may_lead_out_of_it(store, home, name, kind):
    place, content = store.path / name, (store.path / "store.json").read_bytes()
    if place.is_dir():
        place.rename(store.path / "moved")
    place.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(place)
    else:
        (home / "store.json").write_bytes(content)
        place.symlink_to({"folder": home, "file": home / "store.json", "dangling": home / "new"}[kind])
    before = {path: path.read_bytes() for path in home.iterdir()}
    with pytest.raises(UsageError, match=f"{name} is "):
        Store(store.path, create=True)
    assert {path: path.read_bytes() for path in home.iterdir()} == before


def test_a_record_that_is_a_link_or_a_pipe_is_told_and_left(store, home):
    first, second = sorted(store.records.iterdir())
    content = first.read_bytes()
    (home / "record.json").write_bytes(content)
    for path in (first, second):
        path.unlink()
    first.symlink_to(home / "record.json")
    os.mkfifo(second)
    sound, damaged = store.read()
    assert sound == []
    assert ["link" in damaged[first], "neither a file" in damaged[second]] == [True, True]
    assert pack(store).rows == 0
    assert (home / "record.json").read_bytes() == content
    assert first.is_symlink()


def test_packing_deletes_nothing_behind_a_link_among_the_marks_of_running_cells(store, home):
    store.running.mkdir()
    (store.running / "mark").symlink_to(home)
    pack(store)
    assert (home / "thesis.json").read_text() == "mine"


@pytest.mark.parametrize("name", ["records.parquet", "store.json", "sweeps.jsonl", "records/table.csv"])
def test_a_table_is_not_written_into_the_store_that_it_is_of(store, name):
    before = sorted(path.read_bytes() for path in store.path.rglob("*.json"))
    with pytest.raises(UsageError, match="a place of the results folder"):
        write_file(store.path / name, b"a table")
    assert sorted(path.read_bytes() for path in store.path.rglob("*.json")) == before


def test_a_line_that_a_crash_cut_short_breaks_no_later_one(store):
    store.log_sweep({"command": "first"})
    with (store.path / "sweeps.jsonl").open("a") as file:
        file.write('{"command": "cut sho')
    store.log_sweep({"command": "third"})
    assert [sweep["command"] for sweep in store.sweeps()] == ["first", "third"]
