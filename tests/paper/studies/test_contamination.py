"""The study of outliers: what there is to find."""

from pathlib import Path

import numpy as np
import pytest

from paper.figures import contamination as report
from paper.studies import contamination as study


def test_the_minimiser_of_the_divergence_is_the_clean_theta_for_far_outliers_and_else_between():
    tasks = study.contaminated()
    assert abs(tasks["normal"].minimiser(np.array([0.0]), 0.05)[0]) < 1e-3
    assert 1e-3 < tasks["normal"].minimiser(np.array([1.5]), 0.2)[0] - 1.5 < 0.1
    weinberg, theta = tasks["weinberg"], np.array([44.0, 1.0])
    c = weinberg.task.identifiable(np.stack([theta, weinberg.minimiser(theta, 0.2)]))[:, 0]
    assert c[1] > c[0] + 0.1  # outliers at a large cosine raise the asymmetry
    assert tasks["near"].minimiser(at := tasks["near"].task.targets()[0], 0.2) > at + 0.1  # no fit leaves them out
    hole = tasks["hole"]
    assert hole.density_of_outliers(hole.points).sum() * np.diff(hole.points)[0] == pytest.approx(1, abs=1e-3)
    assert abs(hole.outliers(20_000, np.random.default_rng(0)).mean() - at[0] + 0.0725) < 0.03
    assert tasks["tails"].minimiser(np.array([0.3, 0.2]), 1.0) == pytest.approx([0.4, 0.2997], abs=1e-3)


def test_means_move_by_the_outliers(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "METHODS", {"smm": ("smm", {})})
    monkeypatch.setattr(study, "NUM_TARGETS", 1)
    record = study.made(tmp_path / study.FILE.name, tasks=("normal",), num_events=5000, budget=8000)
    clean, moved = record["runs"][0], record["runs"][-1]
    assert abs(clean["estimate"][0] - clean["theta"][0]) < 5 * clean["error"][0]
    expected = 0.8 * moved["theta"][0] + 0.2 * 6
    assert abs(moved["estimate"][0] - min(expected, 2)) < 0.2  # the mean of all events, or the edge of the prior
    numbers = report.table([record])
    assert numbers["pull"][0] < 5 < numbers["pull"][3]
    report.drawn([record])


def test_an_effect_moves_the_minimiser_as_it_moves_the_events():
    """A shift of all events shifts the mean of a Gaussian; an acceptance of one side moves the slope of a cosine."""
    tasks = study.with_effects()
    assert {name.partition(":")[0] for name in tasks} == {"poisson", "gaussian", "cosine"}
    shifted, theta = tasks["gaussian: offset"], tasks["gaussian: offset"].task.targets()[0]
    by = (shifted.outliers(100_000, np.random.default_rng(0)) - theta[0]).mean()
    assert shifted.minimiser(theta, 1.0) - theta == pytest.approx([by, 0], abs=0.03)
    assert abs(by) > 0.1
    kept = tasks["cosine: forward_backward_acceptance"]
    c = kept.task.targets()[0]
    mean = kept.outliers(400_000, np.random.default_rng(0)).mean()
    # E[x] = c / 4 of the density that the divergence is least to, where the effect is weak
    assert kept.minimiser(c, 1.0)[0] - c[0] == pytest.approx(4 * mean - c[0], rel=0.2)


def run(task, estimate, **given):
    """A run of the study with the least error at one parameter, unless something else is given."""
    plain = {"share": 1.0, "target": 0, "row": "avo", "seconds": 1.0, "doubt": "", "minimiser": [0.0], "error": [1.0]}
    return {"task": task, "estimate": estimate, **plain, **given}


def test_a_doubted_fit_is_marked_and_has_the_pull_of_its_farthest_parameter():
    of = {"theta": [0.0, 0.0], "minimiser": [0.0, 0.0], "error": [1.0, 0.5]}
    records = [{"runs": [run("tails", [3.0, 4.0], row="smm", **of), run("tails", [3.0, -1.0], doubt="far", **of)]}]
    [errors] = report.compared(records).to_dict("records")
    [pulls] = report.compared(records, "worst pull").to_dict("records")
    assert (errors["smm"].strip(), errors["avo"]) == ("25", "10 D")
    assert (pulls["smm"].strip(), pulls["avo"]) == ("8", "3 D")


def test_the_table_of_effects_counts_what_is_far_off_without_a_doubt():
    runs = [run("normal: a", [5]), run("normal: b", [9], doubt="d"), run("normal: c", [1])]
    [row] = report.effects([{"runs": runs}]).to_dict("records")
    assert (row["effects"], row["median pull"], row["worst pull"]) == (3, 5, 9)
    assert (row["beyond 4"], row["undoubted"], row["doubted"]) == (2, 1, 1)


def test_the_table_of_outliers_counts_wrong_simulators_alone():
    runs = [run("normal", [off], share=share) for share, off in ((0.0, 9), (0.05, 5), (0.2, 1))]
    runs += [run("normal", [99], share=0.05, error=None), run("weinberg", [99, 99], share=0.2, error=[1.0, 1.0])]
    [row] = report.outliers([{"runs": runs}]).to_dict("records")
    assert (row["fits"], row["median pull"], row["worst pull"], row["undoubted"]) == (2, 3, 5, 1)


def test_what_the_pages_say_of_outliers_is_what_the_record_holds():
    record = study.FILE.read(Path("results/studies"))
    counted = report.outliers([record]).set_index("method")
    assert counted.loc[["avo-robust", "avo", "smm"], "beyond 4"].tolist() == [2, 20, 20]
    assert (counted["fits"]["avo"], counted["undoubted"]["avo-robust"]) == (41, 0)
    wrong = report.table([record]).query("share > 0").pivot(index=["task", "share"], columns="method")["to minimiser"]
    assert ((wrong["avo"] < wrong["avo-robust"]).sum(), len(wrong)) == (6, 18)
