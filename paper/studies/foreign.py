"""The diagnosis on cases of others, by `python -m paper.studies.foreign`; `paper.tables.foreign` prints the table.

The cases are those of `paper.foreign`: what they lack was written down before any of them was diagnosed. Each
configuration of the diagnosis has a folder of its own, in which a case that has no record yet is diagnosed.
"""

import copy
import hashlib
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import click
import numpy as np

from avobench.bench.store.files import require_folder, write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, encode
from avobench.bench.store.versions import versions
from avobench.cli.main import main
from avobench.diagnosis.checks import Checks
from avobench.diagnosis.run import diagnose
from avobench.effects import Effect
from avobench.tasks.errors import StoreError
from paper.foreign import measured, simulated
from paper.foreign.case import Case
from paper.studies.files import read_file

FOLDER = Path("results/foreign")
CASES = {"simulated": simulated.CASES, "measured": measured.CASES}
"""By what made the events."""
NAMES = [case.name for cases in CASES.values() for case in cases]
SIMULATIONS = 10_000_000
"""That a diagnosis may use unless another limit is set: it then takes some ten seconds."""
KEPT = {
    *("verdict", "p_value_before", "p_value_after", "gap_before", "gap_after", "effects", "models", "outside"),
    *("others", "theta_before", "theta_after", "num_events", "num_simulations", "notes"),
}
"""Fields of a diagnosis that a record has."""


@dataclass(frozen=True)
class Configuration:
    """How a diagnosis is made."""

    shapes: int | None = None
    """Shapes that a family may have, the plainest first; None for all."""
    experience: bool = True
    """Whether the networks are asked what the events look like."""
    simulations: int | None = SIMULATIONS
    """That it may use; None for as many as it takes."""
    seed: int = 0

    @property
    def name(self) -> str:
        """The name of its folder: records of another seed, or another limit, stand in its stead."""
        words = f"{self.shapes or 'all'}-{'with' if self.experience else 'without'}-experience"
        return words if self.simulations else f"{words}-without-limit"


@cache
def with_shapes(family: type[Effect], number: int) -> type[Effect]:
    """A family that offers the first shapes of another one alone."""

    def shapes(self) -> tuple[Effect, ...]:
        return family.shapes(self)[:number]

    return type(family.__name__, (family,), {"shapes": shapes})


def plainest(effects: Iterable[Effect], number: int | None) -> list[Effect]:
    """The effects, each with its first shapes alone; classes of one name and feature share their number."""
    if number is None:
        return list(effects)
    taken: Counter[tuple] = Counter()
    chosen = []
    for effect in effects:
        own = min(len(effect.shapes()), number - taken[effect.key])
        if own:
            taken[effect.key] += own
            fewer = copy.copy(effect)
            object.__setattr__(fewer, "__class__", with_shapes(type(effect), own))  # the effects are frozen
            chosen.append(fewer)
    return chosen


def made(
    folder: Path,
    configuration: Configuration,
    names: Sequence[str] = (),
    cases: Mapping[str, Sequence[Case]] = CASES,
    study: str = "foreign",
) -> list[dict[str, Any]]:
    """The records of the cases of these names, or of all; `cases` are by what made the events.

    Those are made that are lacking, or of other events or another answer. A new version of the diagnosis makes none of
    them anew: name another folder for that. Raises StoreError for a damaged record.
    """
    records = []
    for made_by, some in cases.items():
        for case in [case for case in some if not names or case.name in names]:
            path = folder / configuration.name / f"{case.name}.json"
            identity = {**identity_of(case, made_by, configuration), "study": study}
            record = read_file(path, study) if path.exists() else {}
            if {field: record.get(field) for field in identity} != identity:
                path.parent.mkdir(parents=True, exist_ok=True)
                record = {"schema_version": SCHEMA_VERSION, **identity, **said(case, configuration)}
                write_atomically(path, encode(record))
                named = ", ".join(effect["name"] for effect in record["diagnosis"]["effects"])
                click.echo(f"{configuration.name} {case.name}: {named or record['diagnosis']['verdict']}", err=True)
            records.append(record)
    return records


def identity_of(case: Case, made_by: str, configuration: Configuration) -> dict[str, Any]:
    """What determines a record but for the versions."""
    return {
        **{"study": "foreign", "case": case.name, "made_by": made_by, "events_sha256": digest(case)},
        **{"right": list(case.right), "defensible": list(case.defensible)},
        **{"shapes": configuration.shapes, "experience": configuration.experience},
        **{"simulations": configuration.simulations, "seed": configuration.seed},
    }


def digest(case: Case) -> str:
    """Of the events and of some that the simulator makes; in five figures, as the last ones differ by computer."""
    rng = np.random.default_rng(0)
    made = case.task.simulate(case.task.prior.sample(1000, rng), rng)
    numbers = np.concatenate([np.ravel(case.x()), np.ravel(made)])
    return hashlib.sha256(" ".join(f"{number:.5g}" for number in numbers).encode()).hexdigest()


def said(case: Case, configuration: Configuration) -> dict[str, Any]:
    """What the diagnosis says of a case, and the versions that it was made with."""
    started = time.process_time()
    x = case.x()
    checks = Checks(case.task, len(x), configuration.simulations, seed=configuration.seed)
    effects = plainest(checks.entries(), configuration.shapes)
    x, remarks = checks.events(x)
    diagnosis = diagnose(
        case.task,
        x,
        seed=configuration.seed,
        bank=checks.bank,
        effects=effects,
        experience=configuration.experience,
    ).diagnosis
    diagnosis.notes[:0] = remarks
    seconds = time.process_time() - started
    told = diagnosis.model_dump(mode="json", include=KEPT)
    return {"diagnosis": told, "processor_seconds": seconds, "versions": versions()}


def read(folder: Path = FOLDER, study: str = "foreign") -> dict[str, list[dict[str, Any]]]:
    """The records in a folder by the name of the configuration. Raises StoreError for none or a damaged one."""
    paths = sorted(folder.glob("*/*.json"))
    if not paths:
        raise StoreError(f"no records in {folder}; `python -m paper.studies.{study} --results {folder}` makes them")
    return {
        name: [read_file(path, study) for path in paths if path.parent.name == name]
        for name in dict.fromkeys(path.parent.name for path in paths)
    }


@click.command()
@click.option("--shapes", type=click.IntRange(1), default=None, help="Shapes of a family, the plainest first.  [all]")
@click.option("--experience/--no-experience", default=True, help="Ask the networks, or not.")
@click.option("--simulations", type=click.IntRange(0), default=SIMULATIONS, show_default=True, help="0 for no limit.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@click.option(
    "--case", "names", multiple=True, type=click.Choice(NAMES), metavar="NAME", help="May be repeated.  [all]"
)
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def study(
    shapes: int | None, experience: bool, simulations: int, seed: int, names: tuple[str, ...], results: Path
) -> None:
    """Diagnose the cases that have no record in this configuration yet."""
    require_folder(results)
    made(results, Configuration(shapes, experience, simulations or None, seed), names)


if __name__ == "__main__":
    main(study)
