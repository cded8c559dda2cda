"""The command line as scripts use it: outputs, exit codes, one clear line for whatever goes wrong."""

import subprocess
import sys

import pandas as pd
import pytest

QUICK = ("run", "--task", "toys:Normal", "--method", "toys:Moment", "--targets", "0-1", "--budget", 400)
QUICK += ("--observations", 100, "--in-process")


@pytest.fixture
def results(avobench, tmp_path):
    path = tmp_path / "results"
    code, out, err = avobench(*QUICK, "--results", path)
    assert code == 0, err
    assert "2 of 2 cells ok" in out
    return path


def test_run_shows_progress_and_a_summary(avobench, tmp_path):
    code, out, err = avobench(*QUICK[:-1], "--jobs", 1, "--results", tmp_path / "r")
    assert code == 0
    assert "[1/2] normal moment target 0 repetition 0: squared error" in err
    assert "left" in err
    assert "median squared error" in out


def test_status_and_export_read_the_records(avobench, results, tmp_path):
    code, out, _ = avobench("status", "--results", results)
    assert code == 0
    assert "normal" in out
    for kind, read in (("csv", pd.read_csv), ("parquet", pd.read_parquet)):
        file = tmp_path / f"table.{kind}"
        code, out, _ = avobench("export", "--format", kind, "--out", file, "--results", results)
        assert code == 0
        frame = read(file)
        assert list(frame["target"]) == [0, 1]
        assert ((frame["theta_hat_0"] - frame["theta_true_0"]) ** 2).to_numpy() == pytest.approx(frame["squared_error"])


def test_run_redraws_the_figure(avobench, tmp_path):
    code, _, _ = avobench(*QUICK, "--results", tmp_path / "r", "--figure", tmp_path / "f")
    assert code == 0
    assert (tmp_path / "f" / "benchmark.png").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["run", "--task", "poison"], 2, "did you mean poisson?"),
        (["run", "--budget", "many"], 2, "--budget"),
        (["run", "--jobs", "-1"], 2, "--jobs must be at least 1"),
        (["run", "--repetitions", "9" * 12], 2, "cells, and a run is"),
        (["run", "--set", "avo-paper.batch=3"], 2, "did you mean batch_size?"),
        (["run", "--colour"], 2, "--colour"),
        (["status", "--results", "nowhere"], 2, "there is no results folder"),
        (["run", "--results", "toys.py"], 2, "is a file"),
        (["run", "--results", "."], 2, "holds other files"),
        (["run", "--figure", "toys.py"], 2, "is not a folder"),
        (["export", "--format", "csv", "--out", "toys.py/table.csv"], 2, "is not a folder"),
        (["export", "--format", "csv", "--out", "nowhere/table.csv"], 2, "there is no folder nowhere"),
        (["export", "--format", "xls", "--out", "table.xls"], 2, "xls"),
        (["figure", "benchmrk"], 2, "benchmrk"),
        (["nonsense"], 2, "nonsense"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(avobench, arguments, code, message):
    found, out, err = avobench(*arguments)
    assert found == code
    assert message in err
    assert err.startswith("avobench: ")
    assert err.count("\n") == 1
    assert not out


def test_failed_cells_are_exit_code_1_and_named_by_status(avobench, tmp_path):
    code, out, err = avobench(*QUICK, "--results", tmp_path / "r", "--set", "moment.fault=raises")
    assert code == 1
    assert "0 of 2 cells ok" in out
    assert "method_error: RuntimeError: lost the thread" in err
    assert "Traceback" not in err
    code, out, _ = avobench("status", "--results", tmp_path / "r")
    assert code == 0
    assert "normal moment target 0 repetition 0: method_error: RuntimeError: lost the thread" in out


def test_a_damaged_record_is_named_by_every_reader(avobench, results, tmp_path):
    damaged = sorted((results / "records").iterdir())[0]
    damaged.write_text(damaged.read_text().replace("normal", "norml"))
    for arguments, expected in (
        (["status"], "normal"),
        (["export", "--format", "csv", "--out", tmp_path / "t.csv"], "1 rows in"),
        (["figure", "benchmark", "coverage", "--out", tmp_path], "benchmark.csv"),
        (["report", "--out", tmp_path], "index.html"),
        (["pack"], "1 files packed, 1 records"),
    ):
        code, out, err = avobench(*arguments, "--results", results)
        assert code == 1
        assert expected in out
        assert err.startswith("avobench: ")
        assert damaged.name in err
        assert "was changed after it was written" in err
        assert err.count("\n") == 1
    assert pd.read_csv(tmp_path / "t.csv")["target"].tolist() == [1]
    assert pd.read_csv(tmp_path / "benchmark.csv")["cells"].tolist() == [1]


def test_a_packed_folder_is_read_as_before_by_every_command(avobench, results, tmp_path):
    readers = [
        ["status"],
        ["export", "--format", "csv", "--out", tmp_path / "t.csv"],
        ["figure", "benchmark", "--out", tmp_path],
    ]

    def read():
        printed = [avobench(*arguments, "--results", results) for arguments in readers]
        assert [code for code, _, _ in printed] == [0] * len(readers)
        return printed, {path.name: path.read_bytes() for path in tmp_path.glob("*.csv")}

    before = read()
    code, out, err = avobench("pack", "--results", results)
    assert (code, err) == (0, "")
    assert out == f"2 files packed, 2 records in {results / 'records.parquet'}\n"
    assert not (results / "records").exists()
    assert read() == before
    code, out, err = avobench(*QUICK, "--results", results)
    assert code == 0
    assert "2 of 2 cells ok" in out
    assert not (results / "records").exists()
    code, out, _ = avobench("pack", "--results", results)
    assert code == 0
    assert out.startswith("0 files packed, 2 records")


def test_debug_shows_where():
    command = [sys.executable, "-m", "avobench", "run", "--task", "poison"]
    plain, debug = (subprocess.run(command + more, capture_output=True, text=True) for more in ([], ["--debug"]))
    assert plain.returncode == 2
    assert "Traceback" not in plain.stderr
    assert "Traceback" in debug.stderr
    assert "UsageError" in debug.stderr
