"""Records on disk: whole or not at all, damage noticed, schema kept."""

import json
from pathlib import Path

import pandas as pd
import pytest

from avobench.bench.plan import plan
from avobench.bench.store import Store, labels, to_frame, write_atomically
from avobench.bench.trial import execute
from avobench.tasks.errors import StoreError, UsageError


def records(methods=("toys:Moment",), budget=400, settings=(), targets="0-1"):
    cells = plan(["toys:Normal"], list(methods), targets, 1, budget, 100, 0, list(settings))
    return [execute(cell) for cell in cells]


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "results", create=True)


def test_what_is_written_is_read(store):
    written = records()
    for record in written:
        store.write(record)
    assert Store(store.path).read_all() == written


def test_one_line_of_pandas_reads_a_store(store):
    for record in records():
        store.write(record)
    frame = pd.DataFrame(json.loads(path.read_text()) for path in store.records.glob("*.json"))
    assert set(frame["target"]) == {0, 1}
    assert frame["squared_error"].dtype == float


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
    with pytest.raises(StoreError, match=bad.name):
        store.read_all()
    content = bad.read_text()
    assert store.set_aside(bad).read_text() == content
    assert store.read_all() == sound
    bad.write_text(content)
    assert store.set_aside(bad).name.endswith(".json.1")  # never over another file
    assert good.exists()


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


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to("file")
    write_atomically(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"new"


def test_folders_that_cannot_be_a_store_are_refused_in_one_line(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.tex").write_text("precious")
    newer = tmp_path / "newer"
    newer.mkdir()
    (newer / "store.json").write_text(json.dumps({"schema": "avobench-records", "version": 99}))
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "store.json").write_text("{")
    for path, message in [
        (file, "is a file"),
        (other, "holds other files"),
        (newer, "'version': 99"),
        (broken, "not readable as JSON"),
        (Path("/proc/avobench"), "cannot be used"),
        (file / "below", "cannot be used"),
    ]:
        with pytest.raises(UsageError, match=message):
            Store(path, create=True)
    with pytest.raises(UsageError, match="there is no results folder"):
        Store(tmp_path / "nowhere")
    assert not (tmp_path / "nowhere").exists()
    assert [path.name for path in other.iterdir()] == ["thesis.tex"]


def test_one_sweep_at_a_time(store):
    with store.lock(), pytest.raises(UsageError, match="another avobench run"):
        Store(store.path).lock()
    with store.lock():
        pass


def test_an_interrupted_write_leaves_the_old_content(tmp_path, monkeypatch):
    path = tmp_path / "file"
    write_atomically(path, b"old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("no space")))
    with pytest.raises(OSError, match="no space"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_table_has_a_row_a_cell_and_the_promised_columns():
    frame = to_frame([*records(), *records(settings=["moment.fault=raises"])])
    assert len(frame) == 4
    promised = "task method target repetition seed status message theta_true_0 theta_hat_0 squared_error floor"
    promised += " num_observations budget simulations_used simulator_seconds method_seconds"
    assert set(promised.split()) <= set(frame)
    assert frame.loc[frame["status"] != "ok", ["theta_hat_0", "squared_error"]].isna().all(axis=None)


def test_like_named_methods_of_other_settings_are_never_pooled():
    mixed = [*records(), *records(settings=["moment.steps=2"]), *records(budget=800)]
    tasks, methods = labels(mixed)
    assert methods == ["moment steps=4"] * 2 + ["moment steps=2"] * 2 + ["moment steps=4"] * 2
    assert tasks == ["normal budget=400"] * 4 + ["normal budget=800"] * 2
    assert labels(records()) == (["normal"] * 2, ["moment"] * 2)
