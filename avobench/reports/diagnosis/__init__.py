"""A diagnosis for the eye: figures, and one page that holds them and every number."""

from pathlib import Path

from avobench.bench.store.files import write_atomically
from avobench.diagnosis import Result
from avobench.reports.diagnosis.drawn import Drawn
from avobench.reports.diagnosis.figures import FIGURE, drawings
from avobench.reports.diagnosis.page import render
from avobench.reports.html import Missing, Picture, made
from avobench.reports.style import save
from avobench.tasks import Task

__all__ = ["write"]


def write(task: Task, result: Result, folder: Path, title: str) -> list[Path]:
    """Write the figures and `report.html` to the folder, each file whole or not at all; the page comes last.

    Figures of another diagnosis that this one does not have are removed from the folder, and a figure that cannot be
    drawn is a sentence in its place. `result` is as `diagnose` returns it; `title` may be any text.
    """
    paths, shown = [], []
    for name, drawing in drawings(task, result.diagnosis, result.pictures):
        saved = made(name, lambda drawing=drawing: _saved(drawing(), folder))
        if isinstance(saved, Missing):
            shown.append(saved)
        else:
            files, picture = saved
            paths += files
            shown.append(picture)
    for path in folder.iterdir():
        if FIGURE.fullmatch(path.name) and path not in paths:
            path.unlink()
    title = title.encode(errors="replace").decode()  # the name of a file need not be text
    page = render(task, result, shown, title)
    return [*paths, write_atomically(folder / "report.html", page.encode())]


def _saved(drawn: Drawn, folder: Path) -> tuple[list[Path], Picture]:
    """Write a figure; its files, and what the page shows of it."""
    paths = save(drawn.figure, drawn.table, folder, drawn.name)
    (png,) = (path for path in paths if path.suffix == ".png")
    return paths, Picture(drawn.name, drawn.caption, png.read_bytes())
