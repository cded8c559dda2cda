"""What a reader of a diagnosis should know beside its numbers, a sentence each."""

from avobench.diagnosis.answer.assemble import Run
from avobench.diagnosis.answer.found import Found
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.method import Inferred
from avobench.diagnosis.schema import Verdict

FEW_EVENTS = 1000
"""Measured events below which a summary has so few bins that it is worth a word."""
FAINT = 10.0
"""Chi-squared per degree of freedom below which, in the challenge, effects that were taken out of the catalogue were
often explained by others, and above which they seldom were (docs/challenge.md)."""


def notes_of(found: Found, last: Fit, inferred: Inferred | None, run: Run) -> list[str]:
    """The notes on what was found, with the `last` fit, by a diagnosis that began at `inferred`."""
    notes = []
    gap = found.held_out.gap(found.first).value
    if found.verdict == Verdict.NAMED and gap < FAINT:
        notes.append(
            f"a gap of {gap:.2g} seldom excludes that an effect outside the catalogue did this: compare "
            "docs/challenge.md"
        )
    if inferred is not None:
        notes.append(inferred.note(found.first))
    if run.num_events < FEW_EVENTS:
        notes.append(
            f"{run.num_events} events make {found.target.rank} bins or less: the card says what so few cannot show"
        )
    return notes + bound_notes(last)


def bound_notes(fit: Fit) -> list[str]:
    """Parameters of the fit that ended at an end of their range."""
    names = [*fit.model.task.parameter_names, *(f"{e.name}: {p.name}" for e in fit.model.effects for p in e.parameters)]
    ends = {1: "upper", -1: "lower"}
    return [
        f"the fit ended at the {ends[at]} bound of {n}"
        for n, at in zip(names, fit.at_bound.tolist(), strict=True)
        if at
    ]
