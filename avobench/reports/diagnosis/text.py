"""A diagnosis in words: a summary of about ten lines, and all details in a screen of them."""

from avobench.diagnosis.schema import (
    Decision,
    Diagnosis,
    EffectValue,
    FoundEffect,
    Gap,
    GateResult,
    Named,
    Place,
    Verdict,
)
from avobench.diagnosis.settings import SCORE
from avobench.reports.diagnosis.order import sentences
from avobench.reports.numbers import in_unit, p_equals, p_value, with_error

MOST_REGIONS = 4
"""The strongest regions are told; all are on the page."""
MOST_NOTES = 6
"""The first notes are told; all are on the page."""
LEAST_PROBABLE = 0.01
"""Names with a smaller probability are in diagnosis.json only."""
SIDES = {1: "one-sided", 2: "two-sided"}
OUTSIDE = "something outside the catalogue"
MEANT = (
    f"These probabilities were calibrated on {SCORE.calibrated[0]} other data sets whose answer is known; "
    f"in {SCORE.calibrated[1]} of them the effect is outside the catalogue."
)
"""What the probabilities mean."""
FAINT = 0.02
"""Probability of a model below which `summary` counts it and `details` names it."""
CLEARLY = 1.5
"""Factor by which the largest excess must exceed the largest deficit, or be exceeded, to be all that there is."""
ALIKE = 6.0
"""Difference of chi-squared, a likelihood ratio of twenty, up to which it speaks for neither of two models."""
THETA = (
    "These errors of the parameters allow for what the simulator may lack. "
    "Those of infer do not: it takes the simulator as right."
)
"""Why the errors differ from those that a fit quotes for the same parameters."""
READ = " (read off the events)"
"""What is said of a value that has no error."""
ASSUMED = "Errors on effect parameters assume that the fitted shape is true."


def summary(diagnosis: Diagnosis) -> str:
    """The verdict, each effect with its size, the 95 % set, and the gap and theta before and after."""
    lines = [_verdict(diagnosis), meaning(diagnosis), *doubtful(diagnosis)]
    lines += [f"{_role(diagnosis)}: {_effect(effect)}" for effect in diagnosis.effects]
    lines += [f"95 % set of models: {models}\n{MEANT}" for models in [likely_models(diagnosis, FAINT)] if models]
    asked = [each for each in diagnosis.decisions if each.events and not each.condition]
    lines += [_decision(each, diagnosis) for each in asked[:1]]
    lines += [*_chi_squared(diagnosis), _gap(diagnosis), *_theta(diagnosis)]
    lines.append(f"{diagnosis.num_simulations} simulated events; details() tells the rest.")
    return "\n".join(lines)


def details(diagnosis: Diagnosis) -> str:
    """What `summary` says, with each test, the probabilities, where simulation and measurement disagree, and notes."""
    lines = [
        _verdict(diagnosis),
        meaning(diagnosis),
        *doubtful(diagnosis),
        gates(diagnosis),
        *_chi_squared(diagnosis),
        _gap(diagnosis),
    ]
    for effect in diagnosis.effects:
        lines.append(f"{_role(diagnosis)}: {_effect(effect)}")
        if effect.tied_with:
            lines.append(f"  others of the 95 % set: {', '.join(map(label, effect.tied_with))}")
    lines += [f"probability of being missing: {names}" for names in [probabilities(diagnosis)] if names]
    lines += [f"95 % set of models: {models}\n{MEANT}" for models in [likely_models(diagnosis)] if models]
    lines += decisions(diagnosis)
    lines += [f"{where(region)}: {abs(region.z):.1f} sigma" for region in diagnosis.regions[:MOST_REGIONS]]
    lines += _theta(diagnosis)
    if diagnosis.effects:
        lines.append(ASSUMED)
    lines += [f"order: {sentence}" for sentence in sentences(diagnosis)[:MOST_REGIONS]]
    lines += [f"note: {note}" for note in diagnosis.notes[:MOST_NOTES]]
    lines.append(f"{diagnosis.num_simulations} simulated events, {diagnosis.seconds:.1f} s")
    return "\n".join(lines)


