"""How often networks tell what is wrong, on what they were not trained on: `python -m paper.studies.recognised FOLDER`.

FOLDER is that of `paper.studies.experience`. Networks that learn from a part of its examples are asked about a fifth of
its files, and about function classes, drivers and simulators that were left out. Those that are installed are asked
about the opened cases of others, with theta fitted as in a diagnosis; their portraits are kept in FOLDER.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import get_args

import click
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.cli.main import main
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.experience.recogniser import Kind, Recogniser, kind_of, portrait
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.settings import RECOGNITION
from avobench.effects.catalogue import domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks import Task
from avobench.tasks.meter import Meter
from paper.grammar.sentences import OUTSIDE
from paper.studies.cases import CASES
from paper.studies.experience import SHOWN, Examples, read, trained

LEFT_OUT: dict[str, Callable[[str, str], bool]] = {
    "stepped functions": lambda sentence, simulator: sentence.endswith("stepped"),
    "smooth and periodic": lambda sentence, simulator: sentence.endswith(("smooth", "periodic")),
    "by another, by time": lambda sentence, simulator: sentence.split()[1] in ("other", "time"),
    "four simulators": lambda sentence, simulator: any(
        each in simulator for each in ("gamma", "weibull", "negative", "student")
    ),
}
"""What networks are trained without, and then asked about."""
LEAST = 20
"""Examples of something left out, below which it is not asked about."""


def beside(task: Task, x: NDArray) -> tuple[NDArray[np.float64], float]:
    """The portrait (f,) of events (n, d) beside the task as a first fit finds it, and the p-value of that fit."""
    rng, most = np.random.default_rng(0), x[: RECOGNITION.portrait_events]
    model = Model(task, events=Counted(task, Meter()))
    fit, _ = fit_null(model, x, rng, effort_for(task, domain(task), None, len(x)), None)
    simulated = task.simulate(np.tile(fit.params, (RECOGNITION.simulated * len(most), 1)), rng)
    return portrait(most, simulated, kind_of(task) == "count"), fit.p_value


def of_cases(kind: Kind) -> Iterator[tuple[str, str, str, NDArray[np.float64]]]:
    """The cases of others that show anything: the case, the right families, how it was made, and the portrait."""
    for made_by, cases in CASES["opened"].items():
        for case in [case for case in cases if case.right and kind_of(case.task) == kind]:
            x = np.reshape(case.x(), (-1, case.task.num_features))
            seen, p_value = beside(case.task, x)
            if p_value < SHOWN:
                yield case.name, "|".join(sorted({name.split(" on ")[0] for name in case.right})), made_by, seen


def kept(path: Path, rows: Callable[[], Iterator[tuple]]) -> Examples:
    """The examples in a file, which is made where it is not there yet."""
    if not path.exists():
        names, families, how, portraits = zip(*rows(), strict=True)
        twice = (np.stack([each, each], axis=1) for each in (families, how))
        Examples(np.array(portraits, np.float32), *twice, np.array(names)).write(path)
    return Examples.read(path)


def told(networks: Recogniser, names: list[str], asked: Examples) -> dict[str, float]:
    """How often the first family, or one of the first three, is right among some names, and the mean log probability.

    What is outside is not asked about, nor are examples with two effects, or of a family that is not one of the names.
    """
    right = np.array([[name in families.split("|") for name in names] for families in asked.families[:, 0]])
    rows = right.any(axis=1) & (asked.families[:, 0] == asked.families[:, 1])
    shares = [networks.probabilities(marks) for marks in asked.portraits[rows].astype(float)]
    share = np.array([[each[name] for name in names] for each in shares])
    share, right = share / share.sum(axis=1, keepdims=True), right[rows]
    ranked = np.take_along_axis(right, np.argsort(-share, axis=1), axis=1)
    log = np.log((share * right).sum(axis=1) + 1e-3)
    return {
        "n": len(share),
        "first": ranked[:, 0].mean(),
        "first three": ranked[:, :3].any(axis=1).mean(),
        "log p": log.mean(),
        "error": log.std() / np.sqrt(len(log)),
    }


def compared(kind: Kind, folder: Path) -> Iterator[dict]:
    """A row for each set of examples of a kind."""
    known = read(kind, folder)
    fifth = np.arange(len(known.portraits)) >= 0.8 * len(known.portraits)  # of whole files, hence of other simulators
    sets = [("other draws", known.where(fifth), learnt(known.where(~fifth)))]
    for what, is_left_out in LEFT_OUT.items():
        rows = np.array([*map(is_left_out, known.sentences[:, 0], known.simulators)])
        if rows.sum() >= LEAST:
            sets.append((what, known.where(rows), learnt(known.where(~rows))))
    cases = kept(folder / f"cases-{kind}.npz", lambda: of_cases(kind))
    sets.append(("cases of others", cases, Recogniser.of(kind)))
    for what, asked, networks in sets:
        names = [name for name in networks.families if name != OUTSIDE]
        yield {"events": kind, "asked about": what, **told(networks, names, asked)}


def learnt(known: Examples) -> Recogniser:
    """Networks that learn from examples."""
    families, networks = trained(known)
    return Recogniser(tuple(families), tuple(map(tuple, networks)))


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
def recognised(folder: Path) -> None:
    """Print the table of comparisons."""
    rows = [row for kind in get_args(Kind) for row in compared(kind, folder)]
    click.echo(pd.DataFrame(rows).to_string(index=False, float_format="{:.2f}".format))


if __name__ == "__main__":
    main(recognised)
