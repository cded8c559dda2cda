"""Several writers of one store.

Two sweeps of the same cells and a `pack` are started within the time that one of them takes, on a file system whose
locks work, one that refuses every lock (ENOLCK), one that has none (ENOSYS), and one that grants every lock and holds
none, as network file systems may. Each command must either do its work or be refused in one line, and whatever the
order, no record may be lost, halved or doubled; a sweep afterwards must end as an undisturbed one.
"""

import errno
import random
import shutil
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd

from robustness import faults
from robustness.kills import finished_records, steady_records
from robustness.preload import GRANTED, Faults

LOCKS = {"that work": 0, "refused": errno.ENOLCK, "not there": errno.ENOSYS, "granted, not held": GRANTED}
"""What the file system does about locks."""
SWEEP = ["run", "--task", "toys:Normal", "--method", "toys:Moment", "--budget", "400", "--observations", "100"]
SWEEP += ["--targets", "0-7", "--set", "moment.pause=0.01"]


def one_round(template: Path, folder: Path, locks: int, moments: random.Random, calm: Any, took: float) -> list[str]:
    """What became of the two sweeps and the `pack`. Raises AssertionError for anything else than done or refused."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    before = finished_records(folder)
    switch = Faults()

    def set_up() -> None:
        switch.root(folder)
        switch.set(locks=locks)

    sweep = [*SWEEP, *faults.in_process(), "--results", str(folder)]
    commands = [sweep, sweep, ["pack", "--results", str(folder)], ["pack", "--results", str(folder)]]
    moments.shuffle(commands)
    started = []
    for arguments in commands:
        started.append((arguments[0], faults.start(arguments, set_up)))
        time.sleep(moments.uniform(0, took / 3))
    outcomes = []
    for name, command in started:
        ended = faults.end(command)
        if ended.code == 0:
            outcomes.append(f"{name} done")
            continue
        assert ended.code == 2, f"{name}: exit code {ended.code}: {ended.err}"
        assert ended.err.count("\n") == 1, ended.err
        assert "another avobench run" in ended.err, ended.err
        outcomes.append(f"{name} refused")
    found = finished_records(folder)
    lost = [name for name, content in before.items() if found.get(name) != content]
    assert not lost, f"lost {lost}"
    assert faults.call(sweep).code == 0
    assert faults.call(["pack", "--results", str(folder)]).code == 0
    assert steady_records(folder) == calm, "not as an undisturbed sweep"
    left = [path.name for path in folder.glob("**/.*.tmp")]
    assert not left, f"{left} left"
    return outcomes


def campaign(place: Path, rounds: int) -> dict[str, dict[str, int]]:
    template, calm = place / "template", place / "calm"
    assert faults.call([*SWEEP[:-3], "0-1", *SWEEP[-2:], *faults.in_process(), "--results", str(template)]).code == 0
    shutil.copytree(template, calm)
    begun = time.monotonic()
    assert faults.call([*SWEEP, *faults.in_process(), "--results", str(calm)]).code == 0
    took, expected = time.monotonic() - begun, steady_records(calm)
    found = {}
    for name, locks in LOCKS.items():
        moments, outcomes = random.Random(0), Counter()
        for _ in range(rounds):
            outcomes.update(one_round(template, place / "store", locks, moments, expected, took))
        found[name] = dict(outcomes)
    return found


def table(found: dict[str, dict[str, int]]) -> str:
    """What became of the sweeps and packs, a line a kind of lock."""
    told = pd.DataFrame(found).T.fillna(0).astype(int)
    return f"{told.to_string()}\n{told.to_numpy().sum() // 4} rounds: nothing lost, nothing mixed"
