"""The page of a diagnosis: one file that needs no network and runs no script."""

import base64
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader

from avobench.diagnosis import Result
from avobench.diagnosis.schema import Verdict
from avobench.reports.diagnosis.figures import label
from avobench.tasks import Task

MEANING = {
    Verdict.NOTHING: "These data do not contradict the simulator. Below stands what they could not have shown.",
    Verdict.NAMED: "The simulator lacks what follows. With it, simulation and measurement agree.",
    Verdict.REDUCED: "The effect below closes a part of the gap; what is left is still significant.",
    Verdict.UNEXPLAINED: "Simulation and measurement disagree, and no effect of the catalogue says why.",
}


@dataclass(frozen=True)
class Shown:
    """A figure of the page, shown at half its pixels so that it is sharp."""

    name: str
    caption: str
    png: bytes

    @property
    def image(self) -> str:
        """As the address of an image that needs no file."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode()

    @property
    def width(self) -> int:
        return int.from_bytes(self.png[16:20]) // 2  # where a PNG says it


def render(task: Task, result: Result, figures: list[Shown], title: str) -> str:
    """The page as HTML; whatever comes from the user, such as the title, is shown as text."""
    template = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True, lstrip_blocks=True
    ).get_template("page.html.jinja")
    diagnosis, added = result.diagnosis, result.fit.model.effects
    return template.render(
        title=title,
        task=task,
        diagnosis=diagnosis,
        meaning=MEANING[diagnosis.verdict],
        figures=figures,
        sentences={effect.name: effect.sentence for effect in added},
        candidates=sorted(diagnosis.candidates, key=lambda candidate: candidate.score),
        label=label,
        number=_number,
        value=_value,
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _value(fitted: Any) -> str:
    """A value with its error, as far as one is known."""
    return _number(fitted.value) if fitted.std is None else f"{fitted.value:.4g} ± {fitted.std:.2g}"
