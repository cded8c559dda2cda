"""The parts of a page: tables, figures, and the one document around them, which needs no network."""

import base64
import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup

from avobench.reports import numbers
from avobench.tasks.errors import AvobenchError

CHOICES = ("task", "method", "status", "verdict")
"""Columns with few different values: a table can be narrowed to one of them."""
LONG = 22
"""A text of more letters may be broken into lines; a name or a date stays in one."""
PNG_WIDTH = slice(16, 20)
"""The bytes of a PNG that say how many pixels wide it is."""
T = TypeVar("T")


@dataclass(frozen=True)
class Cell:
    """A cell of a table: the text shown, and the value by which it is sorted, empty where there is none."""

    text: str
    value: str
    number: bool = False

    @property
    def look(self) -> str:
        """The class by which the style tells numbers, which are aligned, names and sentences apart."""
        return "number" if self.number else "long" if len(self.text) > LONG else "short"


@dataclass(frozen=True)
class Table:
    """A table with a heading and a sentence about it; `csv` is an address of its download, or empty."""

    id: str
    title: str
    text: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    csv: str = ""

    @classmethod
    def of(cls, id: str, title: str, text: str, columns: Mapping[str, Sequence[Cell]], csv: str = "") -> "Table":
        return cls(id, title, text, list(columns), list(zip(*columns.values(), strict=True)), csv)


@dataclass(frozen=True)
class Picture:
    """A figure of a page; `csv` is an address of the numbers that it shows, or empty."""

    name: str
    caption: str
    png: bytes
    csv: str = ""

    @property
    def image(self) -> str:
        return address("image/png", self.png)

    @property
    def width(self) -> int:
        """Half its pixels, so that it is sharp on a fine screen."""
        return int.from_bytes(self.png[PNG_WIDTH]) // 2


@dataclass(frozen=True)
class Missing:
    """The sentence in the place of a figure or a table that could not be made."""

    name: str
    reason: str


def made(name: str, make: Callable[[], T]) -> T | Missing:
    """Return what `make` returns, or, if it fails, why there is no such figure or table.

    What users' tasks and methods left may fail anywhere; what concerns the disk is left to the caller.
    """
    try:
        return make()
    except OSError:
        raise
    except AvobenchError as error:
        return Missing(name, str(error))
    except Exception as error:
        return Missing(name, f"{type(error).__name__}: {error}")


def texts(values: Iterable[str]) -> list[Cell]:
    return [Cell(value, value) for value in values]


def figures(values: Sequence[float | None], render: Callable[[Any], str] | None = None) -> list[Cell]:
    """A column of numbers, each as `render` writes it, by default with as many decimals in each row."""
    rendered = numbers.column(values) if render is None else map(render, values)
    return [Cell(text, key(value), True) for text, value in zip(rendered, values, strict=True)]


def key(value: float | None) -> str:
    """The number by which JavaScript sorts a cell."""
    missing = value is None or math.isnan(value)
    return "" if missing else str(value).replace("inf", "Infinity")


def column(values: pd.Series) -> list[Cell]:
    """The cells of a column of a data frame: numbers if every value that is not missing is one."""
    cleaned = [None if pd.api.types.is_scalar(value) and pd.isna(value) else value for value in values]
    if any(isinstance(value, bool) or not isinstance(value, Real | None) for value in cleaned):
        return [Cell("-", "") if value is None else Cell(str(value), str(value)) for value in cleaned]
    whole = all(value is None or float(value).is_integer() for value in cleaned)
    return figures([None if value is None else int(value) if whole else float(value) for value in cleaned])


def address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def page(template: str, **content: Any) -> str:
    """The document of a template beside this module, or below it; whatever `content` holds is shown as text."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["breakable"] = lambda name: Markup("_<wbr>").join(name.split("_"))
    environment.tests["missing"] = lambda value: isinstance(value, Missing)
    script = environment.get_template("tables.js.jinja").render()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return environment.get_template(template).render(
        **content, script=Markup(script), script_hash=f"sha256-{digest}", choices=CHOICES
    )
