"""What a record is: whatever makes no sense is noticed, whatever a cell may leave behind comes back as it was."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sound_records import identified, sound_records

from avobench.bench.store.record import IDENTITY, Record, check, decode_record, encode, file_name
from avobench.bench.store.status import ESTIMATED, LOST, Status
from avobench.bench.store.store import Store
from avobench.tasks.errors import UsageError

EXAMPLE = Store(Path(__file__).parents[3] / "results" / "bolfi-gpy").read_all()[0]
ok_records = sound_records([Status.OK])
known_records = sound_records([status for status in Status if status not in LOST])
negative = st.floats(max_value=0, exclude_max=True, allow_infinity=False)
patient = settings(max_examples=25)
more = st.integers(1, 2**40)


def refused(record):
    with pytest.raises(ValueError, match=r"makes no sense|not finite"):
        decode_record(encode(record))


@patient
@given(sound_records())
def test_what_a_cell_may_leave_behind_comes_back_as_it_was(record):
    assert decode_record(encode(record)) == record
    assert list(decode_record(encode(record))) == list(record)


@patient
@given(sound_records(), st.data())
def test_a_field_of_another_type_a_missing_or_an_unknown_one_is_refused(record, data):
    unknown = data.draw(st.text(min_size=1).filter(lambda name: name not in Record.model_fields))
    with pytest.raises(ValueError, match="makes no sense"):
        check({**record, unknown: None})
    name = data.draw(st.sampled_from(sorted(record.keys() - {"amortised"})))  # of which one value is right, or none
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


def another_squared_error(record, draw):
    other = draw(negative | st.just(record["squared_error"] * 1.000001 + 1e-300) | st.none())
    return {"squared_error": other}


def counts_that_do_not_add_up(record, draw):
    name = draw(st.sampled_from(["requested", "used", "discarded", "refused"]))
    least = record["simulations_used" if name == "discarded" else f"simulations_{name}"]
    return {f"simulations_{name}": draw(more.map(least.__add__) | st.none() | more.map(int.__neg__))}


def more_than_the_budget(record, draw):
    used = record["budget"] + draw(more)
    return {"simulations_used": used, "simulations_requested": used + record["simulations_refused"]}


def another_number_of_parameters(record, draw):
    name = draw(st.sampled_from(["theta_true", "theta_hat", "mean", "std", "parameter_names"]))
    return {name: [*record[name], record[name][0]] if draw(st.booleans()) else record[name][1:]}


def another_number_of_parameters_in_the_trace(record, draw):
    p = len(record["theta_true"])
    other = {draw(st.sampled_from(["theta", "std"])): [0.0] * (p + draw(st.sampled_from([1, -1])))}
    return {"trace": [{"simulations": 0, "theta": [0.0] * p, "std": None} | other]}


def a_trace_out_of_order_or_beyond(record, draw):
    used, point = record["simulations_used"], {"theta": record["theta_hat"], "std": None}
    numbers = [(used + draw(more),), (-draw(more),), *([(used, 0)] if used > 0 else [])]
    return {"trace": [{**point, "simulations": number} for number in draw(st.sampled_from(numbers))]}


def negative_where_nothing_is(record, draw):
    names = ("floor", "floor_likelihood", "peak_memory_mib", "harness_seconds", "simulator_seconds")
    return {draw(st.sampled_from(names)): draw(negative)}


def no_time_or_one_without_zone(record, draw):
    return {"started": draw(st.sampled_from(["yesterday", "2026-11-21T20:40:54", "", "32"]))}


CONTRADICTIONS = {
    another_squared_error: ok_records,
    counts_that_do_not_add_up: known_records,
    more_than_the_budget: known_records,
    another_number_of_parameters: ok_records,
    another_number_of_parameters_in_the_trace: ok_records,
    a_trace_out_of_order_or_beyond: ok_records,
    negative_where_nothing_is: sound_records(),
    no_time_or_one_without_zone: sound_records(),
}


@pytest.mark.parametrize("change", CONTRADICTIONS, ids=lambda change: change.__name__)
@patient
@given(st.data())
def test_what_contradicts_the_rest_is_refused(change, data):
    record = data.draw(CONTRADICTIONS[change])
    refused(identified({**record, **change(record, data.draw)}))


@patient
@given(sound_records(), st.sampled_from([*Status, "", "OK", "okay"]))
def test_a_status_that_is_none_or_contradicts_the_estimate_is_refused(record, status):
    def kind(word):
        return word in ESTIMATED, word in LOST

    if status not in list(Status) or kind(status) != kind(Status(record["status"])):
        refused({**record, "status": str(status)})


@patient
@given(sound_records(), st.sampled_from(IDENTITY), st.data())
def test_another_identity_than_that_of_the_id_is_refused(record, name, data):
    other = data.draw(sound_records())
    if record.get(name) != other.get(name):
        without = {key: value for key, value in record.items() if key != name}
        refused(without | ({name: other[name]} if name in other else {}))


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_a_number_that_is_not_finite_is_refused(number):
    content = encode({**EXAMPLE, "floor": 0.123456789}).decode().replace("0.123456789", number)
    with pytest.raises(ValueError, match="not finite"):
        decode_record(content.encode())


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
