"""Whether a right simulator is accepted and a wrong one rejected, by few simulated events and by all that it takes.

`python -m paper.studies.detection` tests the opened cases on simulators that lack one effect or none, without a search
for what is missing. Where nothing is missing the data are fresh: of a theta that is drawn from the middle half of each
range, by a seed that no version was developed on. Each case and limit adds a JSON line to the file of its version; what
it has is left alone.
"""

from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis import diagnose
from avobench.tasks.errors import UsageError
from paper.cases.case import Case
from paper.studies.cases import CASES
from paper.studies.files import add_lines

FOLDER = Path("results/detection")
KINDS = ("null", "single")
LIMITS = (20, 50, None)
"""Simulated events for each measured one, at most; None for no limit."""
LEAST = 20_000
"""Simulated events that a diagnosis is allowed, at least."""


def events(case: Case, seed: int) -> NDArray:
    """Its own events (N, d), or as many fresh ones of its simulator if nothing is missing."""
    own = case.x().reshape(-1, case.task.num_features)
    if case.kind != "null":
        return own
    rng, prior = np.random.default_rng([seed, *case.name.encode()]), case.task.prior
    low, high = np.array(prior.low), np.array(prior.high)
    theta = low + (high - low) * rng.uniform(0.25, 0.75, len(low))
    return case.task.simulate(np.tile(theta, (len(own), 1)), rng)


def tested(case: Case, limit: int | None, seed: int) -> dict[str, Any]:
    """What the tests say of a case, or that its limit is too low for them."""
    x = events(case, seed)
    row = {"case": case.name, "kind": case.kind, "limit": limit}
    allowed = None if limit is None else max(limit * len(x), LEAST)
    try:
        said = diagnose(case.task, x, seed=seed, num_simulations=allowed, max_effects=0).diagnosis
    except UsageError as error:
        return row | {"refused": str(error)}
    return row | {"p_value": said.p_value_before, "calls_per_event": round(said.num_simulations / len(x), 1)}


@click.command()
@click.option("--seed", type=click.IntRange(0), default=18, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=FOLDER / "now.jsonl", show_default=True)
@click.option("--part", type=(int, int), default=(0, 1), help="Of so many parts this one: for several processes.")
def main(seed: int, out: Path, part: tuple[int, int]) -> None:
    """Test the cases that the file does not have."""
    out.parent.mkdir(parents=True, exist_ok=True)
    cases = [case for case in CASES["opened"]["simulated"] if case.kind in KINDS]
    each = product(cases[part[0] :: part[1]], LIMITS)
    add_lines(out, (({"case": case.name, "limit": limit}, partial(tested, case, limit, seed)) for case, limit in each))


if __name__ == "__main__":
    main()
