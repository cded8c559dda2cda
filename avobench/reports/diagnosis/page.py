"""The page of a diagnosis: one file that needs no network."""

from collections.abc import Iterator

from avobench.diagnosis import Result
from avobench.diagnosis.schema import Diagnosis, EffectValue, Value
from avobench.diagnosis.settings import TEST
from avobench.reports import html
from avobench.reports.diagnosis import text as words
from avobench.reports.diagnosis.order import sentences
from avobench.reports.numbers import number, p_equals, p_value, with_error
from avobench.tasks import Task

PARAMETERS = "θ as fitted without effects, and with the effects that were added."
SIZE = (
    f" {words.ASSUMED} Where nature's effect has another shape than the catalogue's, such as longer tails, the fitted "
    "size stands in for that shape as well, and may lie many errors from the size of nature's."
)


def render(task: Task, result: Result, figures: list[html.Picture | html.Missing], title: str) -> str:
    """The page as HTML; whatever comes from the user, such as the title, is shown as text."""
    diagnosis, added = result.diagnosis, result.fit.model.effects
    return html.page(
        "diagnosis/page.html.jinja",
        title=title,
        task=task,
        diagnosis=diagnosis,
        words=words,
        probabilities=words.probabilities(diagnosis),
        models=words.likely_models(diagnosis),
        decisions=words.decisions(diagnosis),
        figures=figures,
        tables=list(_tables(task, diagnosis)),
        order=sentences(diagnosis),
        sentences={(effect.name, effect.shape): effect.sentence for effect in added},
        number=number,
        p_equals=p_equals,
    )


def _tables(task: Task, diagnosis: Diagnosis) -> Iterator[html.Table]:
    yield _parameters(task, diagnosis)
    yield _tests(diagnosis)
    yield _regions(diagnosis)
    if diagnosis.tables:
        yield _of_tables(diagnosis)
    if diagnosis.candidates:
        yield _candidates(diagnosis)
    if diagnosis.identifiability:
        yield _identifiability(diagnosis)


def _parameters(task: Task, diagnosis: Diagnosis) -> html.Table:
    after = diagnosis.theta_after or {}
    units = dict(zip(task.parameter_names, task.parameter_units, strict=True))
    rows = []
    for name, before in diagnosis.theta_before.items():
        title, unit = html.texts([name, _unit(units.get(name, "1"))])
        rows.append((title, _value(before), _value(after.get(name)), unit))
    for effect in diagnosis.effects:
        for name, parameter in effect.parameters.items():
            title, unit = html.texts([f"{words.label(effect)}: {name}", _unit(words.unit_of(parameter, effect))])
            null = html.Cell(number(parameter.null), html.key(parameter.null), True)
            rows.append((title, null, _value(parameter), unit))
    text = PARAMETERS + SIZE * bool(diagnosis.effects)
    columns = ["parameter", "before", "after", "unit"]
    if not any(unit.text for *_, unit in rows):
        columns, rows = columns[:-1], [row[:-1] for row in rows]
    return html.Table("theta", "Parameters", text, columns, rows)


def _unit(unit: str) -> str:
    """A unit in a table; none for a pure number."""
    return "" if unit == "1" else unit


def _value(fitted: Value | EffectValue | None) -> html.Cell:
    """A value with its error; a dash where nothing was fitted."""
    if fitted is None:
        return html.Cell("-", "", True)
    return html.Cell(with_error(fitted.value, fitted.std), html.key(fitted.value), True)


