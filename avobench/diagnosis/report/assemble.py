"""The answer of a diagnosis, made of what the loop found."""

from dataclasses import dataclass
from importlib.metadata import version

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.report.correction import Correction
from avobench.diagnosis.report.found import Found
from avobench.diagnosis.report.identifiability import Row
from avobench.diagnosis.report.pictures import Pictures
from avobench.diagnosis.report.quoted import Move, found_effect, identified, models, named, probabilities, theta_values
from avobench.diagnosis.schema import Candidate, Diagnosis, Disorder, Gate, Identifiable, Region
from avobench.diagnosis.search.tested import Step
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
    any_named, posterior = bool(found.effects), found.posterior
    units = dict(zip(labels, found.task.feature_units, strict=False))  # none where the task does not say them
    return Diagnosis(
        verdict=found.verdict,
        alpha=found.alpha,
        p_value_before=found.steps[0].p_value,
        p_value_after=final.p_value if any_named else None,
        gates=_gates(found.steps[0]),
        gates_after=_gates(final) if any_named else None,
        gap_before=found.gap_before,
        gap_after=found.gap_after,
        theta_before=theta_values(first),
        theta_after=theta_values(last, moves) if any_named else None,
        identified_before=identified(first),
        identified_after=identified(last, moves) if any_named else None,
        effects=sorted(
            (found_effect(last, k, posterior, labels) for k in range(len(found.effects))), key=lambda e: -e.probability
        ),
        probabilities=probabilities(posterior, labels) if posterior else [],
        outside=posterior.outside if posterior else None,
        models=models(posterior, labels) if posterior else [],
        regions=[region.model_copy(update={"unit": units.get(region.feature, "1")}) for region in where],
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


def _gates(step: Step) -> dict[str, Gate]:
    return {name: gate.model_copy(update={"share": step.shares[name]}) for name, gate in step.gates.items()}


def _candidates(found: Found) -> list[Candidate]:
    """The effects that were tried on the task alone, best first."""
    if not found.candidates:
        return []
    best = found.candidates[0][0].evidence.at_least
    return [
        Candidate(
            **named(one.fit.model.effects[0].key, found.task.labels).model_dump(),
            score=best - one.evidence.at_least,
            p_value=one.fit.p_value,
            held_out_gap=gap,
        )
        for one, gap in found.candidates
    ]


def _identifiable(row: Row, task: Task) -> Identifiable:
    return Identifiable(
        **named(row.effect.key, task.labels).model_dump(),
        retained=row.retained,
        minimum_detectable=row.minimum_detectable,
        theta_bias=dict(zip(task.parameter_names, map(float, row.theta_bias), strict=False)),
        rivals=[named(rival.key, task.labels) for rival in row.rivals],
    )
