"""Reading measured events, and what is told about bad ones."""

import warnings
from contextlib import nullcontext
from functools import partial

import numpy as np
import pandas as pd
import pytest
import uproot
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from avobench.bench.events import check_events, read_events, read_timed, with_times
from avobench.bench.events.checks import NUM_REFERENCE, num_repeated, reference
from avobench.tasks.carl import Carl
from avobench.tasks.checked import checked_events
from avobench.tasks.errors import SimulatorError, UsageError
from avobench.tasks.function import task as task_of
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


def simulate(task, n=1000, seed=0):
    rng = np.random.default_rng(seed)
    return task.simulate(np.tile(task.prior.center, (n, 1)), rng)


def to_root(path, frame):
    with uproot.recreate(path) as file:
        file["folder/events"] = frame.to_dict("series")


WRITE = {
    "npy": np.save,
    "npz": np.savez_compressed,
    "csv": lambda path, frame: frame.to_csv(path, index=False),
    "parquet": lambda path, frame: frame.to_parquet(path),
    "root": to_root,
}


def write(folder, kind, x, names):
    """Where events (n, d) are read from, in a file of this kind."""
    WRITE[kind](path := folder / f"events.{kind}", pd.DataFrame(x, columns=names))
    return f"{path}:folder/events" if kind == "root" else str(path)


@pytest.mark.parametrize("kind", WRITE)
@pytest.mark.parametrize("task", [Poisson(), Carl()], ids=lambda task: task.name)
def test_every_format_gives_back_the_events(tmp_path, kind, task):
    x = simulate(task)
    read = np.asarray(read_events(write(tmp_path, kind, x, [f"b{i}" for i in range(x.shape[1])])))
    np.testing.assert_allclose(read, x, rtol=1e-15)
    assert np.issubdtype(read.dtype, np.integer) == np.issubdtype(x.dtype, np.integer)


@pytest.mark.parametrize("kind", ["csv", "parquet", "root"])
def test_columns_are_chosen_in_the_order_asked_for(tmp_path, kind):
    source = write(tmp_path, kind, np.arange(12.0).reshape(4, 3), ["a", "b", "c"])
    np.testing.assert_array_equal(read_events(source, ["c", "a"]), [[2, 0], [5, 3], [8, 6], [11, 9]])
    with pytest.raises(UsageError, match="has no d; it has: a, b, c"):
        read_events(source, ["d"])


def test_arrays_of_an_npz_are_columns_by_name(tmp_path):
    path = tmp_path / "events.npz"
    np.savez(path, a=np.arange(3.0), b=np.ones(3))
    np.testing.assert_array_equal(read_events(str(path), ["b", "a"]), [[1, 0], [1, 1], [1, 2]])
    with pytest.raises(UsageError, match="choose by --columns: a, b"):
        read_events(str(path))


def test_one_dimension_is_one_feature_and_images_are_flattened(tmp_path):
    np.save(tmp_path / "line.npy", np.arange(5))
    np.save(tmp_path / "images.npy", np.arange(24).reshape(2, 3, 4))
    assert read_events(str(tmp_path / "line.npy")).shape == (5, 1)
    np.testing.assert_array_equal(read_events(str(tmp_path / "images.npy"))[1], np.arange(12, 24))