def gates(diagnosis: Diagnosis) -> str:
    """The p-value of each test, divided by its share of alpha, as it is compared with alpha."""
    line = f"corrected p-values (compare with {diagnosis.alpha:g}): {_each(diagnosis.gates)}"
    return line + (f" -> {_each(diagnosis.gates_after)}" if diagnosis.gates_after else "")


def _each(gates: dict[str, GateResult]) -> str:
    return ", ".join(f"{name} {p_value(gate.corrected)} ({SIDES[gate.sides]})" for name, gate in gates.items())


def meaning(diagnosis: Diagnosis) -> str:
    """What the verdict amounts to, in sentences that follow from the p-values, the gap and the ties."""
    before, alpha = p_equals(diagnosis.p_value_before), f"alpha = {diagnosis.alpha:g}"
    if diagnosis.verdict == Verdict.NOTHING:
        above = ""
        if diagnosis.gap_before.low > 1:
            above = f" On {aside(diagnosis)} the gap is above 1, as it is by chance once in 40 times."
        return (
            f"These data do not contradict the simulator ({before}, {alpha}).{above} "
            "The identifiability card says what they could not have shown."
        )
    if diagnosis.verdict == Verdict.UNEXPLAINED:
        searched = diagnosis.outside is not None
        unsearched = "and no effect was fitted for want of simulated events; details() says how many mostly do"
        why = "and no effect of the catalogue explains it" if searched else unsearched
        return f"Simulation and measurement disagree ({before}, {alpha}), {why}. {look(diagnosis)}".rstrip()
    return f"{_lacking(diagnosis)} {_remaining_disagreement(diagnosis)}"


def look(diagnosis: Diagnosis) -> str:
    """Where measurement and simulation differ most, and whether as if events were added, lost or moved."""
    by_size = sorted(diagnosis.regions, key=lambda region: -abs(region.z))
    if not by_size:
        return ""
    if by_size[0].kind == "dependence":
        return f"They differ most in {where(by_size[0])}."
    more, fewer = (max([abs(r.z) for r in by_size if r.kind == kind], default=0.0) for kind in ("excess", "deficit"))
    how = "added" if more > CLEARLY * fewer else "lost" if fewer > CLEARLY * more else "moved"
    places = {region.kind: where(region) for region in reversed(by_size) if region.kind != "dependence"}
    return f"It looks as if events were {how}: {' and '.join(places.values())}."


def decisions(diagnosis: Diagnosis) -> list[str]:
    """A sentence on each other model of the 95 % set, the most probable first: what would tell it from the first."""
    return [_decision(each, diagnosis) for each in diagnosis.decisions if not each.condition]


def _decision(same: Decision, diagnosis: Diagnosis) -> str:
    """More events of the same kind, and of the one of several data sets that tells most."""
    pair = f"{model(same.true)} from {model(same.rival)}"
    of_pair = [each for each in diagnosis.decisions if (each.true, each.rival) == (same.true, same.rival)]
    alone = [each for each in of_pair if each.condition and each.events]
    best = min(alone, key=lambda each: each.events, default=None)
    of_one = f" {_events(best)} of {best.condition} alone would." if best else ""
    if same.events is None:
        if same.low is None:
            return f"No number of events tells {pair}: they look the same.{of_one}"
        least = f": at least {_rounded(same.low)}" if same.low else ""
        return f"It is not known how many more events would tell {pair}{least}.{of_one}"
    if same.events == 0:
        by = f"{abs(same.chi_squared):.0f} {'larger' if same.chi_squared > 0 else 'smaller'} with {model(same.rival)}"
        if abs(same.chi_squared) <= ALIKE:
            return f"Were either right, these events would tell {pair}: probably neither is, chi-squared is only {by}."
        ahead, behind = (same.true, same.rival) if same.chi_squared > 0 else (same.rival, same.true)
        return f"These events speak for {model(ahead)} rather than {model(behind)}: chi-squared is {by}."
    its = "its " if same.where and same.where.kind != "dependence" else ""
    place = f" {100 * same.share:.0f} % of the difference is {its}{where(same.where)}." if same.where else ""
    return f"{_events(same)} would tell {pair}.{place}{of_one}"


