"""The tables of the experiments of the grid, from their committed records."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import gmean, norm

from avobench.bench.store.status import ESTIMATED
from avobench.reports.coverage import by_method, distances
from avobench.reports.quantities import labelled, task_of
from avobench.reports.style import METHOD_ORDER, TASK_ORDER, ordered
from avobench.tasks import Task
from paper.experiments import ABLATION_TASKS, DEVELOPMENT, EXPERIMENTS, Runs
from paper.quantities import (
    WORST_RUN,
    ahead,
    asymmetry_errors,
    asymmetry_inefficiency,
    beside_ideal,
    by_mean,
    efficient_median,
    ideal_errors,
    in_units_of_the_best,
    inefficiency_of,
    interval_text,
    median,
    ratio_of_means,
    still,
    worst,
)
from paper.sbibm_tasks import SBIBM
from paper.tables.targets import METHOD
from paper.tasks import DEVELOPMENT as DEVELOPMENT_TASKS
from paper.tasks import FRESH, FRESH_WARPED

Records = list[dict[str, Any]]
LEVELS = (0.68, 0.95)
"""Of the intervals whose coverage is told."""


def ablation(records: Records) -> pd.DataFrame:
    """One row per difference between avo and avo-paper that is undone, one column per task.

    A cell has the inefficiency, on weinberg of c, and in brackets the largest ratio of squared error to floor, on the
    targets of which every row has its record.
    """
    by_id = {record["id"]: record for record in records}
    runs = (Runs("avo as it is", METHOD, {}, ABLATION_TASKS, 5), *EXPERIMENTS["ablation"].runs)
    columns = {}
    for task in ABLATION_TASKS:
        cells = {run.label: run.cells(task) for run in runs if task in run.tasks}
        missing = {cell.target for planned in cells.values() for cell in planned if cell.id not in by_id}
        shown = {
            label: labelled([by_id[cell.id] for cell in planned if cell.target not in missing])
            for label, planned in cells.items()
            if any(cell.target not in missing for cell in planned)
        }
        num_targets = max((chosen["target"].nunique() for chosen in shown.values()), default=0)
        columns[f"{task}, {num_targets} targets"] = {label: _worth(chosen, task) for label, chosen in shown.items()}
    return pd.DataFrame(columns, index=[run.label for run in runs], dtype=object).fillna("")


def _worth(cells: pd.DataFrame, task: str) -> str:
    if task == "weinberg":
        return f"{asymmetry_inefficiency(cells):.2g} ({np.max(np.divide(*asymmetry_errors(cells))):.2g})"
    return f"{inefficiency_of(cells):.2g} ({cells['ratio'].max():.2g})"


def tuning(records: Records) -> pd.DataFrame:
    """One row per candidate for the settings of a rival, see `_candidates`."""
    return _candidates("tuning", records).drop(columns="still", errors="ignore")


def sensitivity(records: Records) -> pd.DataFrame:
    """One row per candidate for the settings of avo-plain, see `_candidates`."""
    return _candidates("sensitivity", records).drop(columns="method", errors="ignore")


def _candidates(experiment: str, records: Records) -> pd.DataFrame:
    """One row per complete candidate: its median inefficiency on each development task, and seconds per cell.

    By the geometric mean over tasks one is chosen. `still` is the largest share of a run in which the proposal stood
    exactly still. These are development numbers: the best of several is better by luck, too.
    """
    by_id, rows = {record["id"]: record for record in records}, []
    grid, names = EXPERIMENTS[experiment], {spec: name for name, spec in DEVELOPMENT.items()}
    for run in grid.runs:
        cells = {names[task]: run.cells(task, grid.root()) for task in run.tasks}
        if not all(cell.id in by_id for wanted in cells.values() for cell in wanted):
            continue
        done = {name: [by_id[cell.id] for cell in wanted] for name, wanted in cells.items()}
        values = {
            name: np.median([_inefficiency(name, record) for record in task_records])
            for name, task_records in done.items()
        }
        every = [record for task_records in done.values() for record in task_records]
        row = {"method": run.method, "settings": run.label, "targets": run.targets, **values}
        row |= {"geometric mean": gmean(list(values.values())), "still": f"{max(map(still, every)):.0%}"}
        row["seconds"] = np.mean([record["simulator_seconds"] + record["method_seconds"] for record in every])
        rows.append(row)
    return pd.DataFrame(rows)


def _inefficiency(name: str, record: dict[str, Any]) -> float:
    """Squared error over its floor, on weinberg of c, in units of an efficient estimator's; of a failure infinite."""
    if record["status"] not in ESTIMATED:
        return np.inf
    task, true = DEVELOPMENT_TASKS[name](), np.array(record["theta_true"])
    if name == "weinberg":
        estimated, wanted = task.asymmetry(np.array([record["theta_hat"], true]))
        floor = task.asymmetry_floor(true, record["num_observations"], record["budget"])
        return (estimated - wanted) ** 2 / floor / efficient_median((1.0,))
    return record["squared_error"] / record["floor"] / efficient_median(task.floor_shares)


def fresh(records: Records) -> pd.DataFrame:
    """One row per task and method on fresh targets, of which `avo` was developed on none.

    `mean / floor` is the mean squared error over the mean floor, on weinberg over the ideal posterior mean's; below 1
    is chance. `astray` counts runs above 100 floors, and `ok of these` those of them that the method vouched for. The
    last columns are coverage, as in the table of that name.
    """
    names = {task.name: task.of.name for task in (*FRESH, *FRESH_WARPED)}  # floors go by the task itself
    return pd.DataFrame(_fresh(labelled([{**record, "task": names[record["task"]]} for record in records])))


