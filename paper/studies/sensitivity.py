"""How good plain Algorithm 1 can be: `python -m paper.study sensitivity`.

`avo-paper`, without replay and polish, with other values of what the paper prints, on development targets: first lambda
on either reading of R1 with all else as printed, then one setting at a time around a faster run, then combinations of
what helped. `paper.tables.sensitivity` prints the table from which `avo-plain` has its defaults.
"""

from typing import Any

from avobench.bench.cells.cell import Cell
from paper.studies import development
from paper.studies.paper import NUM_OBSERVATIONS

BUDGET = 160_000
"""That of the benchmark."""
TASKS = ("poisson", "carl")
READINGS = {"d": {"r1_of": "probability"}, "logit": {"r1_of": "logit"}}
"""What R1 takes the input gradient of."""
PENALTIES = (0.1, 1.0, 10.0)
NARROW = {"hidden": [64, 64]}
"""A network that takes an eighth of the time of the paper's on poisson."""
FASTER = {**NARROW, "batch_size": 128, "proposal_learning_rate": 1e-2}
"""A quarter of the iterations, each of the proposal ten times as far."""
_ONE_AT_A_TIME: dict[str, dict[str, Any]] = {
    "M = 32": {"batch_size": 32},
    "M = 512": {"batch_size": 512},
    "shared": {"schedule": "shared"},
    "rate of d 1e-4": {"learning_rate": 1e-4},
    "rate of d 1e-2": {"learning_rate": 1e-2},
    "rate of q 1e-3": {"proposal_learning_rate": 1e-3},
    "rate of q 1e-1": {"proposal_learning_rate": 1e-1},
}
AS_PRINTED: dict[str, dict[str, Any]] = {
    "as printed, R1 of d, 10": {},
    "as printed, R1 of logit, 10": READINGS["logit"],
    "as printed, no R1": {"r1": 0.0},
    "narrow, no R1": {**NARROW, "r1": 0.0},
    **{
        f"narrow, R1 of {what}, {penalty:g}": {**NARROW, **reading, "r1": penalty}
        for what, reading in READINGS.items()
        for penalty in PENALTIES
    },
}
AROUND: dict[str, dict[str, Any]] = {
    "faster, no R1": {**FASTER, "r1": 0.0},
    **{
        f"faster, R1 of {what}, {penalty:g}": {**FASTER, **reading, "r1": penalty}
        for what, reading in READINGS.items()
        for penalty in PENALTIES
    },
    **{
        f"faster, R1 of {what}, 1, {label}": {**FASTER, **reading, "r1": 1.0, **settings}
        for what, reading in READINGS.items()
        for label, settings in _ONE_AT_A_TIME.items()
    },
}
_SHARED = {**NARROW, "schedule": "shared"}
COMBINED: dict[str, dict[str, Any]] = {
    f"shared, M = {m}, rate of q {rate:g}, R1 of {what}, {penalty:g}{label}": {
        **_SHARED,
        "batch_size": m,
        "proposal_learning_rate": rate,
        **READINGS[what],
        "r1": penalty,
        **settings,
    }
    for m, rate, what, penalty, label, settings in (
        (64, 1.5e-3, "logit", 0.1, "", {}),
        (128, 3e-3, "d", 0.1, "", {}),
        (128, 3e-3, "logit", 0.1, "", {}),
        (128, 3e-3, "logit", 1.0, "", {}),
        (128, 3e-3, "logit", 0.1, ", rate of d 3e-3", {"learning_rate": 3e-3}),
        (256, 5e-3, "logit", 0.1, "", {}),
        (256, 5e-3, "logit", 0.1, ", rate of d 3e-3", {"learning_rate": 3e-3}),
        (512, 5e-3, "logit", 0.1, "", {}),
        (512, 1e-2, "logit", 0.1, "", {}),
        (512, 5e-3, "logit", 0.1, ", rate of d 3e-3", {"learning_rate": 3e-3}),
    )
}
CANDIDATES: dict[str, tuple[dict[str, Any], int]] = {
    **{label: (settings, 1) for label, settings in AS_PRINTED.items()},
    **{label: (settings, 1) for label, settings in AROUND.items()},
    **{label: (settings, 2) for label, settings in COMBINED.items()},
}
"""By what the table calls them, settings of `avo-paper` and the number of development targets of each task: one where a
cell takes long. *Narrow* and *faster* are NARROW and FASTER, the number after R1 is lambda, M the size of a batch, d
the discriminator and q the proposal; what is not named is as printed."""


def candidate(label: str, task: str) -> list[Cell]:
    """The cells of one of CANDIDATES on the development targets of a task."""
    settings, num_targets = CANDIDATES[label]
    return [
        Cell(development.spec(task), {}, "avo-paper", settings, target, 0, BUDGET, NUM_OBSERVATIONS, development.SEED)
        for target in range(num_targets)
    ]


def cells() -> list[Cell]:
    """All of them, in the order of the table."""
    return [cell for label in CANDIDATES for task in TASKS for cell in candidate(label, task)]