def _tests(diagnosis: Diagnosis) -> html.Table:
    stages = {"as it is": diagnosis.gates, "with the added effects": diagnosis.gates_after or {}}
    rows = [(when, name, gate) for when, gates in stages.items() for name, gate in gates.items()]
    gates = [gate for _, _, gate in rows]
    columns = {
        "simulator": html.texts([when for when, _, _ in rows]),
        "test": html.texts([name for _, name, _ in rows]),
        "statistic": html.figures([gate.statistic for gate in gates]),
        "degrees of freedom": html.figures([gate.dof for gate in gates]),
        "p": html.figures([gate.p_value for gate in gates], p_value),
        "sides": html.texts([words.SIDES[gate.sides] for gate in gates]),
        "share": html.figures([gate.share for gate in gates]),
        "corrected p": html.figures([gate.corrected for gate in gates], p_value),
    }
    text = (
        "The simulator against the measurement. Each test has a share of the error rate; a corrected p is p divided by "
        f"that share. A test rejects the simulator if its corrected p is below {diagnosis.alpha:g}."
    )
    return html.Table.of("tests", "Goodness of fit", text, columns)


def _of_tables(diagnosis: Diagnosis) -> html.Table:
    tables = diagnosis.tables
    columns = {
        "table": html.texts([table.name for table in tables]),
        "χ² before": html.figures([table.chi_squared_before for table in tables]),
        "χ² after": html.figures([table.chi_squared_after for table in tables]),
        "degrees of freedom": html.figures([table.dof for table in tables]),
    }
    text = "Each table as it is published beside the fitted simulator, without effects and with those that were added."
    return html.Table.of("tables", "Tables", text, columns)


def _regions(diagnosis: Diagnosis) -> html.Table:
    regions = diagnosis.regions
    columns = {
        "feature": html.texts([region.feature or "-" for region in regions]),
        "from": html.figures([region.low for region in regions], _limit),
        "to": html.figures([region.high for region in regions], _limit),
        "unit": html.texts([_unit(region.unit) for region in regions]),
        "kind": html.texts([region.kind for region in regions]),
        "sigma": html.figures([region.z for region in regions], "{:+.1f}".format),
        "global p": html.figures([region.p_global for region in regions], _drawn),
    }
    if all(region.unit == "1" for region in regions):
        del columns["unit"]
    text = "Where they differ, by the two-sided p of the largest such difference anywhere."
    return html.Table.of("regions", "Where", text if regions else "No region stands out.", columns)


def _drawn(p: float) -> str:
    """A p-value by random draws, which cannot tell how small one is that no draw reached."""
    return f"< {1 / TEST.draws:g}" if p <= 1 / TEST.draws else number(p)


def _limit(value: float | None) -> str:
    """A limit of a region with its own decimals: one near an edge differs from it in the fourth."""
    return "-" if value is None else f"{value:.5g}"


def _candidates(diagnosis: Diagnosis) -> html.Table:
    candidates = sorted(diagnosis.candidates, key=lambda candidate: candidate.score)
    columns = {
        "effect": html.texts([words.label(candidate) for candidate in candidates]),
        "score": html.figures([candidate.score for candidate in candidates]),
        "p": html.figures([candidate.p_value for candidate in candidates], p_value),
        "held-out χ²/ndf": html.figures([candidate.held_out_gap for candidate in candidates]),
    }
    text = "Each added alone to the simulator; a lower score is better. p is one-sided, of the summary that was fitted."
    return html.Table.of("candidates", "Effects that were tried", text, columns)


def _identifiability(diagnosis: Diagnosis) -> html.Table:
    card = diagnosis.identifiability
    columns = {
        "effect": html.texts([words.label(row) for row in card]),
        "signal left once θ is fitted": html.figures([row.retained for row in card]),
        "smallest strength seen": html.figures([row.minimum_detectable for row in card]),
        "change of θ if it is there unseen": html.texts(
            [", ".join(f"{name} {number(bias)}" for name, bias in row.theta_bias.items()) for row in card]
        ),
        "at the strength": html.figures([row.theta_bias_at for row in card]),
        "cannot be told from": html.texts([", ".join(map(words.label, row.rivals)) for row in card]),
    }
    text = (
        "The smallest strength of each effect that these data would have shown. Where there is none, no strength up to "
        "the one in the column of θ is seen; where that has none either, the simulated events did not suffice to tell."
    )
    return html.Table.of("identifiability", "What these data could not have shown", text, columns)
