"""Files are written where they belong, also where a name of a results folder leads to a user's own, or to a pipe."""

import os
from pathlib import Path

import pytest

from avobench.bench.store.files import within, write_atomically, write_file
from avobench.bench.store.store import NAMES, Store
from avobench.tasks.errors import UsageError
from fuzz.answers import Stores

REFERENCE = Store(Path(__file__).parents[3] / "results" / "bolfi-gpy")


@pytest.fixture
def store(tmp_path):
    """A store with two records as files."""
    made = Store(tmp_path / "store", create=True)
    for record in REFERENCE.read_all()[:2]:
        made.write(record)
    return made


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["folder", "file", "dangling", "pipe"])
def test_no_name_of_a_store_may_lead_out_of_it(name, kind, tmp_path):
    assert Stores(tmp_path).check(({name: kind}, "status")) == "refused"


def test_packing_deletes_nothing_behind_a_link_among_the_marks_of_running_cells(tmp_path):
    assert Stores(tmp_path).check(({"running/mark": "folder"}, "pack")) == "taken"


def test_a_record_that_is_a_link_or_a_pipe_is_told_and_left(store, tmp_path):
    first, second = sorted(store.records.iterdir())
    first.rename(tmp_path / "record.json")
    first.symlink_to(tmp_path / "record.json")
    second.unlink()
    os.mkfifo(second)
    sound, damaged = store.read()
    assert sound == []
    assert ["link" in damaged[first], "neither a file" in damaged[second]] == [True, True]
    assert store.pack().rows == 0
    assert first.is_symlink()
    assert (tmp_path / "record.json").exists()


@pytest.mark.parametrize("name", ["records.parquet", "store.json", "sweeps.jsonl", "records/table.csv"])
def test_a_table_is_not_written_into_the_store_that_it_is_of(store, name):
    before = store.read()
    with pytest.raises(UsageError, match="a place of the results folder"):
        write_file(store.path / name, b"a table")
    assert store.read() == before


def test_a_line_that_a_crash_cut_short_breaks_no_later_one(store):
    store.log_sweep({"command": "first"})
    with (store.path / "sweeps.jsonl").open("a") as file:
        file.write('{"command": "cut sho')
    store.log_sweep({"command": "third"})
    assert [sweep["command"] for sweep in store.sweeps()] == ["first", "third"]


def test_a_link_stays_a_link(tmp_path):
    (link := tmp_path / "link").symlink_to("file")
    write_atomically(link, b"new")
    assert link.is_symlink()
    assert (tmp_path / "file").read_bytes() == b"new"


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "", ".", "..", "a\0b", "a\\b", "a/../b"])
def test_a_name_that_leads_to_another_folder_is_refused(name):
    with pytest.raises(UsageError, match="would not lie in"):
        within(Path("folder"), name)
    assert within(Path("folder"), "x.json") == Path("folder/x.json")
