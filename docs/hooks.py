"""What MkDocs asks when it builds the site: the page of effects, formulas as MathML, no page that needs a network."""

import re
from pathlib import Path

import matplotlib
from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

from avobench.bench.plugins import registry
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.contract import Effect

ROOT = Path(__file__).parents[1]
FROM_THE_ROOT = {"changelog.md": "CHANGELOG.md", "contributing.md": "CONTRIBUTING.md"}
"""Pages of the site that stand where whoever looks at the repository expects them."""
DOMAINS = {
    "Continuous features": ("carl", "Such as energies and angles. An effect acts on one feature, or on all alike."),
    "Features without negative values": (
        "avobench.tasks.decays:DECAYS",
        "Such as times and masses. These act on them beside what acts on any continuous feature.",
    ),
    "Counts": ("poisson", "Such as the pulses in an interval. An effect acts on one count, or on all of them alike."),
    "Images": ("alignment", "Hits in the cells of a detector. Some effects act on the particles that make them."),
}
"""Kinds of events, a task with a catalogue of each, and what they are. What was shown already is not shown again."""
PICTURES = "figures/effects"
"""Where `make docs` has `avobench effects draw` put one for each family: the build warns of one that is not there."""
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FETCHED = re.compile(r"""<(?:script|img|iframe|source)[^>]+src=["']?https?:[^>]+|<link[^>]+href=["']?https?:[^>]+""")
"""What a browser fetches by itself: not a link, which somebody has to follow."""


def on_startup(**_) -> None:
    """Draw without a window."""
    matplotlib.use("Agg")


def on_files(files: Files, config) -> Files:
    """Add the pages that no file of the folder holds."""
    for name, source in FROM_THE_ROOT.items():
        text = (ROOT / source).read_text().replace("](docs/", "](")
        for target, at_the_root in FROM_THE_ROOT.items():
            text = text.replace(f"]({at_the_root})", f"]({target})")
        files.append(File.generated(config, name, content=text))
    files.append(File.generated(config, "effects.md", content=effects_page()))
    return files


def on_page_content(html: str, **_) -> str:
    """The page with its formulas as MathML, which browsers show without a script."""
    return FORMULA.sub(lambda found: convert(found[2], display="inline" if found[1] == "span" else "block"), html)


def on_post_page(output: str, page, **_) -> str:
    """The page as it is. Raises PluginError if a browser would fetch something for it from another machine."""
    fetched = [tag for tag in FETCHED.findall(output) if 'rel="canonical"' not in tag]
    if fetched:
        raise PluginError(f"{page.file.src_uri} needs a network: {fetched[0]}")
    return output


def effects_page() -> str:
    """The catalogue of effects as Markdown: of each what it does, its shapes and parameters, and its source."""
    parts = [
        "# Effects: what a simulator may lack",
        "This page is written from the catalogue that `avobench diagnose` tries. Each effect is a *family*: it has "
        "several shapes, since a real effect never has the exact shape of one, and a diagnosis takes the shape "
        "that fits best. "
        "The pictures show each shape at a middling strength, beside the events without the effect; a click enlarges. "
        "`avobench list effects --task NAME` gives the bounds for another task. If what you look for is not here, "
        "[add it](add-an-effect.md): it takes one class.",
    ]
    shown = set()
    for title, (spec, what) in DOMAINS.items():
        parts += [f"## {title}", what]
        task = registry.build("task", spec, {})
        for family, effects in families(spec).items():
            if (domain(task), family) not in shown:
                parts.append(f"### {family}\n\n{described(effects, task.name)}")
            shown.add((domain(task), family))
    return "\n\n".join(parts) + "\n"


def families(task: str) -> dict[str, list[Effect]]:
    """The effects that apply to a task, by name, in the order of the catalogue."""
    found: dict[str, list[Effect]] = {}
    for effect in catalogue(registry.build("task", task, {})):
        found.setdefault(effect.name, []).append(effect)
    return found


def described(effects: list[Effect], task: str) -> str:
    """One family: its sentence, its picture, a table of its parameters with the shapes that have them, its source."""
    shapes = {shape.shape: shape for effect in effects for shape in effect.shapes()}
    having: dict[str, list[str]] = {}
    for label, shape in shapes.items():
        for p in shape.parameters:
            having.setdefault(f"{p.name} | {p.low:.3g} to {p.high:.3g} | {p.unit}", []).append(label)
    rows = [
        f"| {parameter} | {'all' if len(labels) == len(shapes) else ', '.join(labels)} |"
        for parameter, labels in having.items()
    ]
    name = effects[0].name
    picture = f"{PICTURES}/{task}-{name.replace('_', '-')}.png"
    shown = f"[![Events of {task} without and with {name}]({picture}){half_size(ROOT / 'docs' / picture)}]({picture})"
    lines = [effects[0].sentence, "", shown, ""]
    if len(shapes) > 1:
        lines += [f"Shapes: {', '.join(filter(None, shapes))}.", ""]
    lines += ["| parameter | range | unit | shapes |", "|---|---|---|---|", *rows, "", f"Source: {effects[0].source}."]
    return "\n".join(lines)


def half_size(picture: Path) -> str:
    """The attribute that shows a PNG at half its pixels, which is sharp on any screen; nothing where there is none."""
    if not picture.exists():
        return ""
    width = int.from_bytes(picture.read_bytes()[16:20], "big")
    return f'{{ width="{width // 2}" }}'
