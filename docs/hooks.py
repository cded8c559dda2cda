"""Hooks of MkDocs: files from outside docs/, pictures of effects, formulas as MathML, no page that needs a network."""

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
PAGES = {"../CHANGELOG.md": "changelog.md", "../CONTRIBUTING.md": "contributing.md"}
"""Pages of the site that the repository keeps in its root, where readers of the repository expect them."""
EXAMPLES = [path for suffix in ("ipynb", "py", "csv", "json") for path in (ROOT / "examples").rglob(f"*.{suffix}")]
FILES = ["CITATION.cff", *(path.relative_to(ROOT).as_posix() for path in EXAMPLES)]
"""Files of the repository that pages link to, and that the site offers as they are."""
EFFECTS = re.compile(r"^<!-- effects of: (\S+) -->$", re.MULTILINE)
PICTURES = "figures/effects"
"""`make docs` draws a picture of each family into this folder. The build warns where one is missing."""
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FETCHED = re.compile(r"""<(?:script|img|iframe|source)[^>]+src=["']?https?:[^>]+|<link[^>]+href=["']?https?:[^>]+""")
"""What a browser fetches by itself, which a link is not."""


def on_startup(**_) -> None:
    """Let matplotlib draw without a window."""
    matplotlib.use("Agg")


def on_files(files: Files, config) -> Files:
    """Add the pages and files from outside the folder of pages."""
    for source, name in PAGES.items():
        text = (ROOT / "docs" / source).read_text().replace("](docs/", "](")
        for other, page in PAGES.items():
            text = text.replace(f"]({other.removeprefix('../')})", f"]({page})")
        files.append(File.generated(config, name, content=text))
    for name in FILES:
        files.append(File.generated(config, name, abs_src_path=str(ROOT / name)))
    return files


def on_page_markdown(markdown: str, **_) -> str:
    """Let links out of docs/ lead to their places on the site, and show the effects of each task that is asked for."""
    for source, name in {**PAGES, **{f"../{name}": name for name in FILES}}.items():
        markdown = markdown.replace(f"]({source})", f"]({name})")
    shown: set[tuple[str, str]] = set()
    return EFFECTS.sub(lambda comment: effects_of(comment[1], shown), markdown)


def on_page_content(html: str, **_) -> str:
    """Replace formulas by MathML, which browsers show without a script."""
    return FORMULA.sub(lambda found: convert(found[2], display="inline" if found[1] == "span" else "block"), html)


def on_post_page(output: str, page, **_) -> str:
    """Return the page unchanged. Raises PluginError if a browser would fetch a part of it from another machine."""
    fetched = [tag for tag in FETCHED.findall(output) if 'rel="canonical"' not in tag]
    if fetched:
        raise PluginError(f"{page.file.src_uri} needs a network: {fetched[0]}")
    return output


def effects_of(spec: str, shown: set[tuple[str, str]]) -> str:
    """The catalogue of a task as Markdown, without the (domain, family) that were shown already; adds to these."""
    task = registry.build("task", spec, {})
    parts = []
    for family, effects in families(spec).items():
        if (domain(task), family) not in shown:
            parts.append(f"### {family}\n\n{described(effects, task.name)}")
        shown.add((domain(task), family))
    return "\n\n".join(parts)


def families(task: str) -> dict[str, list[Effect]]:
    """The effects that apply to a task, by name, in the order of the catalogue."""
    by_name: dict[str, list[Effect]] = {}
    for effect in catalogue(registry.build("task", task, {})):
        by_name.setdefault(effect.name, []).append(effect)
    return by_name


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
    """The attribute that shows a PNG at half its pixels, which is sharp on any screen; empty where there is none."""
    if not picture.exists():
        return ""
    width = int.from_bytes(picture.read_bytes()[16:20], "big")
    return f'{{ width="{width // 2}" }}'
