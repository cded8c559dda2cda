"""Code of a user's that ends, hangs or fills its process: told in a line or a record, and nothing else is lost."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from avobench.bench.store.store import Store
from avobench.cli import main

CELLS = ("--method", "hostile:Steps", "--targets", "0-1", "--budget", 160, "--observations", 100)


def run(avobench, folder, *more):
    code, out, err = avobench("run", *CELLS, "--results", folder, *more)
    return code, out, err, {(r["task"], r["target"]): r for r in Store(folder).read_all()}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_simulator_that_ends_its_process_at_its_first_call_costs_its_own_cells(avobench, tmp_path, jobs):
    tasks = [argument for name in ("Segfault", "Leaves") for argument in ("--task", f"hostile:{name}")]
    code, out, err, found = run(avobench, tmp_path / "r", *tasks, "--task", "faulty:SoundTask", "--jobs", jobs)
    assert code == 1, err
    assert "2 of 6 cells ok" in out
    ends = {
        "sound": ("ok", ""),
        "segfault": ("crashed", "the process was ended by SIGSEGV (2 times)"),
        "leaves": ("crashed", "the process ended itself, with exit code 0 (2 times)"),
    }
    for (task, _), record in found.items():
        assert (record["status"], record["message"]) == ends[task]
    assert "Warning" not in err


def test_a_cell_that_hangs_or_leaks_is_a_record_with_its_reason(avobench, tmp_path):
    sound, expected = ("--task", "faulty:SoundTask", "--targets", 0, "--jobs", 2), {"sound": "ok"}
    for task, limit, status, said in (
        ("Leaks", ("--memory-limit", 400), "out_of_memory", "the limit is 400 MiB"),
        ("Hangs", ("--time-limit", 4), "timed_out", "ended after 4 s, the limit of time"),
    ):
        code, _, err, found = run(avobench, tmp_path / "r", "--task", f"hostile:{task}", *sound, *limit)
        assert code == 1, err
        expected[task.lower()] = status
        assert {name: record["status"] for (name, _), record in found.items()} == expected
        assert said in found[task.lower(), 0]["message"]


def test_a_task_that_ends_the_process_where_its_targets_are_asked_for_is_refused_in_a_line(avobench, tmp_path):
    code, out, err = avobench("run", *CELLS, "--task", "hostile:NoTargets", "--results", tmp_path / "r")
    assert (code, out) == (2, "")
    assert err == ("avobench: hostile:NoTargets, hostile:Steps: cannot be used: the process was ended by SIGSEGV\n")
    assert not (tmp_path / "r").exists()


def line(found, code, word):
    assert found[0] == code
    assert word in found[2]
    assert found[2].startswith("avobench: ")
    assert found[2].count("\n") == 1


def test_checks_end_with_a_line(avobench):
    line(avobench("check", "task", "hostile:Segfault"), 1, "hostile:Segfault: the process was ended by SIGSEGV")
    line(avobench("check", "method", "hostile:EndsItself"), 1, "ended itself, with exit code 0")
    line(avobench("check", "effect", "hostile:Fatal"), 1, "hostile:Fatal: the process was ended by SIGSEGV")


def test_infer_and_diagnose_end_with_a_line_and_write_nothing(avobench, tmp_path):
    np.save(tmp_path / "x.npy", np.random.default_rng(0).normal(size=(300, 1)))
    np.save(tmp_path / "n.npy", np.random.default_rng(0).poisson(7, (300, 1)))
    start = ("--data", tmp_path / "x.npy", "--out", tmp_path / "o.json", "--task")
    line(avobench("infer", *start, "hostile:Segfault", "--method", "faulty:SoundMethod"), 1, "SIGSEGV")
    assert not (tmp_path / "o.json").exists()
    start = ("--task", "poisson", "--data", tmp_path / "n.npy", "--out", tmp_path / "d")
    line(avobench("diagnose", *start, "--effect", "hostile:Fatal"), 1, "SIGSEGV")
    assert not list((tmp_path / "d").iterdir())


@pytest.mark.parametrize("command", ["infer --method smm --task", "diagnose --out d --task", "check task"])
def test_what_hangs_is_ended_after_so_many_seconds(avobench, tmp_path, monkeypatch, command):
    path = os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.chdir(tmp_path)
    np.save("x.npy", np.random.default_rng(0).normal(size=(300, 1)))
    data = () if command == "check task" else ("--data", "x.npy")
    found = avobench(*command.split(), "hostile:Stuck", *data, "--seconds", 0.5)
    line(found, 1, "hostile:Stuck: ended after 0.5 s, the limit of time")


def test_what_a_method_says_is_text_on_the_terminal(avobench, tmp_path):
    start = (*CELLS, "--method", "dirty:Dirty", "--set", "dirty.how=screen", "--task", "faulty:SoundTask", "--jobs", 1)
    for command in (("run", *start), ("status",)):
        _, out, err = avobench(*command, "--results", tmp_path / "r")
        assert r"\x1b[2J" in out + err
        assert not set("\x1b\x07\x9b\r\u202e") & set(out + err)


def test_a_closed_output_is_no_fault(tmp_path):
    cells = " ".join(map(str, (*CELLS, "--task", "faulty:SoundTask", "--jobs", 1, "--results", tmp_path / "r")))
    done = subprocess.run(f"{sys.executable} -m avobench run {cells} <&- >&-", shell=True, stderr=-1, text=True)
    assert (done.returncode, "NoneType" in done.stderr) == (0, False), done.stderr
    assert len(Store(tmp_path / "r").read_all()) == 2


def test_an_estimate_without_simulations_must_say_why(avobench, tmp_path):
    start = ("run", "--task", "faulty:SoundTask", "--method", "hostile:Guesses", "--method", "hostile:Says")
    start += ("--targets", 0, "--budget", 400, "--observations", 100, "--results", tmp_path / "r", "--jobs", 1)
    code, _, err = avobench(*start)
    assert code == 1, err
    found = {record["method"]: record["status"] for record in Store(tmp_path / "r").read_all()}
    assert found == {"guesses": "invalid_estimate", "says": "ok"}


def test_a_device_that_is_not_there_is_refused_before_anything_is_simulated(avobench, tmp_path):
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is a GPU")
    start = ("run", "--task", "faulty:SoundTask", "--method", "hostile:OnDevice", "--results", tmp_path / "r")
    for device in (("--device", "cuda"), ("--set", "on-device.device=cuda")):
        line(avobench(*start, *device, "--in-process"), 2, "PyTorch finds no CUDA device")
    assert not (tmp_path / "r").exists()


def test_cells_are_in_this_process_where_that_is_asked_for(avobench, tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.bench.processes.calls._Process", None)
    code, _, err, found = run(avobench, tmp_path / "r", "--task", "faulty:SoundTask", "--in-process")
    assert code == 0, err
    assert len(found) == 2


def test_foreign_code_runs_only_where_it_is_trusted(avobench, tmp_path):
    """A model names a task of a user's, whose module leaves a file when it is imported."""
    path, marker = tmp_path / "model.json", tmp_path / "imported"
    own = f"import pathlib\nfrom faulty import SoundTask as Own\npathlib.Path({str(marker)!r}).touch()\n"
    (tmp_path / "own.py").write_text(own)
    parameter = {"name": "location", "unit": "1", "value": 0.0, "std": 1.0, "prior": [-1, 1], "support": [-9, 9]}
    content = {"name": "own-model", "task": f"{tmp_path / 'own.py'}:Own", "task_settings": {}, "effects": []}
    path.write_text(json.dumps(content | {"parameters": [parameter]}))
    np.save(tmp_path / "x.npy", np.random.default_rng(0).normal(size=(300, 1)))
    data = ("--data", tmp_path / "x.npy")
    commands = {
        "run": ("run", *CELLS, "--results", tmp_path / "r", "--task", path),
        "infer": ("infer", *data, "--method", "faulty:SoundMethod", "--budget", 400, "--task", path),
        "check": ("check", "task", path),
        "list": ("list", "effects", "--task", path),
    }
    for command in commands.values():
        line(avobench(*command, "--in-process"), 2, "(--trust, ")
        assert not marker.exists()
    for name in ("run", "list"):
        avobench(*commands[name], "--trust")
        assert marker.exists(), name
        marker.unlink()


