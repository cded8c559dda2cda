"""A diagnosis in words, at most a screen of them."""

from avobench.diagnosis.schema import Diagnosis, EffectValue, FoundEffect, Gap, Gate, Named, Value, Verdict
from avobench.diagnosis.search.posterior import CREDIBLE
from avobench.reports.diagnosis.order import sentences
from avobench.reports.numbers import p_equals, p_value

MOST_REGIONS = 4
"""The strongest; all are on the page."""
MOST_NOTES = 6
"""All are on the page."""
LEAST_PROBABLE = 0.01
"""Names with a smaller probability are in diagnosis.json only."""
SIDES = {1: "one-sided", 2: "two-sided"}


def summary(diagnosis: Diagnosis) -> str:
    """The verdict, the gap, what is missing, where the two disagree, the parameters, and notes: a line each."""
    lines = [f"{diagnosis.verdict} ({diagnosis.num_events} events)", meaning(diagnosis), gates(diagnosis)]
    line = f"gap on events kept aside, chi2/ndf, 1 if nothing is missing: {gap_of(diagnosis.gap_before)}"
    if diagnosis.gap_after is not None:
        line += f" -> {gap_of(diagnosis.gap_after)}, {p_equals(diagnosis.p_value_after)}"
    lines.append(line)
    for found in diagnosis.effects:
        lines.append(f"missing: {_found(found)}")
        if found.tied_with:
            lines.append(f"  these data do not tell it from {', '.join(map(label, found.tied_with))}")
    if probable := probabilities(diagnosis):
        lines.append(f"probability: {probable}")
    lines += [f"95 %: {models}" for models in [likely_models(diagnosis)] if models]
    for region in diagnosis.regions[:MOST_REGIONS]:
        where = f"{region.feature} " if region.feature else ""
        ends = f"{region.low:.4g} to {region.high:.4g}{in_unit(region.unit)}"
        lines.append(f"{region.kind} at {where}{ends}: {abs(region.z):.1f} sigma")
    after = diagnosis.theta_after or {}
    for name, value in diagnosis.theta_before.items():
        lines.append(f"{name} = {_value(value)}" + (f" -> {_value(after[name])}" if name in after else ""))
    if diagnosis.effects:
        lines.append("the errors of an effect's size hold if its shape is the one that was fitted")
    lines += [f"order: {sentence}" for sentence in sentences(diagnosis)[:MOST_REGIONS]]
    lines += [f"note: {note}" for note in diagnosis.notes[:MOST_NOTES]]
    lines.append(f"{diagnosis.num_simulations} simulated events, {diagnosis.seconds:.1f} s")
    return "\n".join(lines)


def gates(diagnosis: Diagnosis) -> str:
    """The p-value of each gate as it is compared with alpha, over its share of it."""
    told = f"tests, p over its share of alpha: {_each(diagnosis.gates)}"
    return told + (f" -> {_each(diagnosis.gates_after)}" if diagnosis.gates_after else "")


def _each(gates: dict[str, Gate]) -> str:
    return ", ".join(f"{name} {p_value(gate.divided)} ({SIDES[gate.sides]})" for name, gate in gates.items())


def meaning(diagnosis: Diagnosis) -> str:
    """What the verdict amounts to, in sentences that follow from the p-values, the gap and the ties."""
    before, alpha = p_equals(diagnosis.p_value_before), f"alpha = {diagnosis.alpha:g}"
    if diagnosis.verdict == Verdict.NOTHING:
        aside = ""
        if diagnosis.gap_before.low > 1:
            aside = " On the events kept aside the gap is above 1, as it is by chance once in 40 times."
        return (
            f"These data do not contradict the simulator ({before}, {alpha}).{aside} "
            "The identifiability card says what they could not have shown."
        )
    if diagnosis.verdict == Verdict.UNEXPLAINED:
        searched = diagnosis.outside is not None
        why = "and no effect of the catalogue says why" if searched else "and no effect was fitted"
        return f"Simulation and measurement disagree ({before}, {alpha}), {why}."
    return f"{_lacks(diagnosis)} {_left(diagnosis)}"


