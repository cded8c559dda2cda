"""The command line as scripts use it: outputs, exit codes, one clear line for whatever goes wrong."""

import subprocess
import sys

import pandas as pd
import pytest

QUICK = ("run", "--task", "toys:Normal", "--method", "toys:Moment", "--targets", "0-1", "--budget", 400)
QUICK += ("--observations", 100, "--in-process")


@pytest.fixture
def results(done, tmp_path):
    path = tmp_path / "results"
    assert "2 of 2 cells ok" in done(*QUICK, "--results", path)
    return path


def test_run_shows_progress_and_a_summary_and_redraws_the_figure(avobench, tmp_path):
    code, out, err = avobench(*QUICK[:-1], "--jobs", 1, "--results", tmp_path / "r", "--figure", tmp_path / "f")
    assert code == 0
    assert (tmp_path / "f" / "benchmark.png").exists()
    assert "[1/2] normal moment target 0 repetition 0: squared error" in err
    assert "left" in err
    assert "median squared error" in out


def test_status_and_export_read_the_records(done, results, tmp_path):
    assert "normal" in done("status", "--results", results)
    for kind, read in (("csv", pd.read_csv), ("parquet", pd.read_parquet)):
        done("export", "--format", kind, "--out", file := tmp_path / f"table.{kind}", "--results", results)
        frame = read(file)
        assert list(frame["target"]) == [0, 1]
        assert ((frame["theta_hat_0"] - frame["theta_true_0"]) ** 2).to_numpy() == pytest.approx(frame["squared_error"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("run --task poison", "did you mean poisson?"),
        ("run --budget many", "--budget"),
        ("run --jobs -1", "--jobs must be at least 1"),
        ("run --repetitions 999999999999", "cells, and a run is"),
        ("run --set avo-paper.batch=3", "did you mean batch_size?"),
        ("run --colour", "--colour"),
        ("status --results nowhere", "there is no results folder"),
        ("report --results nowhere --out page", "there is no results folder"),
        ("run --results toys.py", "is a file"),
        ("run --results .", "holds other files"),
        ("run --figure toys.py", "is not a folder"),
        ("export --format csv --out toys.py/table.csv", "is not a folder"),
        ("export --format csv --out nowhere/table.csv", "there is no folder nowhere"),
        ("export --format xls --out table.xls", "xls"),
        ("figure benchmrk", "benchmrk"),
        ("nonsense", "nonsense"),
        ("diagnose --task poisson --table t.csv --time t --out out", "columns of --data"),
        ("list tasks --task poisson", "--task is for `avobench list effects`"),
        ("list --task poison", "did you mean poisson?"),
        ("list colours", "colours"),
        ("check effect dead_tme", "did you mean dead_time"),
        ("check effect images.dead_time", "or counts.dead_time"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(avobench, arguments, message):
    code, out, err = avobench(*arguments.split())
    assert (code, out) == (2, "")
    assert message in err
    assert err.startswith("avobench: ")
    assert err.count("\n") == 1


def test_failed_cells_are_exit_code_1_and_named_by_status(avobench, done, tmp_path):
    code, out, err = avobench(*QUICK, "--results", tmp_path / "r", "--set", "moment.fault=raises")
    assert code == 1
    assert "0 of 2 cells ok" in out
    assert "method_error: RuntimeError: lost the thread" in err
    assert "Traceback" not in err
    said = "normal moment target 0 repetition 0: method_error: RuntimeError: lost the thread"
    assert said in done("status", "--results", tmp_path / "r")


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


def test_a_packed_folder_is_read_as_before_by_every_command(avobench, done, results, tmp_path):
    def read():
        readers = ("status", f"export --format csv --out {tmp_path / 't.csv'}", f"figure benchmark --out {tmp_path}")
        printed = [done(*arguments.split(), "--results", results) for arguments in readers]
        return printed, {path.name: path.read_bytes() for path in tmp_path.glob("*.csv")}

    before, packed = read(), f"2 files packed, 2 records in {results / 'records.parquet'}\n"
    assert avobench("pack", "--results", results) == (0, packed, "")
    assert not (results / "records").exists()
    assert read() == before
    assert "2 of 2 cells ok" in done(*QUICK, "--results", results)
    assert not (results / "records").exists()
    assert done("pack", "--results", results).startswith("0 files packed, 2 records")


def test_debug_shows_where():
    command = [sys.executable, "-m", "avobench", "run", "--task", "poison"]
    plain, debug = (subprocess.run(command + more, capture_output=True, text=True) for more in ([], ["--debug"]))
    assert plain.returncode == 2
    assert "Traceback" not in plain.stderr
    assert "Traceback" in debug.stderr
    assert "UsageError" in debug.stderr
