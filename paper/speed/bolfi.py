"""Seconds and squared errors of BOLFI with ELFI's own process and with the fast one, side by side in one run.

`OMP_NUM_THREADS=1 python -m paper.speed.bolfi`, about two minutes; with `--full` the sizes of the benchmark.
"""

from dataclasses import dataclass

import click
import numpy as np
import pandas as pd
from scipy.stats import wilcoxon

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.bench.store.status import Status
from avobench.bench.sweep.plan import parse_targets
from avobench.tasks.errors import AvobenchError

SURROGATES = ("gpy", "fast")
FULL = {"poisson": 1250, "carl": 500}
LEAST_FOR_TEST = 6
"""Pairs below which Wilcoxon's test cannot reject at the 5 % level."""


@dataclass(frozen=True)
class Run:
    """One inference: seconds from the call of `infer` to its return, and the squared error."""

    seconds: float
    squared_error: float


def run(task: str, surrogate: str, evaluations: int, target: int, seed: int) -> Run:
    """Carry out a cell of the benchmark with so many evaluations. Raises AvobenchError unless it is ok."""
    settings = {"surrogate": surrogate, "events_per_theta": 128}
    record = execute(Cell(task, {}, "bolfi", settings, target, 0, 128 * evaluations, 100_000, seed))
    if record["status"] != Status.OK:
        raise AvobenchError(f"{task} target {target} with {surrogate}: {record['status']}: {record['message']}")
    return Run(record["simulator_seconds"] + record["method_seconds"], record["squared_error"])


def compare(task: str, evaluations: int, targets: list[int], seed: int = 0) -> pd.DataFrame:
    """One row per target, the surrogates taken in turns: seconds of each, their ratio, squared error of each."""
    rows = []
    for i, target in enumerate(targets):
        runs = {name: run(task, name, evaluations, target, seed) for name in SURROGATES[:: 1 if i % 2 else -1]}
        seconds = {f"{name} [s]": runs[name].seconds for name in SURROGATES}
        errors = {f"{name} squared error": runs[name].squared_error for name in SURROGATES}
        ratio = runs["gpy"].seconds / runs["fast"].seconds
        rows.append({"task": task, "evaluations": evaluations, "target": target} | seconds | {"ratio": ratio} | errors)
    return pd.DataFrame(rows)


def summary(table: pd.DataFrame) -> str:
    """The median ratio and squared errors; from six targets on, whether the pairs of errors differ (Wilcoxon)."""
    errors = [table[f"{name} squared error"] for name in SURROGATES]
    line = f"median ratio {table['ratio'].median():.1f}, median squared error gpy {errors[0].median():.2e}, "
    line += f"fast {errors[1].median():.2e}"
    if len(table) >= LEAST_FOR_TEST:
        p = wilcoxon(np.log(errors[0]), np.log(errors[1])).pvalue
        line += f", no difference in {len(table)} pairs has p = {p:.2f} (Wilcoxon)"
    return line


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--poisson", default=300, show_default=True, help="Evaluations in one dimension; 0 for none.")
@click.option("--carl", default=150, show_default=True, help="Evaluations in two dimensions; 0 for none.")
@click.option("--full", is_flag=True, help="1250 and 500 evaluations: some minutes per target.")
@click.option("--targets", default="0-1", show_default=True, help="Indices and ranges, such as 0,3,7-9.")
@click.option("--seed", default=0, show_default=True)
def main(poisson: int, carl: int, full: bool, targets: str, seed: int) -> None:
    """Compare BOLFI's two surrogates, in seconds and in squared error."""
    sizes = FULL if full else {"poisson": poisson, "carl": carl}
    try:
        indices = parse_targets(targets)
        for surrogate in SURROGATES:
            run("poisson", surrogate, 11, 0, seed)  # imports and first calls belong to neither
        for task, evaluations in sizes.items():
            if evaluations:
                table = compare(task, evaluations, indices, seed)
                click.echo(table.to_string(index=False, float_format="{:.3g}".format))
                click.echo(f"{task}: {summary(table)}\n")
    except AvobenchError as error:
        raise click.ClickException(str(error)) from error


if __name__ == "__main__":
    main()