def _events(decision: Decision) -> str:
    return f"{_rounded(decision.events)} more events ({_rounded(decision.low)} to {_rounded(decision.high)})"


def _rounded(number: int) -> str:
    """Two digits, and thousands apart."""
    return f"{int(float(f'{number:.1e}')):,}".replace(",", " ")


def where(region: Place) -> str:
    """A region in words."""
    if region.kind == "dependence":
        return "what all features have in common" if region.feature == "all" else f"the dependence of {region.feature}"
    if region.low is None:
        return f"{region.kind} of events that lack {region.feature}"
    of = f"{region.feature} " if region.feature else ""
    return f"{region.kind} at {of}{region.low:.4g} to {region.high:.4g}{in_unit(region.unit)}"


def _lacking(diagnosis: Diagnosis) -> str:
    """The sentence about what is missing, by the number of effects that replace each other in the 95 % set."""
    tied = [1 + len(effect.tied_with) for effect in diagnosis.effects]
    if max(tied) == 1:
        names = " and ".join(map(label, diagnosis.effects))
        if diagnosis.verdict == Verdict.FAMILY:
            return f"What the simulator lacks is most like {names}, but the catalogue does not have its shape."
        return f"What the simulator lacks is most probably {names}."
    if len(tied) == 1:
        which = f"the 95 % set has {tied[0]}. The most probable one is added."
    else:
        which = f"each that is added is one of {' and '.join(map(str, tied))} of the 95 % set."
    return f"Something is missing, but these data do not tell for sure which effect: {which}"


def _remaining_disagreement(diagnosis: Diagnosis) -> str:
    """A sentence on the disagreement that remains with the added effects."""
    p, alpha, gap = diagnosis.p_value_after, diagnosis.alpha, diagnosis.gap_after
    added = "it" if len(diagnosis.effects) == 1 else "them"
    if diagnosis.verdict == Verdict.NAMED:
        if p >= alpha:
            return f"With {added}, simulation and measurement agree ({p_equals(p)}, alpha = {alpha:g})."
        return (
            f"With {added}, {p_equals(p)} is left, below alpha = {alpha:g}: too little to look for another effect, "
            "and too much to say that simulation and measurement agree."
        )
    rejecting = [name for name, gate in (diagnosis.gates_after or {}).items() if gate.corrected < alpha]
    tests = f"by the {' and '.join(rejecting) or 'tests'} ({p_equals(p)}, alpha = {alpha:g})" if p < alpha else ""
    apart = f"on {aside(diagnosis)} ({gap_of(gap)})" if gap.low > 1 else ""
    hidden = rejecting and "summary" not in rejecting
    evidence = " and ".join(filter(None, (tests, apart)))
    shrinks = "the gap shrinks, but" if gap.value < diagnosis.gap_before.value else "the gap is no smaller, and"
    return f"With {added} {shrinks} a disagreement is left {evidence}." + (
        " The gap is that of the summary and does not show it." if hidden else ""
    )


def _role(diagnosis: Diagnosis) -> str:
    """What an effect of the answer is: what is missing, or what is nearest to that."""
    return "missing" if diagnosis.verdict == Verdict.NAMED else "nearest"


def probabilities(diagnosis: Diagnosis) -> str:
    """Names with their probability of being in the model, and that of none of them; empty where there are none."""
    names = [(label(each), each.probability) for each in diagnosis.probabilities if each.probability >= LEAST_PROBABLE]
    if diagnosis.outside is not None:
        names.append((OUTSIDE, diagnosis.outside))
    return _ranked(names)


