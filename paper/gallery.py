"""The page of pictures of real data: `python -m paper.gallery` diagnoses them, draws, and writes docs/gallery.md."""

import importlib
import textwrap
from pathlib import Path
from typing import Any

import matplotlib

import avobench
from avobench.bench.plugins import user_files
from avobench.bench.store.files import write_file
from paper.studies.real import EXAMPLES, read
from paper.tables.real import judged

PAGE = Path("docs/gallery.md")
RESOLUTION = 70
"""Dots per inch, with which each picture takes less than 60 kB."""
INTRODUCTION = """\
# Gallery

Ten measured data sets, each with a simple simulator. The literature knows what each simulator lacks, or that it lacks
nothing. The pictures are what `avobench.diagnose(task, measured).plot()` draws. [Real data](real-data.md) has the
sources, the numbers, and how each answer was judged."""


def page(records: list[dict[str, Any]]) -> str:
    """The page as Markdown, from the records of the study of real data with one seed."""
    sections = [INTRODUCTION]
    for record in records:
        name, expected, diagnosis = record["name"], record["expected"], record["diagnosis"]
        title = name.replace("_", " ").capitalize()
        about = f"Measured: {expected['measured']}. The simulator lacks {expected['lacks']}. "
        about += f"The diagnosis said: {answer(diagnosis)}, which is {judged(expected, diagnosis)}. "
        about = textwrap.fill(f"{about}[The file](../{EXAMPLES}/{name}.py).", 120, break_on_hyphens=False)
        sections += [f"## {title}", about, f"![Measured and simulated events: {title}](figures/gallery/{name}.png)"]
    return "\n\n".join(sections) + "\n"


def answer(diagnosis: dict[str, Any]) -> str:
    """The verdict, with the effects that were named and those that the data do not tell from them."""
    named = [" or ".join(f"`{e['name']}`" for e in (effect, *effect["tied_with"])) for effect in diagnosis["effects"]]
    return ": ".join([diagnosis["verdict"], *([" and ".join(named)] if named else [])])


def main() -> None:
    """Draw all pictures and write the page."""
    matplotlib.use("Agg")  # draws without a window
    for path in sorted(EXAMPLES.glob("*.py")):
        example = importlib.import_module(user_files.module_name(path))
        figure = avobench.diagnose(example.task, example.measured).plot()
        figure.savefig(PAGE.parent / "figures" / "gallery" / f"{path.stem}.png", dpi=RESOLUTION)
    write_file(PAGE, page(read()).encode())


if __name__ == "__main__":
    main()