def _fresh(frame: pd.DataFrame) -> Iterator[dict[str, Any]]:
    for task in ordered(frame["task"], TASK_ORDER):
        for method in ordered(frame[frame["task"] == task]["method"], METHOD_ORDER):
            cells = frame[(frame["task"] == task) & (frame["method"] == method)]
            best = ideal_errors(cells) if task == "weinberg" else cells["floor"].to_numpy(float)
            astray = cells["ratio"] > WORST_RUN
            away = [distance for record in cells["record"] if (distance := distances(record)) is not None]
            yield {
                "task": task,
                "method": method,
                "targets": cells["target"].nunique(),
                "inefficiency": asymmetry_inefficiency(cells) if task == "weinberg" else inefficiency_of(cells),
                "mean / floor": cells["squared_error"].mean() / best.mean(),
                "worst": cells["ratio"].max(),
                "astray": int(astray.sum()),
                "ok of these": int((astray & (cells["status"] == "ok")).sum()),
                "doubtful": int((cells["status"] == "doubtful").sum()),
                "seconds": cells["seconds"].mean(),
                **within(np.concatenate(away) if away else np.empty(0)),
            }


def within(away: NDArray[np.float64]) -> dict[str, str]:
    """The share of distances (n,) that lie within the intervals of each of LEVELS, in words; a dash of none."""
    return {
        f"within {level:.0%}": f"{(away <= norm.ppf((1 + level) / 2)).mean():.0%}" if len(away) else "-"
        for level in LEVELS
    }


def coverage(records: Records) -> pd.DataFrame:
    """One row per task and method: how many true parameters, and which share of them each level's intervals hold."""
    told = by_method(records).items()
    rows = [{"task": task, "method": method, "parameters": len(away), **within(away)} for (task, method), away in told]
    return pd.DataFrame(rows)


def growth(records: Records) -> pd.DataFrame:
    """One row per task and method, one column per number of simulated events: median squared errors over floors.

    A floor falls with that number. A ratio that stays is an error that falls as the best one does. `worst` is the
    largest ratio with the most simulated events. Where events leave signs open, absolute values are compared.
    """
    frame = labelled(records)
    frame[["task", "method"]] = [[record["task"], record["method"]] for record in records]
    signless = {task.name: task() for task in SBIBM if task.identifiable is not Task.identifiable}
    for name, task in signless.items():
        of_it = frame["task"] == name
        thetas = [[record["theta_hat"], record["theta_true"]] for record in frame.loc[of_it, "record"]]
        errors = [(np.diff(task.identifiable(np.array(pair)), axis=0) ** 2).sum() for pair in thetas]
        frame.loc[of_it, "ratio"] = errors / frame.loc[of_it, "floor"]
    order = [cell.identity["task"] for cell in EXPERIMENTS["growth"].cells()]
    frame["task"] = pd.Categorical(frame["task"], dict.fromkeys(order))
    budgets, rows = sorted(frame["budget"].unique()), []
    for (task, method), cells in frame.groupby(["task", "method"], observed=True):
        ratios = {budget: cells.loc[cells["budget"] == budget, "ratio"] for budget in budgets}
        row = {"task": task, "method": method, "targets": cells["target"].nunique()}
        row |= {f"{budget} events": each.median() for budget, each in ratios.items()}
        rows.append(row | {"worst": ratios[budgets[-1]].max()})
    return pd.DataFrame(rows)


def rivals(records: Records) -> pd.DataFrame:
    """One row per answer of a method on a task: the estimate and, where the posterior has another mean, that mean.

    `targets` says of how many targets a row is; a test takes those that both have. The inefficiency is the median
    squared error over the floor in units of an efficient estimator's; on weinberg, where the events determine c alone,
    it is the mean squared error over that of the ideal posterior mean. `avo ahead` is the p-value of a paired test, see
    `paper.quantities.ahead`. Records of tasks that are not registered are left out.
    """
    frame = labelled([record for record in records if task_of(record) is not None])
    return pd.DataFrame([row for task in ordered(frame["task"], TASK_ORDER) for row in _rivals(task, frame)])


def _rivals(task: str, frame: pd.DataFrame) -> Iterator[dict[str, Any]]:
    cells = frame[frame["task"] == task]
    of_avo = cells[cells["method"] == METHOD]
    values, statistic = (beside_ideal, ratio_of_means) if task == "weinberg" else (in_units_of_the_best, median)
    for method in ordered(cells["method"], METHOD_ORDER):
        estimates = cells[cells["method"] == method]
        means = by_mean(estimates)
        other = (estimates["spread_of"] == "posterior").any() and not means["ratio"].equals(estimates["ratio"])
        for answer, chosen in (("estimate", estimates), ("mean", means))[: 1 + other]:
            measured = values(chosen)
            yield {
                "task": task,
                "method": method,
                "answer": answer,
                "targets": chosen["target"].nunique(),
                "inefficiency": statistic(measured),
                "95 %": interval_text(measured, chosen["target"], statistic),
                "worst run / floor": worst(chosen["ratio"].to_numpy()),
                "seconds": chosen["seconds"].mean(),
                "avo ahead": "-" if method == METHOD else f"p = {ahead(of_avo, chosen):.2g}",
            }
