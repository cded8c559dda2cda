"""A diagnosis in words, at most a screen of them."""

from avobench.diagnosis.schema import Diagnosis, FoundEffect, Gap, Named, Value
from avobench.reports.diagnosis.order import sentences
from avobench.reports.numbers import p_equals

MOST_REGIONS = 4
"""The strongest; all are on the page."""
MOST_NOTES = 6
"""All are on the page."""


def summary(diagnosis: Diagnosis) -> str:
    """The verdict, the gap, what is missing, where the two disagree, the parameters, and notes: a line each."""
    gates = ", ".join(f"{name} {p_equals(gate.p_value)}" for name, gate in diagnosis.gates.items())
    lines = [f"{diagnosis.verdict} ({diagnosis.num_events} events, {gates}; alpha = {diagnosis.alpha:g})"]
    line = f"gap on events kept aside, chi2/ndf: {_gap(diagnosis.gap_before)}"
    if diagnosis.gap_after is not None:
        line += f" -> {_gap(diagnosis.gap_after)}, {p_equals(diagnosis.p_value_after)}"
    lines.append(line)
    for found in diagnosis.effects:
        lines.append(f"missing: {_found(found)}")
        if found.tied_with:
            lines.append(f"  these data do not tell it from {', '.join(map(label, found.tied_with))}")
    for region in diagnosis.regions[:MOST_REGIONS]:
        where = f"{region.feature} " if region.feature else ""
        lines.append(f"{region.kind} at {where}{region.low:.4g} to {region.high:.4g}: {abs(region.z):.1f} sigma")
    after = diagnosis.theta_after or {}
    for name, value in diagnosis.theta_before.items():
        lines.append(f"{name} = {_value(value)}" + (f" -> {_value(after[name])}" if name in after else ""))
    if diagnosis.effects:
        lines.append("the errors of an effect's size hold if its shape is the one that was fitted")
    lines += [f"order: {sentence}" for sentence in sentences(diagnosis)[:MOST_REGIONS]]
    lines += [f"note: {note}" for note in diagnosis.notes[:MOST_NOTES]]
    lines.append(f"{diagnosis.num_simulations} simulated events, {diagnosis.seconds:.1f} s")
    return "\n".join(lines)


def label(named: Named) -> str:
    """An effect and what it acts on."""
    return named.name if named.feature is None else f"{named.name} on {named.feature}"


def _found(found: FoundEffect) -> str:
    values = ", ".join(
        f"{name} = {p.value:.4g}"
        + (f" +- {p.std:.2g}" if p.std is not None else "")
        + (f" {p.unit}" if p.unit != "1" else "")
        for name, p in found.parameters.items()
    )
    return f"{label(found)}{f' (shape {found.shape})' if found.shape else ''}: {values}"


def _gap(gap: Gap) -> str:
    return f"{gap.value:.2f} [{gap.low:.2f}, {gap.high:.2f}]"


def _value(value: Value) -> str:
    return f"{value.value:.5g} +- {value.std:.2g}"
