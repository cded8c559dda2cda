"""What the decision of a diagnosis was fitted to: `python -m paper.tables.decision`.

A conditional logit of what was missing: the sets of effects that were weighed, other sets of the catalogue, or
something outside of it. It is fitted to the opened cases, whose records say what each set was told by.
`SCORE` has its numbers. Each eighth of the simulators is also told by a fit to the others.
"""

from collections.abc import Sequence
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

from avobench.cli.main import main
from avobench.diagnosis.schema import Verdict
from avobench.effects.catalogue import of_domain
from paper.studies.cases import FOLDER, Configuration, read
from paper.tables.cases import case_of, true

OPENED = FOLDER / "opened" / Configuration().name
FAMILIES = sorted({family.name for family in of_domain("continuous", "counts")})
"""Of the catalogue, each of which has a weight."""
MARKS = 7
"""Of a set of effects."""
ABOUT = np.r_[1, 0.25, 0.7, np.zeros(MARKS - 1 + len(FAMILIES))]
PRECISION = np.r_[1, 4, 1, 1, 4, 1, 1, 0, 0, np.full(len(FAMILIES), 4)]
"""Means and inverse variances of the normal priors of the weights of marks, of two constants, and of families."""
PARTS = 8
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """A detected data set with a known answer, as it was diagnosed."""

    group: str
    simulator: str
    kind: str
    """`single`, `pair` or `outside`."""
    marks: Array
    """What each answer is told by (k + 2, 9 + f): k sets, outside, and other sets, with a constant of either, and how
    many effects of each of f families it has."""
    right: NDArray[np.bool_]
    """Which of the answers is right (k + 2,)."""

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Told":
        case, sets = case_of(record), record["sets"]
        marks = np.zeros((len(sets) + 1, len(ABOUT)))
        marks[:-1, :MARKS] = [each["marks"] for each in sets]
        marks[-2, MARKS] = marks[-1, MARKS + 1] = 1
        for row, each in zip(marks, sets, strict=False):
            for effect in each["effects"] or ():
                row[MARKS + 2 + FAMILIES.index(effect["name"])] += 1
        right = [
            bool(each["effects"]) and case.kind != "outside" and true(record, each["effects"]) for each in sets[:-1]
        ]
        outside = case.kind == "outside"
        told = np.array([*right, outside, not outside and not any(right)])
        return cls(record["made_by"], case.task.name, case.kind, marks, told)


def told(folder: Path = OPENED) -> list[Told]:
    """The cases in which something is missing and a disagreement was seen."""
    detected = [record for record in read(folder) if record["diagnosis"]["verdict"] != Verdict.NOTHING]
    return [Told.of(record) for record in detected if case_of(record).kind != "null" and record["sets"]]


def fitted(cases: Sequence[Told]) -> Array:
    """The weights of marks, of outside and other sets, and of families (9 + f,)."""
    shape = len(cases), max((len(case.right) for case in cases), default=1)
    marks, right, there = np.zeros((*shape, len(ABOUT))), np.zeros(shape, bool), np.zeros(shape, bool)
    for k, case in enumerate(cases):
        answers = len(case.right)
        marks[k, :answers], right[k, :answers], there[k, :answers] = case.marks, case.right, True

    def loss(numbers: Array) -> tuple[float, Array]:
        away = numbers - ABOUT
        logs = np.where(there, marks @ numbers, -np.inf)
        of_right = np.where(right, logs, -np.inf)
        value = (logsumexp(logs, axis=1) - logsumexp(of_right, axis=1)).sum() + PRECISION @ away**2 / 2
        too_high = softmax(logs, axis=1) - softmax(of_right, axis=1)
        return value, np.einsum("ij,ijk->k", too_high, marks) + PRECISION * away

    return minimize(loss, ABOUT, jac=True, method="L-BFGS-B", options={"maxiter": 2000}).x


def by_others(cases: list[Told]) -> list[Array]:
    """The probabilities of the answers of each case, by a fit to the cases of other simulators."""
    simulators = sorted({case.simulator for case in cases})
    part = dict(zip(np.random.default_rng(0).permutation(simulators), np.arange(len(simulators)) % PARTS, strict=True))
    fits = [fitted([case for case in cases if part[case.simulator] != k]) for k in range(PARTS)]
    return [softmax(case.marks @ fits[part[case.simulator]]) for case in cases]


def row(cases: list[Told], told: list[Array]) -> dict[str, Any]:
    """How good the probabilities of some data sets are."""
    loss = [-np.log(p[case.right].sum()) for case, p in zip(cases, told, strict=True)]
    best = np.array([(p[:-1].max(), case.right[p[:-1].argmax()]) for case, p in zip(cases, told, strict=True)])
    alone = [k for k, case in enumerate(cases) if case.kind != "pair"]
    outside = [cases[k].kind == "outside" for k in alone]
    scores = [told[k][-2] for k in alone]
    return {
        "cases": len(cases),
        "outside": sum(outside),
        "log loss": np.mean(loss),
        "P(best)": best[:, 0].mean(),
        "right": best[:, 1].mean(),
        "AUC of outside": roc_auc_score(outside, scores) if 0 < sum(outside) < len(outside) else np.nan,
    }


@click.command()
def table() -> None:
    """Print the numbers, and how good the probabilities are of simulators to which they were not fitted."""
    cases = told()
    numbers, shares = fitted(cases), by_others(cases)
    click.echo(f"{len(cases)} data sets; " + ", ".join(f"{number:.3f}" for number in numbers[: MARKS + 2]) + "\n")
    families = pd.Series(numbers[MARKS + 2 :], FAMILIES, name="weight").sort_values(ascending=False)
    click.echo(families.to_string(float_format=lambda value: f"{value:.2f}") + "\n")
    groups = {group: [k for k, case in enumerate(cases) if case.group == group] for group in ("simulated", "measured")}
    rows = {
        group: row([cases[k] for k in chosen], [shares[k] for k in chosen])
        for group, chosen in {**groups, "all": range(len(cases))}.items()
    }
    click.echo(pd.DataFrame(rows).T.to_string(float_format=lambda value: f"{value:.2f}"))


if __name__ == "__main__":
    main(table)
