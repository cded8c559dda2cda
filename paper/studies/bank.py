"""Hidden effects and nothing hidden, diagnosed from a bank: `python -m paper.studies.bank CHALLENGE... --out FILE`.

A challenge is a folder of `avobench challenge make`; the ones of `results/bank` are made by

    avobench challenge make --task T --cases 12 --seed 71 --events 20000 --kinds foreign --shapes shapes:SEEN --out T
    avobench challenge make --task T --cases 20 --seed 72 --events 20000 --kinds none --out T-null
    avobench challenge make --task T --cases 20 --seed 73 --events 1000 --kinds none --out T-null-1000

for poisson, weinberg and carl. The search before was run in a checkout of 4c8d801. `--per-event 20` sets a limit of 20
simulated events for each measured one, and of 20 000 at least. One JSON line per data set is added to FILE; those that
it has are left alone.
"""

import json
import time
from pathlib import Path
from typing import Any

import click

from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.diagnosis import diagnose
from avobench.diagnosis.checks import Checks
from avobench.tasks.errors import UsageError

FOLDER = Path("results/bank")
LEAST = 20_000
"""Simulated events that a diagnosis is allowed, at least."""


def diagnosed(folder: Path, number: int, answers: dict[str, Any], per_event: float | None) -> dict[str, Any]:
    """What a diagnosis says of one data set, and what it took; or with what words it refused a limit."""
    began, answer = time.process_time(), answers["cases"][number]
    task = registry.build("task", answers["task"], {})
    x = read_events(str(folder / "data" / f"{answer['case']}.npz"))
    limit = None if per_event is None else max(int(per_event * len(x)), LEAST)
    checks = Checks(task, len(x), limit, seed=number)
    x, _ = checks.events(x)
    row = {"data": folder.name, "case": number, "truth": sorted(effect["name"] for effect in answer["effects"])}
    try:
        said = diagnose(
            task, x, seed=number, num_simulations=limit, effects=checks.entries(), bank=checks.bank
        ).diagnosis
    except UsageError as refused:
        return row | {"refused": str(refused)}
    return row | {
        "named": sorted(effect.name for effect in said.effects),
        "models": [sorted(effect.name for effect in model.effects) for model in said.models],
        "p_value": said.p_value_before,
        "calls_per_event": round(said.num_simulations / answers["num_events"], 2),
        "seconds": round(time.process_time() - began, 1),
    }


@click.command()
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="File of JSON lines.")
@click.option("--per-event", type=click.FloatRange(min=1), help="Simulated events for each measured one, at most.")
def main(folders: tuple[Path, ...], out: Path, per_event: float | None) -> None:
    """Diagnose each data set of the challenges that FILE does not have."""
    have = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
    done = {(row["data"], row["case"]) for row in have}
    for folder in folders:
        answers = json.loads((folder / "answers.json").read_text())
        for number in range(len(answers["cases"])):
            if (folder.name, number) not in done:
                with out.open("a") as file:
                    file.write(json.dumps(diagnosed(folder, number, answers, per_event)) + "\n")


if __name__ == "__main__":
    main()
