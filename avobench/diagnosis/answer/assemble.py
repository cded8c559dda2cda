"""The answer of a diagnosis, made of what the loop found."""

from dataclasses import dataclass
from importlib.metadata import version

from avobench.diagnosis.answer.correction import Correction
from avobench.diagnosis.answer.found import Found
from avobench.diagnosis.answer.identifiability import Row
from avobench.diagnosis.answer.pictures import Pictures
from avobench.diagnosis.answer.quoted import Move, found_effect, identified, named, theta_values
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import Candidate, Diagnosis, Disorder, Identifiable, Region
from avobench.tasks import Task

PACKAGES = ("avobench", "numpy", "scipy", "scikit-learn")
"""Whose versions a diagnosis states: those that its numbers depend on."""


@dataclass(frozen=True)
class Result:
    """A diagnosis with what it was made of, as `diagnose` returns it."""

    task: Task
    diagnosis: Diagnosis
    """All that is said, as it stands in `diagnosis.json`."""
    fit: Fit
    """The fit of the final model, of which `model.json` is written."""
    pictures: Pictures
    """What figures are drawn from."""
    correction: Correction | None
    """Weights for simulated events, where the catalogue does not explain all."""


@dataclass(frozen=True)
class Run:
    """What a diagnosis was asked for, and what it took."""

    num_events: int
    """Measured."""
    num_simulations: int
    allowed: int | None
    """Simulated events, at most; None for as many as it takes."""
    seconds: float = 0.0
    seed: int = 0


def assemble(
    found: Found,
    last: Fit,
    moves: list[Move],
    where: list[Region],
    could: list[Row],
    notes: list[str],
    run: Run,
    disorder: list[Disorder] | None = None,
) -> Diagnosis:
    """The diagnosis.

    `last` is the final fit, `moves` say how far theta may be from it, `where` the disagreement is, and `could` what the
    data could have shown of effects that the model has not; `disorder` is what their order says, if that was asked.
    """
    first, final, labels = found.first, found.steps[-1], found.task.labels
    gap, any_named = found.held_out.gap, bool(found.effects)
    return Diagnosis(
        verdict=found.verdict,
        alpha=found.alpha,
        p_value_before=found.steps[0].p_value,
        p_value_after=final.p_value if any_named else None,
        gates=found.steps[0].gates,
        gap_before=gap(first),
        gap_after=gap(last) if any_named else None,
        theta_before=theta_values(first),
        theta_after=theta_values(last, moves) if any_named else None,
        identified_before=identified(first),
        identified_after=identified(last, moves) if any_named else None,
        effects=[found_effect(last, k, step.ties, labels) for k, step in enumerate(found.steps[:-1])],
        regions=where,
        candidates=_candidates(found),
        identifiability=[_identifiable(row, found.task) for row in could],
        order=disorder,
        notes=notes,
        num_events=run.num_events,
        num_simulations=run.num_simulations,
        seconds=run.seconds,
        seed=run.seed,
        versions={name: version(name) for name in PACKAGES},
    )


def _candidates(found: Found) -> list[Candidate]:
    """The effects that were tried on the task alone, best first."""
    return [
        Candidate(
            **named(entry.effect, found.task.labels).model_dump(),
            score=entry.score,
            p_value=entry.fit.p_value,
            held_out_gap=found.held_out.gap(entry.fit).value,
        )
        for entry in found.steps[0].ranks
    ]


def _identifiable(row: Row, task: Task) -> Identifiable:
    return Identifiable(
        **named(row.effect, task.labels).model_dump(),
        retained=row.retained,
        minimum_detectable=row.minimum_detectable,
        theta_bias=dict(zip(task.parameter_names, map(float, row.theta_bias), strict=False)),
        rivals=[named(rival, task.labels) for rival in row.rivals],
    )
