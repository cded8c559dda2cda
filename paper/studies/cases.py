"""The diagnosis on cases of others: `python -m paper.studies.cases opened`, or `sealed`; `paper.tables.cases` prints.

The cases are those of `paper.cases`: what they lack was written down before any of them was diagnosed. Each
configuration of the diagnosis has a folder of its own, in which a case that has no record yet is diagnosed.
"""

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from avobench.bench.events.checks import MIN_EVENTS
from avobench.bench.store.files import require_folder, write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, encode
from avobench.bench.store.versions import versions
from avobench.cli.main import main
from avobench.diagnosis.checks import Checks
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.run import diagnose
from avobench.diagnosis.search.posterior import Posterior
from avobench.tasks.errors import StoreError, UsageError
from paper.cases import opened, sealed
from paper.cases.case import Case
from paper.studies.files import of_identity, read_file

STUDY, FOLDER = "cases", Path("results/cases")
CASES = {
    of: {by: [case for case in some if len(case.x()) >= MIN_EVENTS] for by, some in cases.items()}
    for of, cases in {"opened": opened.CASES, "sealed": sealed.CASES}.items()
}
"""Opened and sealed ones, by what made the events; without those of too few events, which are refused."""
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

    experience: bool = True
    """Whether the networks are asked what the events look like."""
    simulations: int | None = SIMULATIONS
    """That it may use; None for as many as it takes."""
    seed: int = 0

    @property
    def name(self) -> str:
        """The name of its folder: records of another seed, or another limit, stand in its stead."""
        words = "with-experience" if self.experience else "without-experience"
        return words if self.simulations else f"{words}-without-limit"


def made(
    folder: Path, configuration: Configuration, cases: Mapping[str, Sequence[Case]], names: Sequence[str] = ()
) -> list[dict[str, Any]]:
    """The records of the cases of these names, or of all; `cases` are by what made the events.

    Those are made that are lacking, or of other events or another answer. A new version of the diagnosis makes none of
    them anew: name another folder for that. A case that is refused has none. Raises StoreError for a damaged record.
    """
    records = []
    for made_by, some in cases.items():
        for case in [case for case in some if not names or case.name in names]:
            path = folder / configuration.name / f"{case.name}.json"
            identity = identity_of(case, made_by, configuration)
            record = of_identity(path, identity)
            if not record:
                path.parent.mkdir(parents=True, exist_ok=True)
                try:
                    record = {"schema_version": SCHEMA_VERSION, **identity, **said(case, configuration)}
                except UsageError as error:
                    click.echo(f"{configuration.name} {case.name}: refused, {error}", err=True)
                    continue
                write_atomically(path, encode(record))
                named = ", ".join(effect["name"] for effect in record["diagnosis"]["effects"])
                click.echo(f"{configuration.name} {case.name}: {named or record['diagnosis']['verdict']}", err=True)
            records.append(record)
    return records


def identity_of(case: Case, made_by: str, configuration: Configuration) -> dict[str, Any]:
    """What determines a record but for the versions."""
    return {
        **{"study": STUDY, "case": case.name, "made_by": made_by, "events_sha256": digest(case)},
        **{"right": list(case.right), "defensible": list(case.defensible)},
        **{"experience": configuration.experience, "simulations": configuration.simulations},
        **{"seed": configuration.seed},
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
    x, remarks = checks.events(x)
    result = diagnose(
        case.task,
        x,
        seed=configuration.seed,
        bank=checks.bank,
        effects=checks.entries(),
        experience=configuration.experience,
    )
    diagnosis = result.diagnosis
    diagnosis.notes[:0] = remarks
    seconds = time.process_time() - started
    told = diagnosis.model_dump(mode="json", include=KEPT)
    sets = weighed(result.posterior, case.task.labels) if result.posterior else []
    return {"diagnosis": told, "sets": sets, "processor_seconds": seconds, "versions": versions()}


def weighed(posterior: Posterior, labels: tuple[str, ...]) -> list[dict[str, Any]]:
    """What all sets of effects, and what is outside, were told by: to which the decision is fitted."""
    sets = [
        {
            "effects": [named(key, labels).model_dump() for key in sorted(names, key=str)],
            "marks": marks.tolist(),
            "q": (best := posterior.shapes[names][0].fit).noiseless_q,
            "dof": best.dof,
            "events": best.num_events,
        }
        for names, marks in posterior.covariates.items()
    ]
    return [*sets, {"effects": None, "marks": [0, 0, posterior.looks_outside, 0, 0, 0, 0]}]


def read(folder: Path) -> list[dict[str, Any]]:
    """The records of a configuration. Raises StoreError for none or a damaged one."""
    paths = sorted(folder.glob("*.json"))
    if not paths:
        raise StoreError(f"no records in {folder}; `python -m paper.studies.cases` makes them")
    return [read_file(path, STUDY) for path in paths]


@click.command()
@click.argument("which", type=click.Choice(list(CASES)))
@click.option("--experience/--no-experience", default=True, help="Ask the networks, or not.")
@click.option("--simulations", type=click.IntRange(0), default=SIMULATIONS, show_default=True, help="0 for no limit.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@click.option("--case", "names", multiple=True, metavar="NAME", help="May be repeated.  [all]")
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def study(which: str, experience: bool, simulations: int, seed: int, names: tuple[str, ...], results: Path) -> None:
    """Diagnose the opened or the sealed cases that have no record in this configuration yet."""
    known = {case.name for cases in CASES[which].values() for case in cases}
    if unknown := sorted(set(names) - known):
        raise UsageError(f"no {which} case {', '.join(unknown)}")
    require_folder(results)
    made(results / which, Configuration(experience, simulations or None, seed), CASES[which], names)


if __name__ == "__main__":
    main(study)
