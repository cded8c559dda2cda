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
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from robustness.kills import finished_records, lost_records, steady_records
from robustness.preload import GRANTED, Faults
from robustness.warm import SWEEP, calmly, start

LOCKS = {"that work": 0, "refused": errno.ENOLCK, "not there": errno.ENOSYS, "granted, not held": GRANTED}
"""What the file system does about locks."""
RUN = [*SWEEP, "--in-process", "--targets", "0-7", "--set", "moment.pause=0.01"]


@contextmanager
def granted(folder: Path, locks: int) -> Iterator[None]:
    """Within the block the file system does so about locks below a folder."""
    faults = Faults()
    faults.root(folder)
    faults.set(locks=locks)
    yield


def one_round(template: Path, folder: Path, locks: int, moments: random.Random, calm: Any, took: float) -> list[str]:
    """What became of the two sweeps and the `pack`. Raises AssertionError for anything else than done or refused."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    before = finished_records(folder)
    sweep = [*RUN, "--results", str(folder)]
    commands = [sweep, sweep, ["pack", "--results", str(folder)], ["pack", "--results", str(folder)]]
    moments.shuffle(commands)
    started = []
    for arguments in commands:
        started.append((arguments[0], start(arguments, partial(granted, folder, locks))))
        time.sleep(moments.uniform(0, took / 3))
    outcomes = []
    for name, command in started:
        ended = command.end()
        if ended.code == 0:
            outcomes.append(f"{name} done")
            continue
        assert ended.code == 2, f"{name}: exit code {ended.code}: {ended.err}"
        assert ended.err.count("\n") == 1, ended.err
        assert "another avobench run" in ended.err, ended.err
        outcomes.append(f"{name} refused")
    lost = lost_records(before, finished_records(folder))
    assert not lost, f"lost {lost}"
    calmly(sweep)
    calmly(["pack", "--results", str(folder)])
    assert steady_records(folder) == calm, "not as an undisturbed sweep"
    left = [path.name for path in folder.glob("**/.*.tmp")]
    assert not left, f"{left} left"
    return outcomes


def campaign(place: Path, rounds: int) -> dict[str, dict[str, int]]:
    template, calm = place / "template", place / "calm"
    calmly([*RUN, "--targets", "0-1", "--results", str(template)])
    shutil.copytree(template, calm)
    begun = time.monotonic()
    calmly([*RUN, "--results", str(calm)])
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
