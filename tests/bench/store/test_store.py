"""Records on disk: whole or not at all, damage noticed, schema kept."""

import hashlib
import json

import pytest
from sound_records import identified

from avobench.bench.cells.trial import execute
from avobench.bench.processes.local import LocalBackend
from avobench.bench.store.record import file_name
from avobench.bench.store.store import DamagedRecord, Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import View, run
from avobench.tasks.errors import StoreError, UsageError


def cells():
    return plan(["toys:Normal"], ["toys:Moment"], "0-1", 1, 400, 100, 0, [])


def records():
    return [execute(cell) for cell in cells()]


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "results", create=True)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text[: len(text) // 2], "truncated"),
        (lambda text: "", "truncated"),
        (lambda text: "[1, 2]", "truncated or not a record"),
        (lambda text: text.replace('"status": "ok"', '"status": "OK"'), "checksum"),
        (lambda text: text.replace('"schema_version": 1', '"schema_version": 99'), "schema version 99"),
    ],
)
def test_a_damaged_record_is_named_and_set_aside_whole(store, damage, message):
    good, bad = (store.write(record) for record in records())
    bad.write_text(damage(bad.read_text()))
    sound, damaged = store.read()
    assert len(sound) == 1
    assert list(damaged) == [bad]
    assert message in damaged[bad]
    with pytest.warns(DamagedRecord, match=bad.name):
        assert store.read_all() == sound
    content = bad.read_text()
    assert store.set_aside(bad).read_text() == content
    assert store.read_all() == sound
    bad.write_text(content)
    assert store.set_aside(bad).name.endswith(".json.1")  # never over another file
    assert good.exists()


def nested(depth):
    return {"x": nested(depth - 1)} if depth else {}


FAR = {"theta_true": [0.0, 0.0], "theta_hat": [1.2e154, 1.2e154], "mean": [0.0, 0.0], "std": [1.0, 1.0], "trace": []}
FAR |= {"squared_error": 1e308, "parameter_names": ["a", "b"]}  # a sum of squares that is beyond all floats


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"squared_error": -1.0}, "makes no sense: squared_error"),
        ({"message": "lost \udcff"}, "half of a surrogate pair"),
        ({"method_settings": {"\ud800": 1}}, "half of a surrogate pair"),
        ({"task_settings": nested(900)}, "lists and objects in one another"),
        ({"task_source_sha256": None}, "makes no sense: task_source_sha256"),
        ({"amortised": None}, "makes no sense: amortised"),
        (FAR, "makes no sense: squared_error"),
    ],
)
def test_a_record_that_no_reader_could_use_is_damaged_though_its_checksum_is_right_and_is_not_written(
    store, change, message
):
    good, bad = records()
    store.write(good)
    bad = identified({**bad, **change})
    checksum = hashlib.sha256(json.dumps(bad, sort_keys=True).encode()).hexdigest()
    path = store.records / file_name(bad)
    path.write_text(json.dumps({**bad, "sha256": checksum}))
    for _ in range(2):
        sound, damaged = store.read()
        assert sound == [good]
        assert message in damaged[path]
        store.pack()
    with pytest.raises(StoreError, match=message):
        store.write(bad)


def test_a_store_without_a_sound_record_says_so(store):
    store.write(records()[0]).write_text("{")
    with pytest.warns(DamagedRecord), pytest.raises(StoreError, match="no sound records"):
        store.read_all()


def test_a_name_that_leads_elsewhere_is_told_before_anything_is_made(store):
    first, second = cells()
    second.identity["task"] = "../../x"  # as a file of a model could say
    backend = LocalBackend(None, store.running)
    with pytest.raises(UsageError, match=r"name of a task must be .* got '\.\./\.\./x'"):
        run([first, second], store, backend, View())
    assert [path.name for path in store.path.rglob("*.json")] == ["store.json"]


def test_a_copy_of_a_record_is_not_counted_twice(store):
    path = store.write(records()[0])
    copy = path.with_name(path.name.replace("t00", "t05"))
    copy.write_bytes(path.read_bytes())
    sound, damaged = store.read()
    assert len(sound) == 1
    assert "is a copy of" in damaged[copy]


def test_a_store_whose_making_was_killed_is_finished_by_the_next(tmp_path):
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / ".abc.tmp").write_text("{")
    Store(tmp_path / "new", create=True).write(records()[0])
    assert len(Store(tmp_path / "new").read_all()) == 1


def test_folders_that_cannot_be_a_store_are_refused_in_one_line(tmp_path):
    newer = json.dumps({"schema": "avobench-records", "version": 99})
    for folder, name, content, message in [
        (".", "file", "", "holds other files"),
        ("other", "thesis.tex", "precious", "holds other files"),
        ("newer", "store.json", newer, "'version': 99"),
        ("broken", "store.json", "{", "not readable as JSON"),
    ]:
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / name).write_text(content)
        with pytest.raises(UsageError, match=message):
            Store(tmp_path / folder, create=True)
        assert [path.name for path in (tmp_path / folder).iterdir()] == [name]
    for path, message in (
        ("file", "is a file"),
        ("/proc/avobench", "cannot be used"),
        ("file/below", "cannot be used"),
    ):
        with pytest.raises(UsageError, match=message):
            Store(tmp_path / path, create=True)
    with pytest.raises(UsageError, match="there is no results folder"):
        Store(tmp_path / "nowhere")
    assert not (tmp_path / "nowhere").exists()
