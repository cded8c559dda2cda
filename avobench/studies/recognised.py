"""The simplest rival of the search for names: networks that have seen the shapes of earlier series, and fit no effect.

`python -m avobench.studies.recognised EXAMPLES FOLDER ...`, of challenges in events with features, and of the examples
that `avobench.studies.experience` makes. From how measured events look beside the fitted simulator it tells the family,
as it has learned from examples of the series before. Records in `results/recognised`; `python -m
avobench.reports.recognised` compares them with what the search said of the same data.
"""

import json
import sys
from pathlib import Path

import numpy as np

from avobench.bench import registry
from avobench.bench.atomic import write_atomically
from avobench.bench.events import check_events, read_events
from avobench.challenge.shapes import ONE_FAMILY, kind_of_events
from avobench.challenge.solve import read_json, read_manifest
from avobench.diagnosis.experience.recogniser import Recogniser, kind_of
from avobench.studies.experience import beside, of_kind, trained
from avobench.tasks.errors import UsageError

RESULTS = Path("results/recognised")


def study(folder: Path, examples: Path) -> Path:
    """Tell the family of each data set of a challenge that has one hidden effect; the path of its records."""
    manifest = read_manifest(folder)
    spec = registry.named_in(folder / "manifest.json", "task", manifest["task"], trust=False)
    task = registry.build("task", spec, {})
    if (kind := kind_of(task)) is None:
        raise UsageError(f"{folder}: there is no experience with events of {task.name}")
    answers = read_json(folder / "answers.json")["cases"]
    last = max(effect["series"] for each in answers for effect in each["effects"] if effect.get("series"))
    families, networks = trained(of_kind(kind, examples).before(last))
    recogniser = Recogniser(tuple(families), tuple(map(tuple, networks)))
    rng = np.random.default_rng(last)
    lines = [{"task": manifest["task"], "series": last}]
    for answer in answers:
        if len(answer["effects"]) != 1:
            continue
        x, _ = check_events(task, read_events(str(folder / "data" / f"{answer['case']}.npz")))
        seen, _ = beside(task, x, rng)
        name = answer["effects"][0]["name"]
        hidden = ONE_FAMILY.get((kind_of_events(task), name), name)
        line = {"case": answer["case"], "kind": answer["kind"], "hidden": hidden}
        lines.append({**line, "probabilities": recogniser.probabilities(seen)})
    path = RESULTS / f"{folder.name}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, "".join(json.dumps(line) + "\n" for line in lines).encode())
    return path


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("say where the examples are, and which challenges are to be told")
    for given in sys.argv[2:]:
        try:
            print(study(Path(given), Path(sys.argv[1])))
        except UsageError as error:
            sys.exit(str(error))