def _lacks(diagnosis: Diagnosis) -> str:
    """How far the data tell what is missing, by the effects that describe them alike."""
    alike = [1 + len(found.tied_with) for found in diagnosis.effects]
    if max(alike) == 1:
        return "The simulator lacks what follows."
    if len(alike) == 1:
        which = f"all {alike[0]} effects" if alike[0] >= len(diagnosis.candidates) else f"{alike[0]} effects"
        tell = "but not what" if alike[0] >= len(diagnosis.candidates) else "but do not tell which"
        return (
            f"These data show that something is missing, {tell}: {which} describe them alike, and the first is added."
        )
    counts = " and ".join(map(str, alike))
    return f"These data show that something is missing; of the effects that were added each is one of {counts} alike."


def _left(diagnosis: Diagnosis) -> str:
    """What is left once the effects are added."""
    p, alpha, gap = diagnosis.p_value_after, diagnosis.alpha, diagnosis.gap_after
    found = "it" if len(diagnosis.effects) == 1 else "them"
    if diagnosis.verdict == Verdict.NAMED:
        if p >= alpha:
            return f"With {found}, simulation and measurement agree ({p_equals(p)}, alpha = {alpha:g})."
        return (
            f"With {found}, {p_equals(p)} is left, below alpha = {alpha:g}: too little to look for another effect, "
            "and too much to say that simulation and measurement agree."
        )
    seen = [name for name, gate in (diagnosis.gates_after or {}).items() if gate.divided < alpha]
    gates = f"by the {' and '.join(seen) or 'tests'} ({p_equals(p)}, alpha = {alpha:g})" if p < alpha else ""
    aside = f"on the events kept aside ({gap_of(gap)})" if gap.low > 1 else ""
    unseen = " The gap is that of the summary and does not show it." if seen and "summary" not in seen else ""
    left = " and ".join(filter(None, (gates, aside)))
    return f"With {found} the gap shrinks, but a disagreement is left {left}.{unseen}"


def probabilities(diagnosis: Diagnosis) -> str:
    """Names with their probability of being in the model, and that of none of them; empty where there are none."""
    told = [(label(each), each.probability) for each in diagnosis.probabilities if each.probability >= LEAST_PROBABLE]
    if diagnosis.outside is not None:
        told.append(("nothing in the catalogue", diagnosis.outside))
    return "; ".join(f"{name}, {p:.2f}" for name, p in sorted(told, key=lambda each: -each[1]))


def likely_models(diagnosis: Diagnosis) -> str:
    """The smallest set of models that holds 95 %, with what is outside the catalogue; empty where there is none."""
    told = [(" + ".join(map(label, m.effects)) or "the simulator as it is", m.probability) for m in diagnosis.models]
    if told and sum(p for _, p in told) < CREDIBLE:
        told.append(("nothing in the catalogue", diagnosis.outside))
    return "; ".join(f"{name}, {p:.2f}" for name, p in sorted(told, key=lambda each: -each[1]))


def label(named: Named) -> str:
    """An effect and what it acts on."""
    return named.name if named.feature is None else f"{named.name} on {named.feature}"


def unit_of(parameter: EffectValue, effect: Named) -> str:
    """The unit of an effect's parameter, which says of which feature it is."""
    if effect.feature in (None, "all"):
        return parameter.unit
    named = {
        "of the feature": f"in the unit of {effect.feature}",
        "of half the range": f"of half the range of {effect.feature}",
    }
    return named.get(parameter.unit, parameter.unit)


def in_unit(unit: str) -> str:
    """A unit as it stands behind a number."""
    return "" if unit == "1" else f" {unit}"


def gap_of(gap: Gap) -> str:
    return f"{gap.value:.2f} [{gap.low:.2f}, {gap.high:.2f}]"


def _found(found: FoundEffect) -> str:
    values = ", ".join(
        f"{name} = {p.value:.4g}" + (f" +- {p.std:.2g}" if p.std is not None else "") + in_unit(unit_of(p, found))
        for name, p in found.parameters.items()
    )
    return f"{label(found)}{f' (shape {found.shape})' if found.shape else ''}: {values}"


def _value(value: Value) -> str:
    return f"{value.value:.5g} +- {value.std:.2g}"
