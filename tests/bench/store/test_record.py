"""What a record is: whatever makes no sense is noticed, whatever a cell may leave behind comes back as it was."""

import copy
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sound_records import sound_records

from avobench.bench.store.record import (
    IDENTITY,
    Record,
    check,
    decode_record,
    encode,
    fields_table,
    file_name,
    identity_hash,
)
from avobench.bench.store.status import ESTIMATED, LOST, Status
from avobench.bench.store.store import Store
from avobench.tasks.errors import UsageError

ROOT = Path(__file__).parents[3]
EXAMPLE = Store(ROOT / "results" / "bolfi-gpy").read_all()[0]
ok_records = sound_records([Status.OK])
known_records = sound_records([status for status in Status if status not in LOST])
negative = st.floats(max_value=0, exclude_max=True, allow_infinity=False)
patient = settings(deadline=None, max_examples=25)
lists = ("theta_true", "theta_hat", "mean", "std", "parameter_names")


def identified(record):
    return {**record, "id": identity_hash({name: record[name] for name in IDENTITY if name in record})}


def refused(record):
    with pytest.raises(ValueError, match=r"makes no sense|not finite"):
        decode_record(encode(record))


@patient
@given(sound_records())
def test_what_a_cell_may_leave_behind_comes_back_as_it_was(record):
    assert decode_record(encode(record)) == record
    assert list(decode_record(encode(record))) == list(record)


def test_the_committed_records_make_sense():
    folders = sorted(path.parent for path in (ROOT / "results").glob("*/store.json"))
    assert {"reference", "ablation", "bolfi-gpy", "studies", "smm"} <= {folder.name for folder in folders}
    for folder in folders:
        sound, damaged = Store(folder).read()
        assert sound
        assert not damaged


@patient
@given(sound_records(), st.data())
def test_a_field_of_another_type_or_a_missing_one_is_refused(record, data):
    name = data.draw(st.sampled_from(sorted(record)))
    wrong = data.draw(st.sampled_from([True, object, {"x": [1]}, [["x"]], [None, None, None, None]]))
    if wrong is object:
        del record[name]
    else:
        record[name] = wrong
    if name.endswith("_settings"):
        record = {**record, name: [1]}
    if wrong is object and name.endswith("_source_sha256"):
        name = "id"  # no such field is what a task within the package has, but then the id is another
    with pytest.raises(ValueError, match="makes no sense"):
        check(record)


@patient
@given(sound_records(), st.data())
def test_a_field_that_does_not_exist_is_refused(record, data):
    name = data.draw(
        st.text(st.characters(codec="ascii"), min_size=1).filter(lambda name: name not in Record.model_fields)
    )
    with pytest.raises(ValueError, match="makes no sense"):
        check({**record, name: None})


@patient
@given(ok_records, st.data())
def test_a_squared_error_other_than_the_distance_is_refused(record, data):
    other = data.draw(negative | st.just(record["squared_error"] * 1.000001 + 1e-300) | st.none())
    refused({**record, "squared_error": other})


@patient
@given(sound_records(), st.text(max_size=9).filter(lambda text: text not in list(Status)))
def test_an_unknown_status_is_refused(record, status):
    with pytest.raises(ValueError, match=r"makes no sense: status"):
        check({**record, "status": status})


@patient
@given(sound_records(), st.sampled_from(list(Status)))
def test_another_status_that_contradicts_the_estimate_is_refused(record, status):
    def kind(word):
        return word in ESTIMATED, word in LOST

    if kind(status) != kind(Status(record["status"])):
        refused({**record, "status": str(status)})


@patient
@given(
    known_records, st.integers(1, 2**40), st.sampled_from(["requested", "used", "discarded", "refused"]), st.booleans()
)
def test_numbers_of_simulations_that_do_not_add_up_are_refused(record, more, what, missing):
    name = f"simulations_{what}"
    if what == "discarded":
        refused({**record, name: None if missing else record["simulations_used"] + more})
    else:
        refused({**record, name: None if missing else record[name] + more})
    refused({**record, name: -more})


@patient
@given(known_records, st.integers(1, 2**40))
def test_more_simulations_than_the_budget_are_refused(record, more):
    used = record["budget"] + more
    counts = {"simulations_used": used, "simulations_requested": used + record["simulations_refused"]}
    refused(record | counts)


@patient
@given(ok_records, st.sampled_from(lists), st.booleans())
def test_another_number_of_parameters_is_refused(record, name, more):
    record[name] = [*record[name], record[name][0]] if more else record[name][1:]
    refused(identified(record))


@patient
@given(ok_records, st.sampled_from(["theta", "std"]), st.booleans())
def test_another_number_of_parameters_in_the_trace_is_refused(record, name, more):
    p = len(record["theta_true"]) + (1 if more else -1)
    point = {"simulations": 0, "theta": [0.0] * len(record["theta_true"]), "std": None} | {name: [0.0] * p}
    refused({**record, "trace": [point]})


@patient
@given(ok_records, st.integers(1, 2**40))
def test_a_trace_out_of_order_or_beyond_the_simulations_used_is_refused(record, more):
    point = {"theta": record["theta_hat"], "std": None}
    refused({**record, "trace": [{**point, "simulations": record["simulations_used"] + more}]})
    refused({**record, "trace": [{**point, "simulations": -more}]})
    if record["simulations_used"] > 0:
        numbers = (record["simulations_used"], 0)
        refused({**record, "trace": [{**point, "simulations": number} for number in numbers]})


@patient
@given(
    sound_records(),
    st.sampled_from(["floor", "floor_likelihood", "peak_memory_mib", "harness_seconds", "simulator_seconds"]),
    negative,
)
def test_what_cannot_be_negative_is_refused_where_it_is(record, name, value):
    refused({**record, name: value})


@patient
@given(sound_records(), st.sampled_from(IDENTITY), st.data())
def test_another_identity_than_that_of_the_id_is_refused(record, name, data):
    other = data.draw(sound_records())
    if record.get(name) != other.get(name):
        changed = copy.deepcopy(record)
        if name in other:
            changed[name] = other[name]
        else:
            del changed[name]
        refused(changed)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_a_number_that_is_not_finite_is_refused(number):
    content = encode({**EXAMPLE, "floor": 0.123456789}).decode().replace("0.123456789", number)
    with pytest.raises(ValueError, match="not finite"):
        decode_record(content.encode())


@patient
@given(sound_records(), st.sampled_from(["yesterday", "2026-11-21T20:40:54", "", "32"]))
def test_a_time_that_is_none_or_has_no_zone_is_refused(record, started):
    refused({**record, "started": started})


@patient
@given(st.binary())
def test_bytes_that_are_no_record_are_refused(content):
    with pytest.raises(ValueError, match=r"truncated|schema version"):
        decode_record(content)


@pytest.mark.parametrize("name", ["../../x", "/etc/passwd", "a/b", "", "..", ".hidden", "a\0b", "a\nb", "a\\b", "ä"])
@pytest.mark.parametrize("kind", ["task", "method"])
def test_a_name_that_could_lead_to_another_folder_is_refused(kind, name):
    record = identified({**EXAMPLE, kind: name})
    refused(record)
    with pytest.raises(UsageError, match=f"the name of a {kind} must be"):
        file_name(record)


def test_the_docs_have_the_fields_and_every_status():
    text = (ROOT / "docs" / "records.md").read_text()
    assert fields_table() in text
    assert all(f"| `{status}` |" in text or f"`{status}` exactly when" in text for status in Status)
