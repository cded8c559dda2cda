"""What a reader of a diagnosis should know beside its numbers, a sentence each."""

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.method import Inferred
from avobench.diagnosis.report.assemble import Run
from avobench.diagnosis.report.found import Found
from avobench.diagnosis.schema import Verdict

FEW_EVENTS = 1000
"""Measured events below which a summary has so few bins that it is worth a word."""
FAINT = 10.0
"""Chi-squared per degree of freedom below which, in the challenge, effects that were taken out of the catalogue were
often explained by others, and above which they seldom were (docs/challenge.md)."""


def notes_of(found: Found, last: Fit, inferred: Inferred | None, run: Run) -> list[str]:
    """The notes on what was found, with the `last` fit, by a diagnosis that began at `inferred`."""
    notes = []
    gap = found.gap_before
    if found.verdict == Verdict.NAMED and gap.value < FAINT:
        notes.append(
            f"a gap of {gap.value:.2g} seldom excludes that an effect outside the catalogue did this: compare "
            "docs/challenge.md"
        )
    if found.withdrawn:
        names = " and ".join(effect.name for effect in found.withdrawn)
        notes.append(f"{names} was tried and left out: on the events kept aside the gap shrank by less than its error")
    if found.disagree and gap.low <= 1:
        notes.append(unseen(found))
    if inferred is not None:
        notes.append(inferred.note(found.first))
    if run.num_events < FEW_EVENTS:
        notes.append(
            f"{run.num_events} events make {found.target.rank} bins or less: the card says what so few cannot show"
        )
    notes += prior_notes(found.first, "without effects")
    if found.effects:
        notes += prior_notes(last, "with what was added")
    return notes + bound_notes(last)


def unseen(found: Found) -> str:
    """Why there is a disagreement, though the events kept aside show no gap."""
    gates = found.steps[0].gates
    seen = [name for name, gate in gates.items() if gate.p_value / found.steps[0].shares[name] < found.alpha]
    if "summary" in seen:
        return "the events kept aside are too few to show by themselves what the others show"
    return f"the gap is of the summary, and does not show what the {' and '.join(seen)} saw"


def prior_notes(fit: Fit, how: str) -> list[str]:
    """Parameters of the task that were fitted to a value outside the prior; `how` says by which fit."""
    task = fit.model.task
    fitted = zip(task.parameter_names, fit.params.tolist(), task.prior.low, task.prior.high, strict=False)
    return [
        f"{name} = {value:.4g}, fitted {how}, lies outside its prior, {low:g} to {high:g}"
        for name, value, low, high in fitted
        if not low <= value <= high
    ]


def bound_notes(fit: Fit) -> list[str]:
    """Parameters of the fit that ended at an end of their range."""
    names = [*fit.model.task.parameter_names, *(f"{e.name}: {p.name}" for e in fit.model.effects for p in e.parameters)]
    ends = {1: "upper", -1: "lower"}
    return [
        f"the fit ended at the {ends[at]} bound of {n}"
        for n, at in zip(names, fit.at_bound.tolist(), strict=True)
        if at
    ]
