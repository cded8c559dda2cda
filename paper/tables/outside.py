"""The probability that what is missing is outside the catalogue: `python -m paper.tables.outside`.

A logistic regression, on detected cases of the challenge, of whether the family that was hidden had been taken out of
the catalogue, on what `avobench.diagnosis.goodness_of_fit.outside` asks of the best model. `SCORE.outside` has its
coefficients.
"""

from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import cross_val_predict

from avobench.challenge.records import read_records
from avobench.cli.main import main
from avobench.diagnosis.goodness_of_fit.outside import left, misfit
from avobench.diagnosis.schema import Gap, Verdict
from avobench.diagnosis.settings import TEST

FOLDER = Path("results/challenge")
FILES = ("development-*.jsonl", "sealed-*.jsonl")
CLASSES = (0.1, 0.2, 0.4, 0.6)
"""Borders of classes of the probability."""
FOLDS = 10


def detected(folder: Path) -> list[dict[str, Any]]:
    """The records of cases in which something is hidden, and a disagreement was found."""
    paths = [path for pattern in FILES for path in sorted(folder.glob(pattern))]
    rows = [row for path in paths for row in read_records(path)[1:] if row["error"] is None]
    return [row for row in rows if row["kind"] != "none" and row["diagnosis"]["verdict"] != Verdict.NOTHING]


def asked(diagnosis: dict[str, Any]) -> tuple[float, float]:
    """What the regression asks of a record: how badly the best model fits, and what it leaves where it is rejected."""
    before, after = (gap and Gap(**gap) for gap in (diagnosis["gap_before"], diagnosis["gap_after"]))
    p = diagnosis["p_value_after"] if after else diagnosis["p_value_before"]
    rejected = p < TEST.rejected_share * diagnosis["alpha"]
    return misfit(p), rejected * min(2 * left(before, after), 1)


def regression(rows: list[dict[str, Any]]) -> tuple[NDArray, NDArray, LogisticRegression]:
    """What is asked of each case (n, 2), whether it is outside (n,), and the regression of that."""
    x = np.array([asked(row["diagnosis"]) for row in rows])
    out = np.array([row["kind"] == "withheld" for row in rows])
    return x, out, LogisticRegression(C=1000).fit(x, out)


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=FOLDER, show_default=True)
def table(results: Path) -> None:
    """Print the coefficients, and how well the probability tells the cases apart that it was not fitted to."""
    rows = detected(results)
    x, out, model = regression(rows)
    told = cross_val_predict(model, x, out, cv=FOLDS, method="predict_proba")[:, 1]
    stated = np.array([row["diagnosis"]["outside"] or 0 for row in rows])
    of_p, of_gap = model.coef_[0]
    click.echo(f"{len(out)} cases, {out.sum()} outside; constant {model.intercept_[0]:.3f}, {of_p:.3f}, {of_gap:.3f}")
    click.echo(
        f"AUC {roc_auc_score(out, told):.2f} by {FOLDS}-fold cross-validation; "
        f"of the probability that the records state {roc_auc_score(out, stated):.2f}\n"
    )
    groups = pd.DataFrame({"told": told, "outside": out}).groupby(np.searchsorted(CLASSES, told, side="right"))
    found = groups.agg(cases=("told", "size"), told=("told", "mean"), outside=("outside", "mean"))
    click.echo(found.to_string(index=False, float_format=lambda value: f"{value:.2f}"))


if __name__ == "__main__":
    main(table)
