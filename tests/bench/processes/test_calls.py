"""Calls in processes of their own: what they return or raise, and how they end, is told; nothing of them is left."""

import math
import os
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from avobench.bench.plugins import registry
from avobench.bench.processes.calls import Call, Fault, Limits, apart, kept, outcomes
from avobench.tasks.errors import UsageError

SECONDS = Limits(seconds=0.5)


def children():
    return set(psutil.Process().children(recursive=True))


def started(before):
    """The processes that this one has started since, but for one that Python keeps."""
    return {process for process in children() - before if "resource_tracker" not in " ".join(process.cmdline())}


def test_what_ends_a_process_costs_its_own_call_only():
    calls = [Call(math.sqrt, (1.0,)), Call(os._exit, (3,)), Call(os.abort, ()), Call(time.sleep, (60,), SECONDS)]
    calls += [Call(bytearray, (3 * 10**8,), Limits(mib=150)), Call(math.sqrt, (4.0,))]
    found = dict(outcomes(2, calls))
    assert [found[0], found[5]] == [1, 2]
    assert {place: (found[place].how, str(found[place])) for place in (1, 2, 3)} == {
        1: ("crashed", "the process ended itself, with exit code 3"),
        2: ("crashed", "the process was ended by SIGABRT"),
        3: ("timed_out", "ended after 0.5 s, the limit of time"),
    }
    assert found[4].how == "out_of_memory"
    assert str(found[4]).endswith("MiB of memory, the limit is 150 MiB")


def test_errors_of_avobench_arrive_as_they_are_and_others_as_faults():
    with pytest.raises(UsageError, match="there is no task named 'poison'; did you mean poisson"):
        apart(Call(registry.load, ("task", "poison")))
    with pytest.raises(Fault, match=r"ValueError: (math domain error|expected a nonneg)") as error:
        apart(Call(math.sqrt, (-1.0,)))
    assert "Traceback" in str(error.value.__cause__)
    with pytest.raises(Fault, match="pickle"):
        apart(Call(open, (os.devnull,)))


def test_processes_serve_one_call_after_another_and_none_is_left():
    with kept():
        first, second = (apart(Call(os.getpid, ())) for _ in range(2))
        assert first == second
        assert psutil.pid_exists(first)
    assert not psutil.pid_exists(first)
    third = apart(Call(os.getpid, ()))
    assert third != first
    assert not psutil.pid_exists(third)


def test_a_stopped_iteration_ends_what_is_running():
    before = children()
    calls = outcomes(2, [Call(os.getpid, ()), Call(time.sleep, (60,))])
    next(calls)
    start = time.monotonic()
    calls.close()
    assert time.monotonic() - start < 50  # and not the 60 seconds of the call
    assert not started(before)


def test_a_script_needs_no_guard_and_what_joblib_made_is_tidied_up(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import math, joblib\nfrom avobench.bench.processes.calls import *\nprint(apart(Call(math.sqrt, (9.0,))))\n"
        "print(apart_within(60, lambda: joblib.Parallel(2)([joblib.delayed(math.sqrt)(16.0)] * 2)))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "3.0\n[4.0, 4.0]\n", "")


def test_ctrl_c_does_not_reach_a_process_that_is_only_starting():
    with kept():
        calls = outcomes(1, [Call(math.sqrt, (4.0,))])
        before = children()

        def interrupt():
            while not (found := started(before)):
                pass
            for process in found:
                process.send_signal(signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        assert list(calls) == [(0, 2)]
        thread.join()


def test_a_file_that_is_called_like_a_module_of_python_is_not_taken_for_it(tmp_path, monkeypatch):
    (tmp_path / "random.py").write_text("raise SystemExit('this is no module of Python')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    assert apart(Call(os.getenv, ("PYTHONSAFEPATH",))) is None
