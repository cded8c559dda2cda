"""The page of pictures of real data: `python -m paper.gallery` diagnoses them, draws, and writes docs/gallery.md."""

import importlib
from pathlib import Path
from typing import Any

import matplotlib

import avobench
from avobench.bench.plugins import user_files
from avobench.bench.store.files import write_file
from paper.studies.real import EXAMPLES, read
from paper.tables.real import judged

PAGE = Path("docs/gallery.md")
PICTURES = Path("docs/figures/gallery")
RESOLUTION = 70
"""Dots per inch of a picture, which then takes less than 60 kB."""
INTRODUCTION = """\
# Gallery

Ten measured data sets, each with a simple simulator. The literature knows what each simulator lacks, or that it lacks
nothing. The pictures are what `avobench.diagnose(task, measured).plot()` draws; the gap is 1 where nothing is missing.
[Real data](real-data.md) has the sources, the numbers, and how each answer was judged."""


def page(records: list[dict[str, Any]]) -> str:
    """The page as Markdown, from the records of the study of real data with one seed."""
    sections = [INTRODUCTION]
    for record in records:
        name, expected = record["name"], record["expected"]
        title, picture = name.replace("_", " ").capitalize(), PICTURES.relative_to(PAGE.parent) / f"{name}.png"
        sections += [
            f"## {title}",
            f"Measured: {expected['measured']}. The simulator lacks {expected['lacks']}. "
            f"The diagnosis said: {answer(record['diagnosis'])} ({judged(expected, record['diagnosis'])}). "
            f"[Its file](../{EXAMPLES}/{name}.py).",
            f"![{title}: measured and simulated events]({picture})",
        ]
    return "\n\n".join(sections) + "\n"


def answer(diagnosis: dict[str, Any]) -> str:
    """The verdict, with the effects that were named and those that the data do not tell from them."""
    named = [
        f"`{effect['name']}`" + "".join(f" or `{tie['name']}`" for tie in effect["tied_with"])
        for effect in diagnosis["effects"]
    ]
    return ": ".join([diagnosis["verdict"], *([" and ".join(named)] if named else [])])


def main() -> None:
    matplotlib.use("Agg")  # draws without a window
    PICTURES.mkdir(exist_ok=True)
    for path in sorted(EXAMPLES.glob("*.py")):
        example = importlib.import_module(user_files.module_name(path))
        figure = avobench.diagnose(example.task, example.measured).plot()
        figure.savefig(PICTURES / f"{path.stem}.png", dpi=RESOLUTION)
    write_file(PAGE, page(read()).encode())


if __name__ == "__main__":
    main()
