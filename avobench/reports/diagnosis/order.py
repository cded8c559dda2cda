"""Sentences on the order of events, one for each finding."""

from avobench.diagnosis.schema import Diagnosis, Disorder
from avobench.reports.numbers import number, p_equals

NOTHING = "nothing contradicts that events are exchangeable"
TAKEN = "all other tests take events as exchangeable, which these are not"


def sentences(diagnosis: Diagnosis) -> list[str]:
    """The findings, the surest first; one sentence where there are none, and nothing where it was not asked."""
    if diagnosis.order is None:
        return []
    if not diagnosis.order:
        return [NOTHING]
    findings = [_sentence(one) for one in diagnosis.order]
    return [*findings, TAKEN] if any(one.of != "rate" for one in diagnosis.order) else findings


def _sentence(one: Disorder) -> str:
    what = {"level": one.feature or "the count", "spread": f"the spread of {one.feature or 'the count'}"}.get(
        one.of, "the rate of events"
    )
    size = f"{one.size:+.3g} ({one.unit})"
    in_time = one.along == "time"
    if one.kind == "drift":
        sentence = f"{what} drifts by {size} from the first event to the last"
    elif one.kind == "change point":
        sentence = f"{what} changes by {size} at " + (f"time {one.at:.6g}" if in_time else f"event {one.at:.0f}")
    elif one.kind == "season":
        period = f"{one.at:.6g} in time" if in_time else f"{one.at:.4g} events"
        sentence = f"{what} has a season of period {period} and amplitude {number(one.size)} ({one.unit})"
    elif one.of == "rate":
        sentence = f"events come in clusters, {size} in counts of {one.at:.0f} intervals apart"
    else:
        sentence = f"{what} is alike in events {one.at:.0f} apart, {size}"
    return f"{sentence}, {p_equals(one.p_value)}"
