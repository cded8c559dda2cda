"""Hidden effects and nothing hidden, diagnosed from a bank: `python -m paper.studies.bank CHALLENGE... --out FILE`.

A challenge is a folder of `avobench challenge make`; the ones of `results/bank` are made by

    avobench challenge make --task T --cases 12 --seed 71 --events 20000 --kinds foreign --shapes shapes:SEEN --out T
    avobench challenge make --task T --cases 20 --seed 72 --events 20000 --kinds none --out T-null
    avobench challenge make --task T --cases 20 --seed 73 --events 1000 --kinds none --out T-null-1000
    avobench challenge make --task T --cases 40 --seed 74 --events 5000 --kinds none --out T-null-5000

for poisson, weinberg and carl. The search before was run in a checkout of 4c8d801. One JSON line per data set is added
to FILE; those that it has are left alone.
"""

import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import click

from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.diagnosis import diagnose
from avobench.diagnosis.checks import Checks
from paper.studies.files import add_lines

FOLDER = Path("results/bank")


def diagnosed(folder: Path, number: int, answers: dict[str, Any]) -> dict[str, Any]:
    """What a diagnosis says of one data set, and what it took."""
    began, answer = time.process_time(), answers["cases"][number]
    task = registry.build("task", answers["task"], {})
    x = read_events(str(folder / "data" / f"{answer['case']}.npz"))
    checks = Checks(task, len(x), seed=number)
    x, _ = checks.events(x)
    said = diagnose(task, x, seed=number, effects=checks.entries(), bank=checks.bank).diagnosis
    return {
        "data": folder.name,
        "case": number,
        "truth": sorted(effect["name"] for effect in answer["effects"]),
        "named": sorted(effect.name for effect in said.effects),
        "models": [sorted(effect.name for effect in model.effects) for model in said.models],
        "p_value": said.p_value_before,
        "calls_per_event": round(said.num_simulations / answers["num_events"], 2),
        "seconds": round(time.process_time() - began, 1),
    }


@click.command()
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="File of JSON lines.")
def main(folders: tuple[Path, ...], out: Path) -> None:
    """Diagnose each data set of the challenges that FILE does not have."""
    wanted = []
    for folder in folders:
        answers = json.loads((folder / "answers.json").read_text())
        for number in range(len(answers["cases"])):
            wanted.append(({"data": folder.name, "case": number}, partial(diagnosed, folder, number, answers)))
    add_lines(out, wanted)


if __name__ == "__main__":
    main()
