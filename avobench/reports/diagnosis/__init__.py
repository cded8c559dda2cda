"""A diagnosis for the eye: figures, and one page that holds them and every number."""

from pathlib import Path

from avobench.bench.atomic import write_atomically
from avobench.diagnosis import Result
from avobench.reports.diagnosis.figures import FIGURE, draw
from avobench.reports.diagnosis.page import Shown, render
from avobench.tasks import Task

__all__ = ["write"]


def write(task: Task, result: Result, folder: Path, title: str) -> list[Path]:
    """Write the figures and `report.html` to the folder, each file whole or not at all; the page comes last.

    Figures of another diagnosis that this one does not have are removed from the folder. `result` is as `diagnose`
    returns it; `title` may be any text.
    """
    paths, shown = [], []
    for figure in draw(task, result.diagnosis, result.pictures):
        saved = figure.save(folder)
        paths += saved
        (png,) = (path for path in saved if path.suffix == ".png")
        shown.append(Shown(figure.name, figure.caption, png.read_bytes()))
    for path in folder.iterdir():
        if FIGURE.fullmatch(path.name) and path not in paths:
            path.unlink()
    page = render(task, result, shown, title)
    return [*paths, write_atomically(folder / "report.html", page.encode())]
