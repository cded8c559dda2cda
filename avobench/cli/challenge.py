"""`avobench challenge`: hide effects in data, diagnose them, and see how often the diagnosis was right."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import click

from avobench.bench.plugins import registry
from avobench.cli.isolated import Isolated
from avobench.cli.options import MEMORY_LIMIT, PATH, TIME_LIMIT, TRUST, workers_of
from avobench.cli.state import State
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError

_say = partial(say, err=True)
FOLDER = click.argument("folder", type=PATH)


@click.group()
def challenge() -> None:
    """Hide effects in simulated data sets, diagnose these, and score the answers."""


@challenge.command(cls=Isolated)
@click.option("--task", required=True, metavar="NAME", help="Task by name, or module:Class.")
@click.option("--cases", type=int, required=True, help="Number of data sets.")
@click.option("--seed", type=int, default=0, help="Seed of all random numbers.")
@click.option("--out", type=PATH, required=True, help="New folder for data and answers.")
@click.option("--events", "num_events", type=int, default=50_000, help="Events of each data set.")
@click.option("--kinds", metavar="A,B", help="Kinds to hide, of none, own, foreign, two, withheld.  [all]")
@click.option("--shapes", metavar="MODULE:NAME", help="Shapes for the kind foreign, such as shapes:SEEN in a clone.")
@TRUST
def make(task: str, kinds: str | None, shapes: str | None, trust: bool, **asked: Any) -> None:
    """Hide random effects in data sets of a task. The answers are in answers.json, apart from the data."""
    from avobench.challenge import make as module

    chosen = None if kinds is None else tuple(kinds.split(","))
    foreign = () if shapes is None else module.named_shapes(shapes)
    used = module.make(registry.trusted(task, trust), kinds=chosen, shapes=foreign, progress=_say, **asked)
    cases, out = asked["cases"], asked["out"]
    say(f"{cases} data sets in {out}, from {used} simulated events; next: avobench challenge solve {out}")


@challenge.command()
@FOLDER
@click.option("--jobs", "-j", type=int, default=1, help="Worker processes.")
@click.option("--alpha", type=float, help="Upper bound on the rate of false alarms.")
@click.option("--simulations", "num_simulations", type=int, help="Limit on simulated events per data set.")
@click.option("--fit", metavar="NAME", help="Method that fits theta first.")
@click.option("--bank", type=click.Path(), help="Folder that keeps simulated events, which all data sets share.")
@TIME_LIMIT
@MEMORY_LIMIT
@TRUST
@click.pass_obj
def solve(state: State, folder: Path, trust: bool, **options: Any) -> None:
    """Diagnose every data set that has no result yet. The answers are not read."""
    from avobench.challenge.solve import solve as solve_all

    workers = workers_of(options, state)
    state.resumes = True
    chosen = {name: value for name, value in options.items() if value is not None}
    solve_all(folder, workers=workers, options=chosen, trust=trust, progress=_say)
    say(f"results in {folder / 'results'}; next: avobench challenge score {folder}")


@challenge.command(cls=Isolated)
@click.argument("places", metavar="FOLDER...", nargs=-1, required=True, type=PATH)
@click.option("--format", "kind", type=click.Choice(["text", "json"]), default="text")
@click.option("--records", type=PATH, help="File for the answers and diagnoses.")
@click.option("--targets", is_flag=True, help="Print the project's targets beside the results.")
@TRUST
def score(places: tuple[Path, ...], kind: str, records: Path | None, targets: bool, trust: bool) -> None:
    """Compare the diagnoses with the answers. Several challenges are pooled.

    FOLDER may also be a file written by --records, with the answer and the diagnosis of one data set per line.
    """
    from avobench.bench.store.files import write_file
    from avobench.challenge.records import read_records
    from avobench.challenge.records import records as records_of
    from avobench.challenge.score import score as score_all
    from avobench.challenge.table import as_text
    from avobench.challenge.table import targets as wanted

    if records is not None and len(places) > 1:
        raise UsageError("--records writes one challenge; give one folder")
    if targets and kind == "json":
        raise UsageError("--targets prints text; leave --format out")
    challenges = [read_records(place) if place.is_file() else records_of(place) for place in places]
    if records is not None:
        write_file(records, "".join(json.dumps(line, allow_nan=False) + "\n" for line in challenges[0]).encode())
    if targets:
        say(wanted(*challenges, trust=trust))
        return
    result = score_all(*challenges, trust=trust)
    say(json.dumps(result, indent=1, allow_nan=False) if kind == "json" else as_text(result))
