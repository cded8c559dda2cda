"""Packing: every record comes back as it was, and readers see no difference. Kills: tests/robustness."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sound_records import identified, sound_records

from avobench.bench.processes.local import LocalBackend
from avobench.bench.store import packed
from avobench.bench.store.packed import ROWS_A_GROUP, Row, read_rows, write_rows
from avobench.bench.store.record import file_name
from avobench.bench.store.store import DamagedRecord, Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import View, run
from avobench.tasks.errors import StoreError
from robustness.warm import start

REFERENCE = Store(Path(__file__).parents[3] / "results" / "reference")


@pytest.fixture(scope="module")
def kept():
    """A few committed records, among them ones with long traces."""
    return REFERENCE.read_all()[::60]


@pytest.fixture
def store(kept, tmp_path):
    store = Store(tmp_path / "store", create=True)
    for record in kept:
        store.write(record)
    return store


def files(store):
    return {path.name: path.read_bytes() for path in store.records.glob("*.json")}


def rows(store):
    return {row.file: row.text.encode() for row in read_rows(store.table)}


@given(st.lists(sound_records(), min_size=1, max_size=4, unique_by=file_name))
@settings(max_examples=15)
def test_any_record_comes_back_byte_for_byte(tmp_path_factory, records):
    store = Store(tmp_path_factory.mktemp("any") / "store", create=True)
    for record in records:
        store.write(record)
    written = files(store)
    store.pack()
    assert rows(store) == written
    assert store.read_all() == sorted(records, key=file_name)


def test_a_record_made_again_wins_over_its_row_and_is_folded_in(store, kept):
    written = files(store)
    store.pack()
    store.write(kept[0])  # in both places
    assert store.read_all() == kept
    store.pack()
    assert rows(store) == written
    again = {**kept[1], "message": "made again"}
    store.write(again)
    expected = [again if record["id"] == again["id"] else record for record in kept]
    assert store.read_all() == expected
    assert store.pack().folded == 1
    assert not files(store)
    assert store.read_all() == expected


def test_nothing_to_pack_is_said(tmp_path):
    with pytest.raises(StoreError, match="no records"):
        Store(tmp_path / "empty", create=True).pack()


def test_a_damaged_row_is_named_set_aside_and_kept_until_its_cell_is_made_again(store, kept):
    content, name = files(store), sorted(files(store))[1]
    store.pack()
    edited = content[name].replace(b'"squared_error": ', b'"squared_error": 1')
    write_rows(store.table, [Row(file, text.decode()) for file, text in (content | {name: edited}).items()])
    row = store.table / name
    sound, damaged = store.read()
    assert len(sound) == len(kept) - 1
    assert list(damaged) == [row]
    with pytest.warns(DamagedRecord, match=name):
        assert store.read_all() == sound
    assert list(store.pack().damaged) == [row]
    assert rows(store)[name] == edited
    for _ in range(2):  # the second time after a run that was stopped
        assert store.set_aside(row) == store.path / "damaged" / name
    assert (store.path / "damaged" / name).read_bytes() == edited
    store.write(next(record for record in kept if file_name(record) == name))
    assert store.read() == (kept, {})
    assert store.pack().damaged == {}
    assert store.read() == (kept, {})


def require_left(store, content, said):
    """Packing and a sweep refuse a table with this content, and leave it."""
    store.table.write_bytes(content)
    cells = plan(["toys:Normal"], ["toys:Moment"], "0", 1, 400, 100, 0, [])
    for refused in (Store.pack, lambda store: run(cells, store, LocalBackend(None, store.running), View())):
        with pytest.raises(StoreError, match=said):
            refused(store)
    assert store.table.read_bytes() == content


def test_a_table_cut_short_is_noticed_and_left(store):
    store.pack()
    whole = store.table.read_bytes()
    require_left(store, whole[: len(whole) // 2], "cannot be read")


def test_a_table_of_a_newer_version_is_left_and_said_to_be_newer(store, monkeypatch):
    with monkeypatch.context() as newer:
        newer.setitem(packed.SCHEMA, "version", "2")
        store.pack()
    sound, damaged = store.read()
    assert (sound, list(damaged)) == ([], [store.table])
    require_left(store, store.table.read_bytes(), "version 2, and 1 is known here; use the avobench that wrote it")


def test_damage_in_one_part_of_the_table_leaves_the_rest(tmp_path):
    store, record = Store(tmp_path, create=True), REFERENCE.read_all()[0]
    for number in range(2 * ROWS_A_GROUP):
        store.write(identified({**record, "repetition": number}))
    store.pack()
    content = bytearray(store.table.read_bytes())
    place = content.index(b"repetition", len(content) // 2) // 4  # well within the first group
    content[place : place + 50] = bytes(50)
    store.table.write_bytes(content)
    sound, damaged = store.read()
    assert len(sound) == ROWS_A_GROUP
    assert f"{ROWS_A_GROUP} of {2 * ROWS_A_GROUP} rows can be read" in damaged[store.table]


@pytest.mark.parametrize("name", ["/precious.json", "../precious.json", "..", "", "a/b.json"])
def test_a_row_whose_name_leads_elsewhere_is_damage_of_the_table(store, name):
    content = next(iter(files(store).values())).decode()
    write_rows(store.table, [Row(name, content)])
    sound, damaged = store.read()
    assert sound == Store(store.path).read()[0]
    assert list(damaged) == [store.table]
    with pytest.raises(StoreError, match="would not lie in"):
        store.pack()


def test_a_table_that_is_not_read_back_as_written_replaces_nothing(store, monkeypatch):
    written = files(store)
    monkeypatch.setattr("avobench.bench.store.packed.read_rows", lambda path: iter([Row("x", "y")]))
    with pytest.raises(StoreError, match="could not be packed"):
        store.pack()
    assert files(store) == written
    assert not store.table.exists()
    assert not list(store.path.glob(".*.tmp"))


def test_a_reader_beside_the_packing_sees_every_record(store, kept):
    packing, reads = start(["pack", "--results", str(store.path)]), 0
    while packing.process.is_alive():
        assert store.read() == (kept, {})
        reads += 1
    assert packing.end().code == 0
    assert reads
    assert not files(store)
