"""The diagnosis on sealed cases, by `python -m paper.studies.sealed`; `paper.tables.sealed` prints the table.

The cases are those of `paper.sealed`, which were written without sight of the code. Every second of each kind and group
has been opened: it is diagnosed once by a version that is finished, and belongs to development from then on. The others
stay sealed for the next version.
"""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import click

from avobench.bench.events.checks import MIN_EVENTS
from avobench.bench.store.files import require_folder
from avobench.cli.main import main
from paper.sealed import measured, simulated
from paper.sealed.case import Sealed
from paper.studies.foreign import Configuration, made

FOLDER = Path("results/sealed")


def opened(cases: Sequence[Sealed]) -> list[Sealed]:
    """Every second case of each kind and group, in the order in which they were written."""
    by_kind: dict[tuple[str, str], list[Sealed]] = defaultdict(list)
    for case in cases:
        by_kind[case.kind, case.group].append(case)
    return [case for some in by_kind.values() for case in some[::2]]


OPENED = {"simulated": opened(simulated.CASES), "measured": opened(measured.CASES)}
"""By what made the events."""
REFUSED = [case.name for cases in OPENED.values() for case in cases if len(case.x()) < MIN_EVENTS]
"""Those of too few events: a diagnosis takes none of them."""


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def study(results: Path) -> None:
    """Diagnose the opened cases that have no record yet."""
    require_folder(results)
    taken = {by: [case for case in cases if case.name not in REFUSED] for by, cases in OPENED.items()}
    made(results, Configuration(), cases=taken, study="sealed")


if __name__ == "__main__":
    main(study)