def likely_models(diagnosis: Diagnosis, least: float = 0.0) -> str:
    """The smallest set of models that holds 95 % of what was weighed, and what else it may be; empty where none was.

    Models whose probability is below `least` are counted only.
    """
    if not diagnosis.models:
        return ""
    models = [(model(each.effects), each.probability) for each in diagnosis.models if each.probability >= least]
    other = (("another set of effects", diagnosis.others), (OUTSIDE, diagnosis.outside))
    beside = [(name, p) for name, p in other if p is not None]
    counted = len(diagnosis.models) - len(models)
    more = f"; {counted} more, each below {least:g}" if counted else ""
    return f"{_ranked(models)}{more}. Not in the set: {_ranked(beside)}"


def model(effects: list[Named]) -> str:
    """A set of effects."""
    return " + ".join(map(label, effects)) or "the simulator as it is"


def _ranked(names: list[tuple[str, float]]) -> str:
    return "; ".join(f"{name}, {p:.2f}" for name, p in sorted(names, key=lambda each: -each[1]))


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


def gap_of(gap: Gap) -> str:
    return f"{gap.value:.2f} [{gap.low:.2f}, {gap.high:.2f}]"


def _verdict(diagnosis: Diagnosis) -> str:
    return f"{diagnosis.verdict} ({measured(diagnosis)})"


def doubtful(diagnosis: Diagnosis) -> list[str]:
    """Why the answer may be wrong, in a line, or no line."""
    if not diagnosis.doubt:
        return []
    what = "" if diagnosis.verdict == Verdict.NOTHING else ". The disagreement may come of this alone"
    return [f"doubtful: {diagnosis.doubt}{what}"]


def measured(diagnosis: Diagnosis) -> str:
    """How much was measured."""
    if diagnosis.num_events is not None:
        return f"{diagnosis.num_events} events"
    kinds = [table.kind for table in diagnosis.tables]
    counted = {"data set": kinds.count("events"), "table": kinds.count("table")}
    words = [f"{n} {what}{'s' * (n > 1)}" for what, n in counted.items() if n]
    return f"{', '.join(words)}, {sum(table.dof for table in diagnosis.tables)} degrees of freedom"


def aside(diagnosis: Diagnosis) -> str:
    """What the gap was measured on."""
    return "held-out events" if diagnosis.num_events is not None else "what was kept aside"


def _chi_squared(diagnosis: Diagnosis) -> list[str]:
    """A line for each table, with theta fitted, before and after."""
    lines = []
    for table in diagnosis.tables:
        after = "" if table.chi_squared_after is None else f" -> {table.chi_squared_after:.1f}"
        lines.append(f"chi-squared of {table.name}: {table.chi_squared_before:.1f}{after}, dof {table.dof}")
    return lines


def _gap(diagnosis: Diagnosis) -> str:
    before, after = diagnosis.gap_before, diagnosis.gap_after
    line = f"gap on {aside(diagnosis)} (chi2/ndf, 1 if nothing is missing"
    if after is None:
        return f"{line}): {gap_of(before)}"
    return f"{line}; as it is -> with what is added): {gap_of(before)} -> {gap_of(after)}"


def _theta(diagnosis: Diagnosis) -> list[str]:
    """One line per parameter of the task, before and after, and what their errors are."""
    after = diagnosis.theta_after or {}
    lines = [
        f"{name} = {' -> '.join(with_error(each.value, each.std) for each in (before, after.get(name)) if each)}"
        for name, before in diagnosis.theta_before.items()
    ]
    return [*lines, THETA] if lines else []


def _effect(effect: FoundEffect) -> str:
    values = ", ".join(
        f"{name} = {with_error(p.value, p.std)}{in_unit(unit_of(p, effect))}{READ * (p.std is None)}"
        for name, p in effect.parameters.items()
    )
    return f"{label(effect)}{f' (shape {effect.shape})' if effect.shape else ''}: {values}"