def test_pickled_files_are_refused_and_run_nothing(tmp_path):
    class Trap:
        def __reduce__(self):
            return (pytest.fail, ("unpickled",))

    np.save(tmp_path / "objects.npy", np.array([Trap()], object), allow_pickle=True)
    np.array([1.0]).dump(tmp_path / "pickle.npy")
    for name in ("objects.npy", "pickle.npy"):
        with pytest.raises(UsageError, match="pickled"):
            read_events(str(tmp_path / name))


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.npy", None, "there is no file"),
        ("events.doc", b"1 2", "events are read from"),
        ("events.npy", b"", "cannot be read"),
        ("events.npz", b"PK\x03\x04broken", "cannot be read"),
        ("events.parquet", b"PAR1", "cannot be read"),
        ("events.csv", b"", "is empty"),
        ("events.csv", b"\xff\xfe1", "not a text in UTF-8"),
        ("events.csv", b"a,b\n\n1,x\n", "'b' does not hold one real number per event: line 3 has 'x'"),
        ("events.root", b"root", "needs the name of a tree"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(UsageError, match=message) as caught:
        read_events(str(tmp_path / name))
    assert name in str(caught.value)


def test_root_trees_and_branches_are_checked(tmp_path):
    source = write(tmp_path, "root", np.ones((3, 1)), ["a"])
    with pytest.raises(UsageError, match="has no tree 'other'; it has: folder/events"):
        read_events(source.replace("folder/events", "other"))
    (tmp_path / "broken.root").write_bytes(b"root0000")
    with pytest.raises(UsageError, match="cannot be read"):
        read_events(f"{tmp_path / 'broken.root'}:events")


@pytest.mark.parametrize("task", [Poisson(), Weinberg(), Carl()], ids=lambda task: task.name)
def test_sound_events_pass_without_a_warning(task):
    x = simulate(task, 50_000)
    checked, warnings = check_events(task, x)
    assert warnings == []
    np.testing.assert_array_equal(checked, x)
    assert checked.dtype == task.dtype


@settings(max_examples=20)
@given(st.integers(1, 799), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_rows_that_are_not_finite_are_counted_and_refused_or_dropped(count, bad):
    x = simulate(Carl())
    x[:count, 2] = bad
    with pytest.raises(UsageError, match=f"{count} of 1000 rows hold NaN or infinite values"):
        check_events(Carl(), x)
    checked, warnings = check_events(Carl(), x, drop_invalid=True)
    np.testing.assert_array_equal(checked, x[count:])
    assert warnings == [f"{count} of 1000 rows hold NaN or infinite values and were dropped"]


@pytest.mark.parametrize(("task", "other"), [(Carl(), int), (Poisson(), float)], ids=["whole", "fractions"])
def test_numbers_of_the_other_type_are_taken_if_they_are_whole(task, other):
    """Real numbers too, since rounding is an effect."""
    x = np.rint(simulate(task)).astype(other)
    taken, remarks = check_events(task, x)
    assert taken.dtype == task.dtype
    np.testing.assert_array_equal(taken, x)
    assert not any("outside" in remark for remark in remarks)


def test_a_count_beside_real_numbers_must_be_whole():
    def both(theta, rng):
        return np.column_stack([rng.normal(theta[:, 0]), rng.poisson(7, len(theta))])

    mixed = task_of(both, prior={"mean": (0, 3)}, features=["energy", "hits"], kinds={"hits": "count"})
    x = simulate(mixed)
    assert check_events(mixed, x)[1] == []
    x[:3, 1] += 0.5
    with pytest.raises(UsageError, match="makes whole numbers of hits, 3 of 1000 rows hold fractions"):
        check_events(mixed, x)


@pytest.mark.parametrize(("task", "value"), [(Poisson(), -1), (Weinberg(), 1.01), (Weinberg(), -2), (Carl(), -999)])
def test_values_that_the_simulator_never_makes_are_counted(task, value):
    x = simulate(task)
    x[:7, -1] = value
    _, warnings = check_events(task, x)
    name = (task.feature_names or [f"x{i + 1}" for i in range(5)])[-1]
    assert len([text for text in warnings if text.startswith(f"7 values of {name} lie outside")]) == 1


FAMILIES = {
    "exponential": lambda theta, rng: rng.exponential(theta[:, 0]),
    "power": lambda theta, rng: rng.pareto(theta[:, 0]),
    "lognormal": lambda theta, rng: np.exp(theta[:, 0] * rng.standard_normal(len(theta))),
    "two-sided": lambda theta, rng: theta[:, 0] * rng.standard_cauchy(len(theta)),
    "narrow": lambda theta, rng: theta[:, 0] + rng.normal(0, 0.01, len(theta)),
    "counts": lambda theta, rng: rng.poisson(theta[:, 0]),
    "cosine": lambda theta, rng: np.cos(rng.uniform(0, np.pi / theta[:, 0], len(theta))),
}


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("at", [1.0, 2.5, 4.0])
def test_what_the_simulator_made_does_not_lie_outside_of_where_it_makes_events(name, at):
    """Ten sets are made at a theta in or at an end of the prior; each may be told once in a hundred times."""
    made = task_of(FAMILIES[name], prior={"theta": (1, 4)}, name=name)
    rng = np.random.default_rng(7)
    known = reference(made, partial(checked_events, made), NUM_REFERENCE)
    sets = [made.simulate(np.full((100_000, 1), at), rng) for _ in range(10)]
    told = ["lie outside" in " ".join(check_events(made, x, diagnosis=False, made=lambda: known)[1]) for x in sets]
    assert sum(told) <= binom.isf(1e-3, 10, 0.01)


def test_repeated_events_are_told_where_values_are_continuous():
    x = np.round(simulate(Weinberg()), 2)
    assert any("of 1000 events repeat" in text for text in check_events(Weinberg(), x)[1])
    assert check_events(Poisson(), np.tile(simulate(Poisson(), 500), (2, 1)))[1] == []


def test_a_few_absurd_counts_are_told_and_taken():
    x = np.r_[np.random.default_rng(0).poisson(7, (499, 1)), [[10**15]]]
    taken, remarks = check_events(Poisson(), x)
    assert taken.max() == 10**15
    assert "1 values of" in remarks[0]


def test_an_inference_takes_any_number_of_events():
    assert len(check_events(Poisson(), np.ones((2_000_001, 1), np.int8), diagnosis=False)[0]) == 2_000_001


THREE = task_of(
    lambda theta, rng: rng.normal(theta[:, [0] * 3]), prior={"m": (-1, 1)}, features=["f0", "f1", "f2"], name="three"
)


def with_column(values):
    return np.c_[np.random.default_rng(0).normal(size=(300, 2)), np.full(300, values)]


@pytest.mark.parametrize(
    ("task", "x", "message"),
    [
        (Carl(), simulate(Weinberg()), "has 5 columns, the data have 1"),
        (Weinberg(), simulate(Weinberg(), 199), "199 events are too few, at least 200"),
        (Weinberg(), np.empty((0, 1)), "0 events are too few, at least 200"),
        (Poisson(), simulate(Weinberg()), "1000 of 1000 rows hold fractions"),
        (Poisson(), np.full((500, 1), 2**64 - 1, np.uint64), r"beyond 2\^53"),
        (Poisson(), np.full((500, 1), -(2**60)), r"beyond 2\^53"),
        (Poisson(), np.full((500, 1), 10**15), "another quantity, or in another unit"),
        (Poisson(), np.random.default_rng(0).integers(0, 10**9, (500, 1)), "another quantity, or in another unit"),
        (Poisson(), np.full((500, 1), 7), "all values of .* are 7; a diagnosis needs values that differ"),
        (THREE, with_column(0.5), r"all values of f2 are 0\.5; a diagnosis needs values that differ"),
        (THREE, with_column(0.0) * 1e-301, "too little for single precision; give another unit"),
        (THREE, with_column(0.0) * 1e-25, "all values of f0 are .* are they in another unit"),
        (THREE, with_column(1e301), r"reach to 1e\+301, beyond 2\^53"),
        (THREE, with_column(np.nan), "all values of f2 are NaN or infinite; choose a column"),
        (THREE, with_column(-np.inf), "all values of f2 are NaN or infinite; choose a column"),
        (THREE, np.full((300, 3), np.nan), "all values of f0, f1, f2 are NaN or infinite"),
    ],
)
@pytest.mark.parametrize("drop_invalid", [False, True])
def test_what_makes_a_diagnosis_meaningless_is_refused_in_a_line(task, x, message, drop_invalid):
    with warnings.catch_warnings(action="error"), pytest.raises(UsageError, match=message) as caught:
        check_events(task, x, drop_invalid=drop_invalid)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dtype", [np.int64, np.float64, np.uint8])
def test_repeated_events_are_counted_by_a_number_for_each(dtype):
    x = np.random.default_rng(0).integers(0, 12, (3000, 3)).astype(dtype)
    assert num_repeated(x) == 3000 - len(np.unique(x, axis=0))
    assert num_repeated(np.array([[0.0, 1.0], [-0.0, 1.0], [1.0, 0.0]])) == 1


def test_a_column_is_the_time_and_no_feature(tmp_path):
    path = str(tmp_path / "events.csv")
    pd.DataFrame({"a": [0, 3, 6], "when": [0.5, 1.5, 2.5], "c": [2, 5, 8]}).to_csv(path, index=False)
    for columns, expected in ((None, [[0, 2], [3, 5], [6, 8]]), (["c", "when"], [[2], [5], [8]])):
        x, when = read_timed(path, columns, "when")
        np.testing.assert_array_equal(x, expected)
        np.testing.assert_array_equal(when, [0.5, 1.5, 2.5])
    with pytest.raises(UsageError, match="has no day; it has: a, when, c"):
        read_timed(path, None, "day")
    np.savez(tmp_path / "images.npz", x=np.zeros((3, 2, 2)), when=np.arange(3))
    x, when = read_timed(str(tmp_path / "images.npz"), None, "when")
    assert (x.shape, when.tolist()) == ((3, 4), [0, 1, 2])
    np.save(tmp_path / "line.npy", np.zeros(3))
    with pytest.raises(UsageError, match="have no names to choose from"):
        read_timed(str(tmp_path / "line.npy"), None, "when")


@pytest.mark.parametrize(
    "dates", [["2012-07-04", "2012-07-04T09:00", ""], ["2012-07-04T02:00+02:00", "2012-07-04T09:00Z", ""]]
)
def test_dates_become_seconds(tmp_path, dates):
    """Nine hours apart, in UTC where no zone is named; a missing one is none."""
    path = tmp_path / "dated.csv"
    pd.DataFrame({"a": [1.0, 2.0, 3.0], "when": dates}).to_csv(path, index=False)
    _, when = read_timed(str(path), None, "when")
    assert when[:2] == pytest.approx([1341360000, 1341360000 + 9 * 3600])
    assert np.isnan(when[2])
    path.write_text("a,when\n1,noon\n2,dusk\n")
    with pytest.raises(UsageError, match="'when' holds neither a number nor a date such as"):
        read_timed(str(path), None, "when")


def test_dates_of_an_array_are_times():
    x, dates = np.arange(3.0)[:, None], np.array(["2012-07-04", "2012-07-05", "2012-07-07"], "datetime64[s]")
    assert np.diff(with_times(x, dates)[1]).tolist() == [86400, 2 * 86400]


def test_events_without_a_time_go_and_those_without_a_value_are_left_to_their_task():
    x, time = np.array([[0.0], [1.0], [np.nan], [3.0]]), np.array([0.0, np.nan, 2.0, 3.0])
    kept, when, told = with_times(x, time, drop_invalid=True)
    np.testing.assert_array_equal(kept[:, 0], [0, np.nan, 3])
    assert when.tolist() == [0, 2, 3]
    assert told == ["1 of 4 times are NaN or infinite, and their events were dropped"]
    for wrong, said in (
        (time, "1 of 4 times are NaN or infinite; mend them"),
        (time[:3], "one number for each of 4 events"),
        (np.ones(4), "all times are equal"),
    ):
        with pytest.raises(UsageError, match=said):
            with_times(x, wrong)


BROKEN = {
    "makes the same events in each call": lambda theta, rng: np.random.default_rng(1).normal(theta[:, 0]),
    "depend on the parameters of the first row": lambda theta, rng: rng.normal(theta[0, 0], 1, len(theta)),
    "masked values": lambda theta, rng: np.ma.masked_less(rng.normal(theta[:, 0]), 0),
    "complex numbers": lambda theta, rng: rng.normal(theta[:, 0]) + 1j,
    "makes 7 for every value of x1": lambda theta, rng: np.full(len(theta), 7.0),
}


@pytest.mark.parametrize(("message", "simulator"), BROKEN.items(), ids=BROKEN)
def test_a_simulator_that_breaks_the_contract_is_told_before_anything_is_inferred(message, simulator):
    with pytest.raises((SimulatorError, UsageError), match=message):
        check_events(task_of(simulator, prior={"mean": (0, 3)}, name="toy"), np.random.default_rng(0).normal(1, 1, 300))


@pytest.mark.parametrize("parameters", [1, 2])
@pytest.mark.parametrize("seeded", [True, False])
def test_a_program_of_one_theta_with_a_seed_of_its_own_is_told(parameters, seeded):
    def program(theta, n, rng):
        return (np.random.default_rng(1) if seeded else rng).normal(theta.sum(), 1, n)

    prior = {name: (0, 3) for name in "ab"[:parameters]}
    task, x = task_of(program, prior=prior, per_theta=True), np.random.default_rng(0).normal(2, 1, 300)
    with pytest.raises(SimulatorError, match="same events in each call") if seeded else nullcontext():
        check_events(task, x)


@pytest.mark.parametrize("made", [list, lambda hit: pd.DataFrame({"hit": hit})])
def test_truth_values_are_said_to_be_taken_as_numbers(made):
    trigger = task_of(lambda theta, rng: rng.random(len(theta)) < theta[:, 0], prior={"share": (0, 1)})
    x, told = check_events(trigger, made(np.arange(300) % 3 == 0), diagnosis=False)
    assert x[:3].ravel().tolist() == [1, 0, 0]
    assert "truth values are taken as 0 and 1" in told


def test_labels_are_names_too_and_other_names_are_taken_in_order_and_said_so():
    two = task_of(lambda theta, rng: rng.normal(theta), prior={"a": (-5, 5), "b": (-5, 5)}, name="two")
    x = np.arange(400.0).reshape(200, 2)
    swapped, told = check_events(two, pd.DataFrame({"x2": x[:, 1], "x1": x[:, 0]}) / 100)
    np.testing.assert_array_equal(swapped, x / 100)
    for names in (["q", "p"], [1, 0]):
        taken, told = check_events(two, pd.DataFrame(x / 100, columns=names))
        np.testing.assert_array_equal(taken, x / 100)
        assert f"{names[0]}, {names[1]} are taken as x1, x2, in this order" in told[0]
    assert not any("in this order" in said for said in check_events(two, pd.DataFrame(x / 100))[1])


def test_masked_events_are_refused_and_a_mask_of_none_is_not():
    x = np.ma.masked_array(np.random.default_rng(0).normal(1, 1, 300), mask=False)
    one = task_of(lambda theta, rng: rng.normal(theta), prior={"a": (-5, 5)}, name="one")
    assert len(check_events(one, x)[0]) == 300
    x[3:5] = np.ma.masked
    with pytest.raises(UsageError, match="2 values of the events are masked"):
        check_events(one, x)


def test_a_diagnosis_refuses_copies_and_a_fit_says_so():
    one = task_of(lambda theta, rng: rng.exponential(theta), prior={"tau": (1, 4)}, name="decay")
    x = np.repeat(np.random.default_rng(3).exponential(2, 500), 2)
    with pytest.raises(UsageError, match=r"500 of 1000 events repeat .* drop the copies"):
        check_events(one, x)
    assert "500 of 1000 events repeat" in check_events(one, x, diagnosis=False)[1][0]
