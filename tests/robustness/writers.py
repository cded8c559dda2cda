"""Several writers of one store: `python -m robustness.writers` prints who was refused and that nothing was mixed.

Two sweeps of the same cells and a `pack` are started within the time that one of them takes, on a file system whose
locks work, one that refuses every lock (ENOLCK), one that has none (ENOSYS), and one that grants every lock and holds
none, as network file systems may. Each command must either do its work or be refused in one line, and whatever the
order, no record may be lost, halved or doubled; a sweep afterwards must end as an undisturbed one.
"""

import errno
import json
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import click

from robustness import faults, warm
from robustness.preload import GRANTED, Faults, compiled, run_with

LOCKS = {"that work": 0, "refused": errno.ENOLCK, "not there": errno.ENOSYS, "granted, not held": GRANTED}
"""What the file system does about locks."""
SWEEP = ["run", "--task", "toys:Normal", "--method", "toys:Moment", "--budget", "400", "--observations", "100"]
SWEEP += ["--targets", "0-7", "--set", "moment.pause=0.01"]


def one_round(template: Path, folder: Path, locks: int, moments: random.Random, calm: Any, took: float) -> list[str]:
    """What became of the two sweeps and the `pack`. Raises AssertionError for anything else than done or refused."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    before = faults.kept(folder)
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
    found = faults.kept(folder)
    lost = [name for name, content in before.items() if found.get(name) != content]
    assert not lost, f"lost {lost}"
    assert faults.call(sweep).code == 0
    assert faults.call(["pack", "--results", str(folder)]).code == 0
    assert faults.results(folder) == calm, "not as an undisturbed sweep"
    left = [path.name for path in folder.glob("**/.*.tmp")]
    assert not left, f"{left} left"
    return outcomes


def campaign(place: Path, rounds: int, seed: int) -> dict[str, dict[str, int]]:
    template, calm = place / "template", place / "calm"
    assert faults.call([*SWEEP[:-3], "0-1", *SWEEP[-2:], *faults.in_process(), "--results", str(template)]).code == 0
    shutil.copytree(template, calm)
    begun = time.monotonic()
    assert faults.call([*SWEEP, *faults.in_process(), "--results", str(calm)]).code == 0
    took, expected = time.monotonic() - begun, faults.results(calm)
    found = {}
    for name, locks in LOCKS.items():
        moments, outcomes = random.Random(seed), Counter()
        for _ in range(rounds):
            outcomes.update(one_round(template, place / "store", locks, moments, expected, took))
        found[name] = dict(outcomes)
    return found


@click.command()
@click.option("--rounds", default=25, show_default=True, help="Of two sweeps and two packs, for each kind of lock.")
@click.option("--seed", default=0, show_default=True)
@click.option("--place", type=click.Path(path_type=Path), default=None, hidden=True)
def main(rounds: int, seed: int, place: Path | None) -> None:
    """Let several commands write to one store at a time, and print what became of each."""
    if place is not None:  # the process whose locks are as told
        warm.environment()
        import avobench.bench.cells.trial
        import avobench.bench.store.pack
        import avobench.cli.records
        import avobench.cli.run  # noqa: F401

        click.echo(json.dumps(campaign(place, rounds, seed)))
        return
    with tempfile.TemporaryDirectory() as folder:
        warm.environment()
        own = ["--rounds", str(rounds), "--seed", str(seed), "--place", folder]
        process = run_with(compiled(Path(folder)), ["-m", "robustness.writers", *own])
    if process.returncode:
        click.echo(process.stderr, err=True)
        sys.exit(1)
    found = json.loads(process.stdout.splitlines()[-1])
    kinds = ("run done", "run refused", "pack done", "pack refused")
    click.echo("".join([f"{'locks':20}", *(f"{kind:>14}" for kind in kinds)]))
    for name, outcomes in found.items():
        click.echo("".join([f"{name:20}", *(f"{outcomes.get(kind, 0):14}" for kind in kinds)]))
    click.echo(f"{rounds * len(found)} rounds: nothing lost, nothing mixed")


if __name__ == "__main__":
    main()
