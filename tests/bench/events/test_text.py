"""Tables in text files in which two things could be meant; tests/fuzz reads sound and broken ones of every form."""

import numpy as np
import pandas as pd
import pytest

import avobench
from avobench.bench.events import check_events, read_events, with_times
from avobench.tasks.errors import UsageError


def kept(folder, text):
    path = folder / "events.csv"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("energy\n1,234.5\n2\n", "line 2 has 2 cells and the columns are 1"),
        ('a,b\n"1,234.5",2\n1,3\n', "'a' does not hold one real number per event: line 2 has '1,234.5'"),
        ("a;b\n1,5;2\n2,5;2\noops;2\n", "'a' does not hold one real number per event: line 4 has 'oops'"),
        ("a;b\n1,5;2.5\n1,5;2\n", "decimal commas and others with points"),
        ("0,1\n1,2\n3,4\n", "may be names or an event"),
        ("a,a\n1,2\n", "two columns of the name 'a'"),
        ("a,b\n", "no event"),
    ],
)
def test_what_can_be_read_in_two_ways_is_refused(tmp_path, text, message):
    with pytest.raises(UsageError, match=message):
        read_events(kept(tmp_path, text))


def test_a_line_of_units_may_have_blanks_and_a_first_event_may_lack_its_number(tmp_path):
    for text, expected in (
        ("run;time;note\n;us;\n7;1,5;ok\n7;2,5;ok\n", [[1.5], [2.5]]),
        ("time,note\n,late\n1.5,ok\n2.5,ok\n", [[np.nan], [1.5], [2.5]]),
    ):
        np.testing.assert_array_equal(read_events(kept(tmp_path, text), ["time"]), expected)


def test_names_of_rows_that_r_writes_are_a_column_without_a_name(tmp_path):
    table = read_events(kept(tmp_path, '"a" "b"\n"1" 1.5 NA\n"2" 2.5 3\n'))
    assert list(table.columns) == ["", "a", "b"]
    np.testing.assert_array_equal(table, [[1, 1.5, np.nan], [2, 2.5, 3]])


def test_numbered_columns_are_no_event(tmp_path):
    pd.DataFrame([[1.5, 2.5], [3.5, 4.5]]).to_csv(tmp_path / "events.csv", index=False)
    np.testing.assert_array_equal(read_events(str(tmp_path / "events.csv")), [[1.5, 2.5], [3.5, 4.5]])


PRIOR = {"one": (1, 9), "two": (1, 9)}
TIMES = avobench.task(lambda theta, rng: rng.exponential(theta), prior=PRIOR, features=["t1", "t2"], name="times")
"""A simulator of two times with names."""


@pytest.mark.parametrize("names", [("t1", "t2"), ("T1 [us]", "t2"), ("t1 (ns)", "T2"), ("T1", " t_2")])
@pytest.mark.parametrize("timed", [False, True])
def test_names_say_which_column_is_which_feature_also_beside_a_time(names, timed):
    x = np.random.default_rng(0).exponential([5, 2], (300, 2))
    table = pd.DataFrame({names[1]: x[:, 1], "run": 7, names[0]: x[:, 0]})
    matched, told = check_events(TIMES, with_times(table, np.arange(300))[0] if timed else table)
    np.testing.assert_array_equal(matched, x)
    assert "run" in told[-1]
    assert all(f"{name} is taken as" in " ".join(told) for name in names if name not in TIMES.feature_names)


@pytest.mark.parametrize(
    ("columns", "message"),
    [(["t1", "u"], "have no t2"), (["a", "b", "c"], "3 columns: a, b, c"), (["t1"], "no t2"), (["T1", "u"], "no t2")],
)
def test_missing_features_are_named(columns, message):
    with pytest.raises(UsageError, match=message):
        check_events(TIMES, pd.DataFrame(np.ones((300, len(columns))), columns=columns))