def stopped(begun, *arguments):
    """What a command says that gets Ctrl-C while it works, once the folder `begun` is there."""
    command = [sys.executable, "-m", "avobench", *map(str, arguments)]
    process = subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120
    while not begun.exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    time.sleep(0.5)
    for _ in range(4):  # as an impatient user does
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.1)
    _, error = process.communicate(timeout=120)
    return process.returncode, error


def test_ctrl_c_promises_only_what_is_kept(tmp_path):
    np.save(tmp_path / "x.npy", np.random.default_rng(0).poisson(7, (20_000, 1)))
    command = ("diagnose", "--task", "poisson", "--data", tmp_path / "x.npy", "--out", tmp_path / "d")
    code, error = stopped(command[-1], *command)
    assert code in (130, -signal.SIGINT), error  # a shell says 130 of both
    assert error.splitlines()[-1] == "avobench: stopped; nothing was kept, and the same command starts again"
    assert "Traceback" not in error
    assert not list((tmp_path / "d").glob("*"))


def test_ctrl_c_ends_what_does_not_stop_after_a_while():
    script = "import signal, time; from avobench.cli import state as of; state = of.State()\n"
    script += "of.STOPPING_SECONDS = 0.2; signal.signal(signal.SIGINT, state.interrupt)\n"
    script += "while True:\n try:\n  print(flush=True)\n  time.sleep(60)\n except KeyboardInterrupt: pass"
    with subprocess.Popen([sys.executable, "-c", script], stdout=-1, stderr=-1, text=True) as process:
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        process.stdout.readline()
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 130
        assert process.stderr.read() == "avobench: stopped; nothing was kept, and the same command starts again\n"


def test_ctrl_c_is_a_stop_whatever_a_library_makes_of_it(monkeypatch, capsys):
    def loads(work):
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("numpy.core.multiarray failed to import") from None

    monkeypatch.setattr(main, "naming_damaged", loads)
    monkeypatch.setattr(sys, "argv", ["avobench", "list"])
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit) as left:
        main.main()
    signal.signal(signal.SIGINT, before)
    assert left.value.code == 130
    assert capsys.readouterr().err == "avobench: stopped; nothing was kept, and the same command starts again\n"


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("c/manifest.json", ("challenge", "solve", "c")),
        ("d.toml", ("infer", "--joint", "d.toml")),
        ("r/store.json", ("status", "--results", "r")),
        ("b/bank.json", ("infer", "--task", "poisson", "--data", "x.csv", "--method", "smm", "--bank", "b")),
        ("m/model.json", ("infer", "--task", "m/model.json", "--data", "x.csv", "--method", "smm")),
    ],
)
def test_a_file_of_lists_in_lists_in_lists_is_told_in_a_line(avobench, tmp_path, monkeypatch, name, arguments):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("a=" * name.endswith("toml") + "[" * 100_000)
    (tmp_path / "x.csv").write_text("x\n" + "1\n" * 300)
    code, out, err = avobench(*arguments)
    assert (code > 0, out, err.count("\n")) == (True, "", 1)
    assert path.name in err
