"""What the decision of a diagnosis was fitted to: `python -m paper.tables.decision`.

A conditional logit of what was missing: the sets of effects that a diagnosis tells, other sets of the catalogue, or
something outside of it. It is fitted to detected data sets of the challenge and to the opened sealed ones, as they were
diagnosed before it: their records have the share of each set. `SCORE` has its numbers. Each group of data sets is also
told by a fit to the others.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import logsumexp, softmax
from sklearn.metrics import roc_auc_score

from avobench.challenge.records import read_records
from avobench.cli.main import main
from avobench.diagnosis.goodness_of_fit.outside import left, misfit
from avobench.diagnosis.schema import Gap, Verdict
from avobench.diagnosis.settings import TEST
from paper.studies.foreign import read
from paper.tables.sealed import case_of, true

CHALLENGE, SEALED = Path("results/challenge"), Path("results/sealed/today")
FILES = ("development-*.jsonl", "sealed-*.jsonl")
RIDGE = 1.0
"""Inverse variance of the normal prior of each number but the two constants; the power is about 1, others about 0."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """A detected data set with a known answer, as it was diagnosed."""

    group: str
    kind: str
    """`single`, `pair` or `outside`."""
    features: Array
    """What each answer is told by (k + 2, 6): the k sets that were told, other sets, and outside the catalogue."""
    right: NDArray[np.bool_]
    """Which of the answers are right (k + 2,)."""

    @classmethod
    def of(cls, group: str, kind: str, diagnosis: dict[str, Any], right: list[bool]) -> "Told":
        """`right` tells which of the sets are what was missing."""
        share = np.array([each["probability"] for each in diagnosis["models"]])
        several = [len(each["effects"]) > 1 for each in diagnosis["models"]]
        before, after = (gap and Gap(**gap) for gap in (diagnosis["gap_before"], diagnosis["gap_after"]))
        p = diagnosis["p_value_after"] if after else diagnosis["p_value_before"]
        rejected = p < TEST.rejected_share * diagnosis.get("alpha", 0.05)
        features = np.zeros((len(share) + 2, 6))
        features[:-2, :2] = np.column_stack([np.log(share / share.sum()), several])
        features[-2, 2] = 1
        features[-1, 3:] = 1, misfit(p), rejected * min(2 * left(before, after), 1)
        beside = [kind != "outside" and not any(right), kind == "outside"]
        return cls(group, kind, features, np.array([*right, *beside]))


def of_challenge(folder: Path = CHALLENGE) -> Iterator[Told]:
    kinds = {"foreign": "single", "own": "single", "two": "pair", "withheld": "outside"}
    for path in [path for pattern in FILES for path in sorted(folder.glob(pattern))]:
        for row in read_records(path)[1:]:
            if row["error"] or row["kind"] == "none" or not row["diagnosis"]["models"]:
                continue
            hidden = {(each["name"], each["feature"]) for each in row["effects"]}
            sets = [{(e["name"], e["feature"]) for e in each["effects"]} for each in row["diagnosis"]["models"]]
            kind = kinds[row["kind"]]
            yield Told.of(path.stem.split("-")[1], kind, row["diagnosis"], [each == hidden for each in sets])


def of_sealed(folder: Path = SEALED) -> Iterator[Told]:
    for record in [record for some in read(folder, "sealed").values() for record in some]:
        kind, diagnosis = case_of(record).kind, record["diagnosis"]
        if kind == "null" or diagnosis["verdict"] == Verdict.NOTHING or not diagnosis["models"]:
            continue
        right = [kind != "outside" and true(record, each["effects"]) for each in diagnosis["models"]]
        yield Told.of(record["made_by"], kind, diagnosis, right)


def fitted(cases: list[Told]) -> Array:
    """The six numbers (6,)."""
    about, precision = np.array([1.0, 0, 0, 0, 0, 0]), RIDGE * np.array([1, 1, 0, 0, 1, 1])

    def loss(numbers: Array) -> tuple[float, Array]:
        value, slope = precision @ (numbers - about) ** 2 / 2, precision * (numbers - about)
        for case in cases:
            logs = case.features @ numbers
            right = np.where(case.right, logs, -np.inf)
            value += logsumexp(logs) - logsumexp(right)
            slope += (softmax(logs) - softmax(right)) @ case.features
        return value, slope

    return minimize(loss, about, jac=True, method="BFGS").x


def row(cases: list[Told], told: list[Array]) -> dict[str, Any]:
    """How good the probabilities of some data sets are."""
    loss = [-np.log(p[case.right].sum()) for case, p in zip(cases, told, strict=True)]
    said = [np.r_[p[:-2], p[-1]] for p in told]  # a set, or outside
    best = np.array([(p.max(), np.delete(case.right, -2)[p.argmax()]) for case, p in zip(cases, said, strict=True)])
    singles = [case.kind != "pair" for case in cases]
    outside = np.array([case.kind == "outside" for case in cases])
    enough = outside.any() and not outside.all()
    auc = roc_auc_score(outside[singles], np.array([p[-1] for p in told])[singles]) if enough else np.nan
    return {
        "cases": len(cases),
        "outside": outside.sum(),
        "log loss": np.mean(loss),
        "P(best)": best[:, 0].mean(),
        "right": best[:, 1].mean(),
        "AUC of outside": auc,
    }


@click.command()
def table() -> None:
    """Print the numbers, and how good the probabilities are of the groups to which they were not fitted."""
    cases = [*of_challenge(), *of_sealed()]
    numbers = fitted(cases)
    click.echo(f"{len(cases)} data sets; " + ", ".join(f"{number:.3f}" for number in numbers) + "\n")
    rows = {}
    for group in sorted({case.group for case in cases}):
        own = [case for case in cases if case.group == group]
        others = fitted([case for case in cases if case.group != group])
        rows[group] = row(own, [softmax(case.features @ others) for case in own])
    click.echo(pd.DataFrame(rows).T.to_string(float_format=lambda value: f"{value:.2f}"))


if __name__ == "__main__":
    main(table)
